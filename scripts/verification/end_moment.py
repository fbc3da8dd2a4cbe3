"""A moment at an end that turns in the x-z plane: the potential -M phi of the end's angle phi.

phi is the angle of lines between two nodes, seen along y, so the moment is a couple of forces that
stays perpendicular to the line as it turns. In the plane that is conservative.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EndMoment:
    """A moment shared by lines of two nodes; see `dshell.energies.assembly.Energy`.

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
    def stencils(self) -> list[NDArray[np.int64]]:
        """Places of each line's coordinates in the state, (n, 6)."""
        return [coordinates_of(self.lines).reshape(-1, 6)]

    def at(self, state: Array) -> "_TurnedLines":
        """Return the lines in a state; see `dshell.energies.assembly.Energy`."""
        ends = state[coordinates_of(self.lines)]
        x, _, z = (ends[:, 1] - ends[:, 0]).T
        return _TurnedLines(self, len(state), x, z)


@dataclass(frozen=True, eq=False)
class _TurnedLines:
    load: EndMoment
    size: int
    x: Array  # from the first node of each line to the second
    z: Array

    def energy(self) -> Array:
        """Return -M phi of each line; see `dshell.energies.assembly.Deformed`."""
        about, x, z = self.load.about, self.x, self.z
        c, s = np.cos(about), np.sin(about)
        return -self.load.moments * (about + np.arctan2(-c * z - s * x, c * x - s * z))

    def gradient(self) -> Array:
        """See `dshell.energies.assembly.Deformed`."""
        square = self.x**2 + self.z**2
        by_span = -self.load.moments * np.array([self.z, 0 * self.x, -self.x]) / square
        forces = np.stack([-by_span.T, by_span.T], axis=1)
        return sum_at(coordinates_of(self.load.lines), forces, self.size)

    def hessian(self) -> list[Array]:
        """See `dshell.energies.assembly.Deformed`."""
        both, apart, none = 2 * self.x * self.z, self.x**2 - self.z**2, 0 * self.x
        rows = np.array([[-both, none, apart], [none, none, none], [apart, none, both]])
        by_span = -self.load.moments * rows / (self.x**2 + self.z**2) ** 2
        signs = np.array([[1.0, -1.0], [-1.0, 1.0]])
        return [np.einsum("ab,ijn->naibj", signs, by_span).reshape(len(self.x), 6, 6)]

    def convex_hessian(self) -> list[Array]:
        """Return nothing: half of the eigenvalues are negative, and all of them small."""
        return [np.zeros((len(self.x), 6, 6))]
