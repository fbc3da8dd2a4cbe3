"""Contact of the solid: its skin, and the barrier in its residual and tangent."""
