"""How often a fold has gone round: what keeps the energy smooth if a fold passes 180 degrees.

The normals of two triangles tell the angle between them up to whole turns, from -180 to 180
degrees. A fold that goes on past 180 degrees would jump to the other end, and its energy with it.
The state therefore holds the number of whole turns of each fold, behind all degrees of freedom: 0
until a fold passes 180 degrees, and never unknown, always held. Between two states that follow each
other no fold changes by more than half a turn.
"""

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FULL_TURN = 2 * np.pi
"""rad."""


@runtime_checkable
class Folded(Protocol):
    """The elements of an energy in one state, if they have folds."""

    @property
    def turn_dofs(self) -> NDArray[np.int64] | None:
        """Place of each fold's whole turns in the state, (f,); None if they are not kept."""

    @property
    def angles(self) -> Array:
        """Angle across each fold, rad, (f,)."""


def turns_in(state: Array, turn_dofs: NDArray[np.int64] | None) -> Array | float:
    """Return the whole turns of folds in a state, which may leave them out if all are 0."""
    if turn_dofs is None or turn_dofs.max(initial=0) >= len(state):
        return 0.0
    return state[turn_dofs]


def continue_turns(before: Sequence[Any], after: Sequence[Any], state: Array) -> Array | None:
    """Return a state whose folds follow those of the state before.

    Parameters
    ----------
    before, after : sequence of Deformed
        The same energies in the state before, and in the state.
    state : (dofs,) array of float
        With the whole turns of the state before.

    Returns
    -------
    (dofs,) array of float or None
        The state with its whole turns changed; None if no fold jumps.
    """
    continued = None
    for earlier, later in zip(before, after, strict=True):
        if not isinstance(later, Folded) or later.turn_dofs is None:
            continue
        jump = later.angles - earlier.angles
        jumped = np.abs(jump) > FULL_TURN / 2
        if jumped.any():
            continued = state.copy() if continued is None else continued
            places = later.turn_dofs[jumped]
            continued[places] = state[places] - np.round(jump[jumped] / FULL_TURN)
    return continued
