"""The layered solid: its energy, residual and tangent in UFL."""
