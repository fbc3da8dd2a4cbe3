"""The loads along a path: from the unstretched flat state through the targets of the prestretch.

Its parameter is the length of the way so far, measured by the change of the prestretch; so it grows
also on the way down. The true weight comes on before the prestretch, over a way of its own. The
symmetry-breaking load vanishes at every target, so each is an equilibrium of the specimen as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.prestretch import StretchPair

SHORTEST_FIRST_STRETCH = 1e-3
WEIGHT_WAY = 0.02
"""Over which the weight comes on, as long as a change of the prestretch by this."""


@dataclass(frozen=True)
class LoadPlace:
    """The loads at a place on the path.

    Parameters
    ----------
    stretch : (float, float)
        (lambda_x, lambda_y).
    weight, imperfection : float
        Parts of the true weight and of the symmetry-breaking load that act.
    """

    stretch: StretchPair
    weight: float
    imperfection: float


class LoadSchedule:
    """Piecewise linear path of (lambda_x, lambda_y) from (1, 1) through targets in any order.

    Parameters
    ----------
    targets : sequence of (float, float)
        Prestretch at each.
    weight_way : float
        Length of the way over which the weight comes on, before the prestretch; 0 without weight.
    """

    def __init__(self, targets: Sequence[StretchPair] = (), *, weight_way: float = 0.0) -> None:
        self._stretches = np.array([(1.0, 1.0), (1.0, 1.0)])
        self._ends = np.array([0.0, weight_way])
        for target in targets:
            self.add_target(target)

    def add_target(self, target: StretchPair) -> float:
        """Go on to another target; return its parameter."""
        length = float(np.abs(np.subtract(target, self._stretches[-1])).max())
        if len(self._ends) == 2:
            length = max(length, SHORTEST_FIRST_STRETCH)  # a way for the imperfection to go
        self._stretches = np.vstack([self._stretches, target])
        self._ends = np.append(self._ends, self._ends[-1] + length)
        return float(self._ends[-1])

    def leave_at(self, parameter: float) -> None:
        """Go on from a place before the last target, which the path has not come to."""
        here, stretch = parameter, self.stretch(parameter)
        kept = self._ends <= here
        kept[:2] = True  # flat, and where the weight is on
        self._ends, self._stretches = self._ends[kept], self._stretches[kept]
        if here > self.end:
            self._ends = np.append(self._ends, here)
            self._stretches = np.vstack([self._stretches, stretch])

    @property
    def milestones(self) -> list[float]:
        """Path parameter of each target."""
        return [float(end) for end in self._ends[2:]]

    @property
    def targets(self) -> NDArray[np.float64]:
        """(lambda_x, lambda_y) at each target, (n, 2)."""
        return self._stretches[2:]

    @property
    def end(self) -> float:
        """Parameter of the last target; where the weight is on, if there is none."""
        return float(self._ends[-1])

    @property
    def last(self) -> StretchPair:
        """(lambda_x, lambda_y) at the last target; (1, 1) if there is none."""
        x, y = self._stretches[-1]
        return float(x), float(y)

    @property
    def turns_back(self) -> bool:
        """Whether the way to the last target leads back the way to the one before."""
        before, after = np.diff(self._stretches[-3:], axis=0)
        opposite = before @ after < 0
        cosine_squared = (before @ after) ** 2 / max((before @ before) * (after @ after), 1e-300)
        return bool(opposite and cosine_squared > 1 - 1e-12)

    def place(self, parameter: float) -> LoadPlace:
        """Return the loads at a parameter."""
        return LoadPlace(
            self.stretch(parameter),
            self.weight_fraction(parameter),
            self.imperfection_fraction(parameter),
        )

    def stretch(self, parameter: float) -> StretchPair:
        """Return (lambda_x, lambda_y) at a parameter."""
        x, y = (np.interp(parameter, self._ends, component) for component in self._stretches.T)
        return float(x), float(y)

    def weight_fraction(self, parameter: float) -> float:
        """Return the part of the true weight that acts; it grows to 1 before the prestretch."""
        way = self._ends[1]
        return min(1.0, parameter / way) if way > 0 else 1.0

    def imperfection_fraction(self, parameter: float) -> float:
        """Return the part of the symmetry-breaking load that acts: 0 at every target.

        It falls to the first and swells between the others, so that a path which branches on the
        way turns smoothly onto the branch of less energy.
        """
        ends = np.delete(self._ends, 1)
        segment = int(np.searchsorted(ends[1:-1], parameter))
        begin, end = ends[segment : segment + 2]
        share = float(np.clip((parameter - begin) / (end - begin), 0.0, 1.0))
        return 1.0 - share if segment == 0 else 4 * share * (1 - share)
