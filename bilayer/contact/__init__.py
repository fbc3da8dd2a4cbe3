"""Self-contact of a released body."""
