"""Surfaces in space, their alignment and distances; nothing of specimens or meshes."""
