"""A material in plane stress with a memory; see `bilayer.mechanics.memory`.

The strain is that from the flat bonded state, and S0 the stress in plane stress.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.mechanics.memory import Memory
from dshell.materials.plane_stress import PlaneStressState

Array = NDArray[np.float64]


class RememberingState:
    """A material in plane stress with a memory; see `dshell.materials.plane_stress`.

    Parameters
    ----------
    plain : PlaneStressState
        Of the instantaneous law.
    strain : (3, q, k) array of float
        From the flat bonded state.
    memory : Memory
        Of the layer.
    """

    def __init__(self, plain: PlaneStressState, strain: Array, memory: Memory) -> None:
        self._plain, self._strain, self._memory = plain, strain, memory

    def energy(self) -> Array:
        """Return c W0 + P : e, J/m3."""
        work = (self._memory.pull * self._strain).sum(axis=0)
        return self._memory.factor * self._plain.energy() + work

    def stress(self) -> Array:
        """Return c S0 + P, Pa."""
        return self._memory.factor * self._plain.stress() + self._memory.pull

    def tangent(self) -> Array:
        """Return the stress's derivative by the strain, Pa."""
        return self._memory.factor * self._plain.tangent()

    def thickness_stretch(self) -> Array:
        """Return present over natural thickness."""
        return self._plain.thickness_stretch()
