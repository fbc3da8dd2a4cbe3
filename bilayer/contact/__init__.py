"""How near a released body comes to itself."""
