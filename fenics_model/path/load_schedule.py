"""The loads along a path: from the unstretched flat state through the targets of the prestretch.

Its parameter is the length of the way so far, measured by the change of the prestretch; so it grows
also on the way down. The true weight comes on before the prestretch, over a way of its own. The
symmetry-breaking load vanishes at every target, so each is an equilibrium of the specimen as it is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair

Array = NDArray[np.float64]

SHORTEST_FIRST_STRETCH = 1e-3
WEIGHT_WAY = 0.02
"""Over which the weight comes on, as long as a change of the prestretch by this."""
LOAD_WAY = 0.02
"""A change of a load by its largest value counts as a change of the prestretch by this."""


@dataclass(frozen=True)
class LoadPlace:
    """The loads at a place on the path.

    Parameters
    ----------
    stretch : (float, float)
        (lambda_x, lambda_y).
    weight, imperfection : float
        Parts of the true weight and of the symmetry-breaking load that act.
    values : tuple of float
        Of the loads.
    grips : tuple of float
        1 if a displacement is held, or for any other load; 0 if it is free.
    forces : tuple of float
        The share of the force that held a displacement before, while it is let go.
    time : float
        s after the release.
    """

    stretch: StretchPair
    weight: float
    imperfection: float
    values: tuple[float, ...] = ()
    grips: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()
    time: float = 0.0

    @property
    def milestone(self) -> Milestone:
        """The prestretch and the values of the loads, NaN if a displacement is free."""
        held = zip(self.values, self.grips, strict=True)
        return (*self.stretch, *(value if grip else math.nan for value, grip in held))


class LoadSchedule:
    """Piecewise linear path of (lambda_x, lambda_y) from (1, 1) through targets in any order.

    Loads go along, from 0. On the way to a target that holds a displacement it is held, from where
    it is. On the way to one that frees it, the force that held it goes to 0 instead.

    Parameters
    ----------
    targets : sequence of milestones
        Prestretch at each, and the values of the loads.
    scales : sequence of float
        Largest value of each load.
    weight_way : float
        Length of the way over which the weight comes on, before the prestretch; 0 without weight.
    time_way : float
        Least length of a step of time.
    """

    def __init__(
        self,
        targets: Sequence[Milestone] = (),
        *,
        scales: Sequence[float] = (),
        weight_way: float = 0.0,
        time_way: float = 0.0,
    ) -> None:
        self._stretches = np.array([(1.0, 1.0), (1.0, 1.0)])
        self._scales: Array = np.array(scales, dtype=float)
        self._values: Array = np.zeros((2, len(scales)))
        self._grips: Array = np.ones((2, len(scales)))
        self._ends = np.array([0.0, weight_way])
        self._times: Array = np.zeros(2)
        self._time_way = time_way
        for target in targets:
            self.add_target(target)

    def add_target(
        self, target: Milestone, reached: Sequence[float] = (), time: float = 0.0
    ) -> float:
        """Go on to another target; return its parameter.

        Parameters
        ----------
        target : tuple of float
            (lambda_x, lambda_y), then the value of each load, NaN if a displacement is free.
        reached : sequence of float
            The displacements from which the way goes on where they are free now; of other loads it
            is not used.
        time : float
            s after the release; it never falls.
        """
        if len(target) != 2 + len(self._scales):
            raise ValueError(f"target of {len(target)} values, expected {2 + len(self._scales)}")
        stretch = np.array(target[:2])
        length = float(np.abs(stretch - self._stretches[-1]).max())
        length = max(length, self._add_loads(np.array(target[2:], dtype=float), reached))
        if time > self._times[-1]:
            length = max(length, self._time_way)
        if len(self._ends) == 2:
            length = max(length, SHORTEST_FIRST_STRETCH)  # a way for the imperfection to go
        self._stretches = np.vstack([self._stretches, stretch])
        self._ends = np.append(self._ends, self._ends[-1] + length)
        self._times = np.append(self._times, time)
        return float(self._ends[-1])

    def _add_loads(self, values: Array, reached: Sequence[float]) -> float:
        """Go on to other values of the loads; return the length of the way."""
        is_free, was_free = np.isnan(values), self._grips[-1] == 0
        if was_free.any() and len(reached):
            self._values[-1] = np.where(was_free, reached, self._values[-1])
        values = np.where(is_free, self._values[-1], values)
        grips = np.where(is_free, 0.0, 1.0)
        change = np.abs(values - self._values[-1]) / self._scales
        change = np.concatenate([change, np.abs(grips - self._grips[-1])])
        self._values = np.vstack([self._values, values])
        self._grips = np.vstack([self._grips, grips])
        return LOAD_WAY * float(change.max(initial=0.0))

    def leave_at(self, parameter: float) -> None:
        """Go on from a place before the last target, which the path has not come to."""
        here, place = parameter, self.place(parameter)
        kept = self._ends <= here
        kept[:2] = True  # flat, and where the weight is on
        self._ends, self._stretches = self._ends[kept], self._stretches[kept]
        self._values, self._grips = self._values[kept], self._grips[kept]
        self._times = self._times[kept]
        if here > self.end:
            self._ends = np.append(self._ends, here)
            self._stretches = np.vstack([self._stretches, place.stretch])
            self._values = np.vstack([self._values, place.values])
            self._grips = np.vstack([self._grips, place.grips])
            self._times = np.append(self._times, place.time)

    @property
    def milestones(self) -> list[float]:
        """Path parameter of each target."""
        return [float(end) for end in self._ends[2:]]

    @property
    def targets(self) -> list[Milestone]:
        """The prestretch and the values of the loads at each target."""
        return [self.place(end).milestone for end in self.milestones]

    @property
    def times(self) -> list[float]:
        """Time at each target, s after the release."""
        return [float(time) for time in self._times[2:]]

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
        if np.ptp(self._grips[-3:], axis=0).any():
            return False
        places = np.hstack([self._stretches, LOAD_WAY * self._values / self._scales])
        before, after = np.diff(places[-3:], axis=0)
        opposite = before @ after < 0
        cosine_squared = (before @ after) ** 2 / max((before @ before) * (after @ after), 1e-300)
        return bool(opposite and cosine_squared > 1 - 1e-12)

    def place(self, parameter: float) -> LoadPlace:
        """Return the loads at a parameter."""
        values, grips, forces = self._loads_at(parameter)
        return LoadPlace(
            self.stretch(parameter),
            self.weight_fraction(parameter),
            self.imperfection_fraction(parameter),
            values,
            grips,
            forces,
            float(np.interp(parameter, self._ends, self._times)),
        )

    def _loads_at(self, parameter: float) -> tuple[tuple[float, ...], ...]:
        """Return values, grips and shares of forces of the loads at a parameter."""
        end = min(max(int(np.searchsorted(self._ends, parameter)), 1), len(self._ends) - 1)
        begin, length = self._ends[end - 1], self._ends[end] - self._ends[end - 1]
        share = (parameter - begin) / length if length > 0 else 1.0
        values = self._values[end - 1] + share * (self._values[end] - self._values[end - 1])
        grips = self._grips[end]
        forces = (1 - share) * (self._grips[end - 1] - grips).clip(min=0.0)
        found = (values, grips, forces)
        return tuple(tuple(float(each) for each in part) for part in found)

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
        if len(ends) == 1:
            return 1.0  # no target yet
        segment = int(np.searchsorted(ends[1:-1], parameter))
        begin, end = ends[segment : segment + 2]
        share = float(np.clip((parameter - begin) / (end - begin), 0.0, 1.0))
        return 1.0 - share if segment == 0 else 4 * share * (1 - share)
