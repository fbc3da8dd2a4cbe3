"""The prestretch as a path of milestones, each a shape to be computed."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from bilayer.errors import InputError
from bilayer.validation import keep, listed, one_of, positive, shown

StretchPair = tuple[float, float]
"""(lambda_x, lambda_y)."""

UNSTRETCHED: StretchPair = (1.0, 1.0)
BONDED_THICKNESS_RULES = ("natural", "constant")
SMALLEST_STRETCH, LARGEST_STRETCH = 0.1, 10.0
MILESTONES_FIELD = "prestretch.milestones"
MOST_MILESTONES = 10_000


@dataclass(frozen=True)
class Prestretch:
    """The prestretch at each milestone, in the order in which they are gone through.

    Parameters
    ----------
    milestones : sequence of float or of (float, float)
        Stretch at each milestone: one number for an equibiaxial stretch or a pair (lambda_x,
        lambda_y). They may rise, fall and repeat.
    thickness : {"natural", "constant"}
        "natural": a stretched layer keeps its volume, bonded thickness = natural / det U.
        "constant": `Layer.thickness` whatever the stretch, the paper's simplification.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Prestretch([1.03, (1.06, 1.0)]).milestones
    ((1.03, 1.03), (1.06, 1.0))
    """

    milestones: tuple[StretchPair, ...]
    thickness: str = "natural"

    def __post_init__(self) -> None:
        given = _numbers(self.milestones)
        if not 1 <= len(given) <= MOST_MILESTONES:
            raise InputError(
                f"{MILESTONES_FIELD} = {shown(given)}: has {len(given)}, expected at least one "
                f"and at most {MOST_MILESTONES}"
            )
        pairs = tuple(stretch_pair(MILESTONES_FIELD, item) for item in given)
        object.__setattr__(self, "milestones", pairs)
        keep(self, one_of, "thickness", table="prestretch.", choices=BONDED_THICKNESS_RULES)

    @property
    def nominal(self) -> list[float]:
        """The larger stretch of each milestone: the coordinate `prestretch` of a result."""
        return [max(pair) for pair in self.milestones]


def stretch_pair(field: str, value: Any) -> StretchPair:
    """Return (lambda_x, lambda_y) of one number or two.

    Raises
    ------
    InputError
        They are no numbers, more than two, or no stretches that a sheet can bear.
    """
    if isinstance(value, Iterable) and not isinstance(value, str):
        pair = list(value)
        if len(pair) != 2:
            raise InputError(
                f"{field} = {shown(pair)}: expected one number or [lambda_x, lambda_y]"
            )
        return _stretch(field, pair[0]), _stretch(field, pair[1])
    return _stretch(field, value), _stretch(field, value)


def stretch_of(milestone: tuple[float, ...]) -> StretchPair:
    """Return the two stretches that a milestone, with or without loads, begins with."""
    return milestone[0], milestone[1]


def _numbers(milestones: Any) -> list[Any]:
    try:
        return listed(MILESTONES_FIELD, milestones)
    except InputError as error:
        raise InputError(f"{error} of numbers") from error


def _stretch(field: str, value: Any) -> float:
    number = positive(field, value)
    if not SMALLEST_STRETCH <= number <= LARGEST_STRETCH:
        raise InputError(
            f"{field} = {shown(value)}: expected stretches from {SMALLEST_STRETCH:g} to "
            f"{LARGEST_STRETCH:g} (1.06 is 6 %)"
        )
    return number
