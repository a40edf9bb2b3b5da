"""The blind benchmark: studies with effects hidden in them, what an evaluation says of them, and how often it is right.

`generator` writes the cases and the sealed answers and imports nothing of what evaluates; `run` evaluates and never
opens an answer; `score` compares the two.
"""
