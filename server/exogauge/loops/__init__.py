"""Loops over samples, compiled.

Whoever uses one imports it where it is called: loading the compiler takes half a second.
"""
