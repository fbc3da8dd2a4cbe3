"""A follower pressure: its work on the volume that the sheet has swept from the flat state.

The volume between a triangle and the origin is that of a tetrahedron, V = a . (b x c) / 6. The
energy of a pressure p is -p V, and its force on a corner p (b x c) / 6. Summed over the triangles
around an inner node these are the forces p A n / 3 of the pressure on the deformed triangles. At
the edge they are so only if it is held level, see `bilayer.mesh.parts.check_pressed`.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at

Array = NDArray[np.float64]


class PressedVolume:
    """The work of a pressure on triangles, a term of each one.

    Parameters
    ----------
    triangles : (m, 3) array of int
        Counterclockwise seen from where a positive pressure pushes to.
    pressure : float
        Pa.
    """

    name: ClassVar[str] = "pressure"

    def __init__(self, triangles: NDArray[np.int64], pressure: float) -> None:
        self.pressure = pressure
        self.dofs = coordinates_of(triangles).reshape(-1, 9)
        self.stencils = [self.dofs]

    def volume(self, state: Array) -> float:
        """Return the volume swept from the flat state, m3."""
        a, b, c = state[self.dofs].reshape(-1, 3, 3).transpose(1, 0, 2)
        return float(np.sum(a * np.cross(b, c)) / 6)

    def at(self, state: Array) -> "PressedTriangles":
        """Return the triangles in a state; see `dshell.energies.assembly.Energy`."""
        return PressedTriangles(self, state)


class PressedTriangles:
    """Triangles under a pressure, in some state."""

    def __init__(self, volume: PressedVolume, state: Array) -> None:
        self._volume, self._size = volume, len(state)
        self._corners = state[volume.dofs].reshape(-1, 3, 3)

    def energy(self) -> Array:
        """Return the energy of each triangle, J."""
        a, b, c = self._corners.transpose(1, 0, 2)
        return np.asarray(-self._volume.pressure / 6 * np.sum(a * np.cross(b, c), axis=1))

    def gradient(self) -> Array:
        """Return the derivative by the state, N."""
        a, b, c = self._corners.transpose(1, 0, 2)
        forces = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        return sum_at(self._volume.dofs, -self._volume.pressure / 6 * forces, self._size)

    def hessian(self) -> list[Array]:
        """Return the second derivative, N/m, (m, 9, 9)."""
        turned = -self._volume.pressure / 6 * _cross_matrices(self._corners)
        a, b, c = turned.transpose(1, 0, 2, 3)
        none = np.zeros_like(a)
        rows = [[none, -c, b], [c, none, -a], [-b, a, none]]  # d(b x c)/db = -[c], /dc = [b]
        return [np.block(rows)]

    def convex_hessian(self) -> list[Array]:
        """Return 0: a volume has no convex part."""
        return [np.zeros((len(self._corners), 9, 9))]


def _cross_matrices(vectors: Array) -> Array:
    """Return the matrices [v] with [v] w = v x w, shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    none = np.zeros_like(x)
    rows = [[none, -z, y], [z, none, -x], [-y, x, none]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
