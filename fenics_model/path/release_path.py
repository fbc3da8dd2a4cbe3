"""The load path: from the unstretched flat state through the milestones of the prestretch.

Its parameter is the change of prestretch along the path. The true weight comes on before, over a
way of its own. The symmetry-breaking load vanishes at the first milestone, so every milestone is
an equilibrium of the specimen as it is.
"""

from collections.abc import Sequence

import numpy as np

SHORTEST_FIRST_STRETCH = 1e-3
WEIGHT_WAY = 0.02
"""Over which the weight comes on, as long as a change of the prestretch by this."""


class ReleasePath:
    """Piecewise linear path of (lambda_x, lambda_y) from (1, 1) through the milestones.

    Parameters
    ----------
    milestones : sequence of (float, float)
        Prestretch at each milestone.
    weight_way : float
        Length of the way over which the weight comes on, before the prestretch; 0 without weight.
    """

    def __init__(
        self, milestones: Sequence[tuple[float, float]], *, weight_way: float = 0.0
    ) -> None:
        self._stretches = np.array([(1.0, 1.0), (1.0, 1.0), *milestones])
        lengths = np.abs(np.diff(self._stretches, axis=0)).max(axis=1)
        lengths[0] = weight_way
        lengths[1] = max(lengths[1], SHORTEST_FIRST_STRETCH)  # a way for the imperfection to go
        self._ends = np.concatenate([[0.0], np.cumsum(lengths)])

    @property
    def milestones(self) -> list[float]:
        """Path parameter of each milestone."""
        return [float(end) for end in self._ends[2:]]

    def stretch(self, parameter: float) -> tuple[float, float]:
        """(lambda_x, lambda_y) at a parameter."""
        x, y = (np.interp(parameter, self._ends, component) for component in self._stretches.T)
        return float(x), float(y)

    def weight_fraction(self, parameter: float) -> float:
        """Part of the true weight that acts: grows to 1 before the prestretch does."""
        way = self._ends[1]
        return min(1.0, parameter / way) if way > 0 else 1.0

    def imperfection_fraction(self, parameter: float) -> float:
        """Part of the symmetry-breaking load that acts: 0 at every milestone.

        It falls to the first and swells between the others, so that a path which branches on the
        way turns smoothly onto the branch of less energy.
        """
        ends = np.delete(self._ends, 1)
        segment = int(np.searchsorted(ends[1:-1], parameter))
        begin, end = ends[segment : segment + 2]
        share = float(np.clip((parameter - begin) / (end - begin), 0.0, 1.0))
        return 1.0 - share if segment == 0 else 4 * share * (1 - share)
