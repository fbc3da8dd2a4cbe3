"""Materials in plane stress that remember; see `bilayer.mechanics.memory`.

A hyperelastic law remembers, as in three dimensions, the stress of the change of shape and the
pressure. With s = J^(-2/3) = 1 / r^2 the strain of the change of shape is E = s C / 2, in the plane
C = 1 + 2 e from the flat bonded state and across it C33 = r^6 / D from the natural thickness. Its
stress is S0 = (2 / s) dw/dC, the deviator DEV of Simo and Hughes, and the pressure p0 = U'(J). A
step of time has the energy

    W = c w + P : s C / 2 + c U(J) + q (J - 1),

least in r as that of the law alone. The stretch of the thickness follows from all of it, so what
relaxes is not the stress in plane stress: that would be another answer once the strain changes.

The linear law remembers the stress in plane stress, which for a linear answer is the same.
"""

from dataclasses import dataclass
from functools import partial, singledispatch
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.memory import Memory
from dshell.materials.plane_stress import (
    Expansion,
    HyperelasticState,
    PlaneHyperelastic,
    PlaneLinear,
    PlaneStressLaw,
    PlaneStressState,
    of_least_energy,
)

Array = NDArray[np.float64]

IN_PLANE, ACROSS, PRESSURE = slice(3), 3, 4
"""Parts of what a hyperelastic law remembers: xx, yy and xy of the stress, zz, the pressure."""


class RememberingState(PlaneStressState, Protocol):
    """A material in plane stress in some strain and step of time."""

    def instantaneous(self) -> Array:
        """Return what is remembered, the stresses that the law has at once, Pa, (parts, ...)."""


@singledispatch
def remember(
    law: PlaneStressLaw, strain: Array, prestretch: Array, memory: Memory
) -> RememberingState:
    """Return a material in a strain and a step of time.

    Parameters
    ----------
    law, strain, prestretch
        See `PlaneStressLaw.at`.
    memory : Memory
        Of the layer, its pull (parts, ...).
    """
    raise InputError(f"law = {type(law).__name__}: the discrete shell has no memory of it")


@singledispatch
def nothing(law: PlaneStressLaw) -> Memory:
    """Return the memory of a layer that remembers nothing."""
    raise InputError(f"law = {type(law).__name__}: the discrete shell has no memory of it")


@remember.register
def _(law: PlaneHyperelastic, strain: Array, prestretch: Array, memory: Memory) -> RememberingState:
    return RememberingHyperelastic(law, strain, prestretch, memory)


@nothing.register
def _(law: PlaneHyperelastic) -> Memory:
    return Memory(1.0, np.zeros((5, 1, 1)))


@remember.register
def _(law: PlaneLinear, strain: Array, prestretch: Array, memory: Memory) -> RememberingState:
    return RememberingLinear(law.at(strain, prestretch), strain, memory)


@nothing.register
def _(law: PlaneLinear) -> Memory:
    return Memory(1.0, np.zeros((3, 1, 1)))


@singledispatch
def dead_stress(law: PlaneStressLaw, pull: Array, prestretch: Array) -> Array:
    """Return the dead stress of a change of shape as a tensor, Pa, (..., 3, 3).

    It has the flat bonded state as reference; see `bilayer.mechanics.layer_state.LayerState`.

    Parameters
    ----------
    law : PlaneStressLaw
        Of the layer.
    pull : (parts, ...) array of float
        What a memory holds of it.
    prestretch : (2, 2, ...) array of float
        Of the flat bonded state.
    """
    raise InputError(f"law = {type(law).__name__}: the discrete shell has no memory of it")


@dead_stress.register
def _(law: PlaneHyperelastic, pull: Array, prestretch: Array) -> Array:
    S = prestretch
    area = S[0, 0] * S[1, 1] - S[0, 1] ** 2
    xx, yy, xy = pull[IN_PLANE]
    return _tensor(xx, yy, xy, pull[ACROSS] / area**2)


@dead_stress.register
def _(law: PlaneLinear, pull: Array, prestretch: Array) -> Array:
    xx, yy, xy = pull
    return _tensor(xx, yy, xy, np.zeros_like(xx))


