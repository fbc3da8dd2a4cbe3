"""The milestones of a study's cases on one axis, where a path may come to a prestretch again."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Pair = tuple[float, float]
Key = tuple[Pair, int]
"""A pair of stretches, and how often the path has been there before."""


@dataclass(frozen=True)
class MilestoneAxis:
    """The places that the milestones of all cases have among each other.

    Parameters
    ----------
    keys : tuple of Key
        The one path, if all cases have the same; else all milestones, by the larger stretch.
    """

    keys: tuple[Key, ...]

    @classmethod
    def of(cls, paths: Sequence[Sequence[Pair]]) -> "MilestoneAxis":
        """Return the axis of some load paths."""
        distinct = list(dict.fromkeys(_keys(path) for path in paths))
        if len(distinct) == 1:
            return cls(distinct[0])
        return cls(tuple(sorted({key for path in distinct for key in path}, key=_order)))

    def __len__(self) -> int:
        """Return the number of places."""
        return len(self.keys)

    def places(self, path: Sequence[Pair]) -> NDArray[np.int64]:
        """Return the place of each milestone of a load path."""
        return np.array([self._place[key] for key in _keys(path)], dtype=np.int64)

    def coordinates(self) -> dict[str, Any]:
        """Return coordinates along the dimension `prestretch`; `visit` only if it tells apart."""
        one = {"units": "1"}
        pairs = np.array([pair for pair, _ in self.keys]).reshape(-1, 2)
        visits = np.array([visit for _, visit in self.keys], dtype=int)
        coordinates: dict[str, Any] = {
            "prestretch": ("prestretch", pairs.max(axis=1), one),
            "prestretch_x": ("prestretch", pairs[:, 0], one),
            "prestretch_y": ("prestretch", pairs[:, 1], one),
        }
        if visits.any():
            note = {"long_name": "how often the load path has been at this prestretch before"}
            coordinates["visit"] = ("prestretch", visits, note)
        return coordinates

    @cached_property
    def _place(self) -> dict[Key, int]:
        return {key: place for place, key in enumerate(self.keys)}


def _keys(path: Sequence[Pair]) -> tuple[Key, ...]:
    visits: Counter[Pair] = Counter()
    keys = []
    for x, y in path:
        keys.append(((x, y), visits[x, y]))
        visits[x, y] += 1
    return tuple(keys)


def _order(key: Key) -> tuple[Any, ...]:
    pair, visit = key
    return max(pair), min(pair), pair, visit
