"""From a target shape to a specimen that takes it, and to what has to be cut for it."""
