"""Whole services killed at random moments."""
