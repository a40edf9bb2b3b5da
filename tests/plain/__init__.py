"""Studies in which nothing is missing: what the defaults make of the plainest logs there are (`make plain`)."""
