"""What differs between dolfinx 0.9, 0.10 and 0.11, and nothing else: the one edge to their APIs."""

from typing import Any

import dolfinx
import numpy as np
from dolfinx import fem

VERSION = tuple(int(part) for part in dolfinx.__version__.split(".")[:2])


def create_mesh(comm: Any, cells: np.ndarray, points: np.ndarray, domain: Any) -> Any:
    """Distribute a mesh; 0.10 swapped the last two arguments of dolfinx's function."""
    if VERSION < (0, 10):
        return dolfinx.mesh.create_mesh(comm, cells, points, domain)
    return dolfinx.mesh.create_mesh(comm, cells, domain, points)


def interpolation_points(space: Any) -> np.ndarray:
    """Points of a space's element where functions are evaluated; a property since 0.10."""
    points = space.element.interpolation_points
    return points() if callable(points) else points


def compiled_expression(expression: Any, space: Any, jit_options: dict[str, Any]) -> fem.Expression:
    """Compile an expression for interpolation into a space."""
    return fem.Expression(expression, interpolation_points(space), jit_options=jit_options)