def _tensor(xx: Array, yy: Array, xy: Array, zz: Array) -> Array:
    zero = np.zeros_like(xx)
    rows = [[xx, xy, zero], [xy, yy, zero], [zero, zero, zz]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


class RememberingHyperelastic(HyperelasticState):
    """A hyperelastic material with a memory: c times that of the law and dead stresses over c."""

    def __init__(
        self, plane: PlaneHyperelastic, strain: Array, prestretch: Array, memory: Memory
    ) -> None:
        self._plane, self._factor = plane, memory.factor
        self._pull = memory.pull / memory.factor
        super().__init__(plane, strain, prestretch)

    def _expand(self, plane: PlaneHyperelastic, T: Array) -> "_RememberingExpansion":
        a, b, g = self._doubled
        xx, yy, xy = self._pull[IN_PLANE]
        along = xx * a + yy * b + 2 * xy * g
        dead = _Dead(along, self._pull[ACROSS], self._pull[PRESSURE])
        expand = partial(_RememberingExpansion, dead, plane, T, self._D, 1 / self._D)
        self._dead_expansion = of_least_energy(expand, plane, T, self._D)
        return self._dead_expansion

    def energy(self) -> Array:
        """See `PlaneStressState`."""
        return self._factor * super().energy()

    def stress(self) -> Array:
        """See `PlaneStressState`."""
        dead = self._dead_expansion.by_dead * self._dead_slopes
        return self._factor * (super().stress() + dead)

    def tangent(self) -> Array:
        """See `PlaneStressState`."""
        tangent = super().tangent()
        if self._plane.law.d1 > 0:
            W_TA, W_DA, W_AA = self._dead_expansion.second_by_dead()
            T_e, D_e = self._invariant_slopes
            A_e, mixed = self._dead_slopes, W_TA * T_e + W_DA * D_e
            tangent += mixed[:, None] * A_e + A_e[:, None] * (mixed + W_AA * A_e)
        return self._factor * tangent

    @property
    def _dead_slopes(self) -> Array:
        """Return the derivative of P : C in the plane by the strain."""
        return np.asarray(2 * self._pull[IN_PLANE], dtype=np.float64)

    def instantaneous(self) -> Array:
        """See `RememberingState`."""
        a, b, g = self._doubled
        xx, yy, xy, area2 = self._squared
        inverse = np.stack([b, a, -g]) * (area2 / self._D)
        natural = np.stack(np.broadcast_arrays(xx, yy, xy, a)[:3])
        return np.stack([*self._dead_expansion.stress_of_shape(natural, inverse)])


class RememberingLinear:
    """The linear law with a memory.

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

    def instantaneous(self) -> Array:
        """See `RememberingState`."""
        return self._plain.stress()


@dataclass(frozen=True, eq=False)
class _Dead:
    """What a memory does its work on, over c: P : C in the plane, P33 across it, q."""

    along: Array
    across: Array
    pressure: Array


class _RememberingExpansion(Expansion):
    """The energy over c, with M = (P : C / r^2 + P33 r^4 / D) / 2 + q (r^3 - 1) beside the law's.

    The first two terms of M have the powers of r that the monomials p and q of I1 have. A = P : C
    is a third variable beside T and D.
    """

    def __init__(
        self, dead: _Dead, plane: PlaneHyperelastic, T: Array, D: Array, per_D: Array, r: Any
    ) -> None:
        super().__init__(plane, T, D, per_D, r)
        self._dead = dead
        self._pulled = dead.along * self._x / 2
        self._across = dead.across * self._q / 2

    def energy(self) -> Array:
        """Return the energy."""
        J = self.volume_ratio
        return super().energy() + self._pulled + self._across + self._dead.pressure * (J - 1)

    @property
    def by_dead(self) -> Array:
        """The derivative by A."""
        return np.asarray(self._x / 2)

    def first(self) -> tuple[Array, Array]:
        """Return the derivatives by T and D."""
        W_T, W_D = super().first()
        return W_T, W_D - self._across * self._per_D

    def _second_at_volume(self) -> tuple[Array, Array, Array]:
        W_TT, W_TD, W_DD = super()._second_at_volume()
        return W_TT, W_TD, W_DD + 2 * self._across * self._per_D * self._per_D

    def _along_volume(self) -> tuple[Array, Array]:
        W_Tr, W_Dr = super()._along_volume()
        return W_Tr, W_Dr - 4 * self._across * self._per_D

    def second_by_dead(self) -> tuple[Array, Array, Array]:
        """Return the derivatives by T and A, by D and A, by A twice, r following."""
        W_Tr, W_Dr = self._along_volume()
        of_volume = self._x / self.volume_derivatives()[1]  # -r W_Ar / (r^2 W_rr)
        return W_Tr * of_volume, W_Dr * of_volume, -self._x * of_volume

    def volume_derivatives(self) -> tuple[Array, Array]:
        """Return r W_r and r^2 W_rr."""
        slope, bend = super().volume_derivatives()
        pressed = 3 * self._dead.pressure * self.volume_ratio
        slope = slope + 4 * self._across - 2 * self._pulled + pressed
        return slope, bend + 12 * self._across + 6 * self._pulled + 2 * pressed

    def stress_of_shape(self, natural: Array, inverse: Array) -> list[Array]:
        """Return S0 in the plane and across it, and p0, Pa.

        Parameters
        ----------
        natural, inverse : (3, ...) array of float
            S S and the inverse of C, in the plane.
        """
        by_I1, by_I2 = self.slopes.first
        x, y, per_C33 = self._x, self._y, self._x / self._q
        thirds = (by_I1 * (self._p + self._q) + 2 * by_I2 * (self._s + self._t)) / 3
        plane = (by_I1 * x + by_I2 * y) * natural + (by_I2 * self._s - thirds) * inverse
        across = by_I1 * x + by_I2 * self._p * x - thirds * per_C33
        d1, J = self._plane.law.d1, self.volume_ratio
        pressure = 2 * (J - 1) / d1 if d1 > 0 else 0.0
        scaled = [*(2 / x * plane), 2 / x * across]
        return [*scaled, np.broadcast_to(pressure, np.shape(across))]
