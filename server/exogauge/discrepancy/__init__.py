"""Where simulation and measurement disagree, which missing effect explains it, and how far the gap shrinks with it."""
