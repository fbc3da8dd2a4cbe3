"""All differences between dolfinx 0.9, 0.10 and 0.11 and their PETSc, and nothing else.

The calls that are the same in all three are made where they are needed, with the arguments that
were renamed (`diagonal`, `diag`) left at their defaults.
"""

from typing import Any

import dolfinx
import numpy as np
from numpy.typing import NDArray

VERSION = tuple(int(part) for part in dolfinx.__version__.split(".")[:2])


def create_mesh(
    comm: Any, cells: NDArray[np.int64], points: NDArray[np.float64], domain: Any
) -> Any:
    """Distribute a mesh; 0.10 swapped the last two arguments of dolfinx's function."""
    if VERSION < (0, 10):
        return dolfinx.mesh.create_mesh(comm, cells, points, domain)
    return dolfinx.mesh.create_mesh(comm, cells, domain, points)


def geometry_dofmap(mesh: Any) -> NDArray[np.int32]:
    """Geometry nodes of each cell, shape (cells, 4); 0.11 has one such map per cell type."""
    if VERSION < (0, 11):
        return np.asarray(mesh.geometry.dofmap)
    return np.asarray(mesh.geometry.dofmaps[0])
