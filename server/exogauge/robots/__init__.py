"""The body: the tree of links, its regressor, its parameters and what makes them physically possible."""
