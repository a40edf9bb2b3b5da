"""A robot as it moves: on its feet, within every bound, without touching itself."""
