"""The order of the starts of a search."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.landscape.catalogue import Catalogue
from bilayer.landscape.starts import Sheet, Start, fixed_starts, random_start

Array = NDArray[np.float64]

GIVEN = "given shape"
PATHS = (8, 2, 1)
"""Numbers of equal steps of the prestretch by which the flat sheet comes to it."""
PUSH = 0.1
"""Height of the waves by which a state that is avoided is left, over the characteristic length."""


def schedule(
    sheet: Sheet,
    catalogue: Catalogue,
    follow_path: Callable[[int], Array],
    given: Sequence[Array] = (),
) -> Iterator[Start]:
    """Yield the starts of a search without end, each when it is asked for.

    Shapes that are given, the load paths, the fixed shapes, then for each state that is known by
    then it turned over and away from it, and random shapes.

    Parameters
    ----------
    sheet : Sheet
        The flat sheet.
    catalogue : Catalogue
        The states that are known; it grows.
    follow_path : callable
        Takes a number of steps, returns the shape at their end.
    given : sequence of (n, 3) array of float
        Shapes from elsewhere, m.
    """
    for number, shape in enumerate(given):
        yield Start(f"{GIVEN} {number}", lambda s=shape: s)  # type: ignore[misc]
    for steps in PATHS:
        yield Start(f"path of {steps} steps", lambda n=steps: follow_path(n))  # type: ignore[misc]
    yield from fixed_starts(sheet, catalogue.images.symmetry)
    seed = met = 0
    while True:
        if met < len(catalogue.states):
            yield from _beside_state(sheet, catalogue, met)
            met += 1
        else:
            yield random_start(sheet, seed)
            seed += 1


def _beside_state(sheet: Sheet, catalogue: Catalogue, place: int) -> Sequence[Start]:
    """Return the starts that a state gives rise to."""
    position = catalogue.states[place].position

    def pushed() -> Array:
        waves = sheet.waves(2 + place, PUSH)
        waves[:, :2] = 0.0
        return position + waves

    return [
        Start(f"state {place} turned over", lambda: position * [1.0, 1.0, -1.0]),
        Start(f"away from state {place}", pushed, avoids_known=True),
    ]
