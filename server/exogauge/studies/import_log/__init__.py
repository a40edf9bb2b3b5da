"""A foreign log becomes a mapping: what its columns may be."""
