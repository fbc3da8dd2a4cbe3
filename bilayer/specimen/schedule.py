"""When a sheet is looked at: how long it is held before it is bonded, and times after its release.

Layers relax (`bilayer.specimen.relaxation`). At time -hold they are stretched, at once, and held;
at time 0 they are bonded and released, at once. The milestones of time follow.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bilayer.errors import InputError
from bilayer.specimen.relaxation import PronySeries
from bilayer.validation import keep, listed, not_negative, whole

MOST_STEPS = 1000
SETTLED = 40.0
"""Longest relaxation times after which nothing changes any more."""
FIRST = 0.1
"""First step of time after the release, over the shortest relaxation time."""


@dataclass(frozen=True)
class Schedule:
    """Milestones of time.

    Parameters
    ----------
    milestones : sequence of float
        Times after the release, s, from 0 on, rising.
    hold : float
        Time for which the stretched layers are held before they are bonded, s.
    steps_per_decade : int
        Steps of time between the milestones, for a tenfold time.
    """

    milestones: tuple[float, ...]
    hold: float = 0.0
    steps_per_decade: int = 8

    def __post_init__(self) -> None:
        given = listed("time.milestones", self.milestones)
        if not given:
            raise InputError("time.milestones = []: expected at least one time")
        times = tuple(not_negative("time.milestones", item, "s") for item in given)
        if any(later <= earlier for earlier, later in pairwise(times)):
            raise InputError(f"time.milestones = {list(times)}: expected times that rise")
        object.__setattr__(self, "milestones", times)
        keep(self, not_negative, "hold", table="time.", unit="s")
        keep(self, whole, "steps_per_decade", table="time.", at_least=1, at_most=MOST_STEPS)

    def first(self, count: int) -> "Schedule":
        """Return the schedule of the first milestones."""
        return Schedule(self.milestones[:count], self.hold, self.steps_per_decade)

    def steps_to(self, number: int, layers: Sequence[PronySeries]) -> list[float]:
        """Return the ends of the steps from the milestone before to one, s.

        Before the first milestone comes the release at time 0, a step of its own.

        Parameters
        ----------
        number : int
            Of the milestone, from 0 on.
        layers : sequence of PronySeries
            Of the layers.

        Examples
        --------
        >>> schedule = Schedule((1.0, 100.0), steps_per_decade=1)
        >>> [round(t, 6) for t in schedule.steps_to(0, [PronySeries([(0.5, 10.0)])])]
        [0.0, 1.0]
        >>> [round(t, 6) for t in schedule.steps_to(1, [PronySeries([(0.5, 10.0)])])]
        [10.0, 100.0]
        """
        end = self.milestones[number]
        if number:
            return self.steps(self.milestones[number - 1], end, layers)
        return [0.0, *(self.steps(0.0, end, layers) if end else [])]

    def passed(self, time: float) -> int:
        """Return the number of milestones up to a time, s."""
        return sum(milestone <= time for milestone in self.milestones)

    def steps(self, start: float, end: float, layers: Sequence[PronySeries]) -> list[float]:
        """Return the ends of the steps from a time to another, s; the last is the end.

        They lie on a grid that is even in the logarithm of time, from a part of the shortest
        relaxation time on, until nothing relaxes any more.

        Parameters
        ----------
        start, end : float
            s.
        layers : sequence of PronySeries
            Of the layers.

        Examples
        --------
        >>> schedule = Schedule((0.0, 100.0), steps_per_decade=1)
        >>> [round(t, 6) for t in schedule.steps(0.0, 100.0, [PronySeries([(0.5, 10.0)])])]
        [1.0, 10.0, 100.0]
        """
        times = [time for series in layers for _, time in series.terms]
        if not times or end <= start:
            return [end]
        first, last = FIRST * min(times), min(end, SETTLED * max(times))
        if last <= first:
            return [end]
        count = math.ceil(self.steps_per_decade * math.log10(last / first) - 1e-9)
        grid = first * 10 ** (np.arange(count + 1) / self.steps_per_decade)
        inner = grid[(grid > start * (1 + 1e-6)) & (grid < end * (1 - 1e-6))]
        return [*(float(time) for time in inner), end]
