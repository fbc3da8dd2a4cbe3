"""A measured part against the shapes of a result."""
