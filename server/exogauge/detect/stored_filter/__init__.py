"""Signals that were low-passed before they were stored."""
