"""Motions that would tell apart what these data cannot."""
