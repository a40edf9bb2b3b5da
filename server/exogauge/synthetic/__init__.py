"""Synthetic studies from MuJoCo. Imports nothing of the code that evaluates them."""
