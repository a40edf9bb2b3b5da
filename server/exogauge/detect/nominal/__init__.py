"""Nominal values of the maker that the logs contradict."""
