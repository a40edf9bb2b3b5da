"""One search over one problem: screen candidates, refine, validate, add, prune, correct."""
