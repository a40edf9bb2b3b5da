"""Motions from which a robot is identified well: planned within every bound, with what they will tell."""
