"""A state of the solid as a value.

A `State` is a point, an array is a change of one: adding a change to a state gives a state, the
difference of two states is a change.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class State:
    """Displacement and pressures of the solid, which nobody can change.

    Parameters
    ----------
    values : array of float
        Dofs of this rank, those that it owns first, then its ghosts. A copy is kept.
    """

    values: NDArray[np.float64]

    __array_ufunc__ = None  # an array plus a state is an error, not an array of states

    def __post_init__(self) -> None:
        values = np.array(self.values)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    def __add__(self, change: NDArray[np.float64]) -> "State":
        return State(self.values + change)

    def __sub__(self, other: "State") -> NDArray[np.float64]:
        return self.values - other.values
