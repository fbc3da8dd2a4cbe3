"""A moment at an end that turns in the x-z plane: the potential -M phi of the end's angle phi.

phi is the angle of lines between two nodes, seen along y, so the moment is a couple of forces that
stays perpendicular to the line as it turns. In the plane that is conservative.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.assembly import coordinates_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EndMoment:
    """A moment shared by lines of two nodes; see `dshell.assembly.Energy`.

    Parameters
    ----------
    lines : (n, 2) array of int
        Nodes.
    moments : (n,) array of float
        Share of each line, N m; positive from x toward -z.
    about : float
        An angle less than half a turn from that of every line: it tells full turns apart.
    """

    name: ClassVar[str] = "moment"
    lines: NDArray[np.int64]
    moments: Array
    about: float

    @property
    def dofs(self) -> NDArray[np.int64]:
        """Places of each line's coordinates in the state, shape (n, 2, 3)."""
        return coordinates_of(self.lines)

    def energy(self, values: Array) -> Array:
        """Return -M phi of each line, J, shape (n,), from nodes of shape (n, 2, 3)."""
        x, z = self._spans(values)
        c, s = np.cos(self.about), np.sin(self.about)
        return -self.moments * (self.about + np.arctan2(-c * z - s * x, c * x - s * z))

    def gradient(self, values: Array) -> Array:
        """Return its derivative, N, shape (n, 2, 3)."""
        x, z = self._spans(values)
        square = x**2 + z**2
        by_span = -self.moments * np.array([z, 0 * x, -x]) / square
        return np.stack([-by_span.T, by_span.T], axis=1)

    def hessian(self, values: Array) -> Array:
        """Return its second derivative, N/m, shape (n, 6, 6)."""
        x, z = self._spans(values)
        both, apart, none = 2 * x * z, x**2 - z**2, 0 * x
        rows = np.array([[-both, none, apart], [none, none, none], [apart, none, both]])
        by_span = -self.moments * rows / (x**2 + z**2) ** 2
        signs = np.array([[1.0, -1.0], [-1.0, 1.0]])
        count = len(self.lines)
        return np.einsum("ab,ijn->naibj", signs, by_span).reshape(count, 6, 6)

    def convex_hessian(self, values: Array) -> Array:
        """Return nothing: half of the eigenvalues are negative, and all of them small."""
        return np.zeros((len(self.lines), 6, 6))

    def _spans(self, values: Array) -> tuple[Array, Array]:
        x, _, z = (values[:, 1] - values[:, 0]).T
        return x, z
