"""Material laws in plane stress: energy, stress and tangent from the strain in the plane.

The strain is the Green strain from the flat bonded state, as components (exx, eyy, 2 exy) first.
A layer's natural state is its prestretch, a symmetric tensor S of the plane: C = S (1 + 2 e) S is
what the material feels. An isotropic material feels only T = tr C and D = det C, which need no
more of S than S S (the inverse of the natural metric):

    T = S S : (1 + 2 e),      D = det(S)^2 det(1 + 2 e).

The stretch of the thickness, sqrt(C33), is eliminated: the energy is least in it (plane stress).
"""

from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.material import Law, LinearElastic, MooneyRivlin

Array = NDArray[np.float64]

_VOLUME_ITERATIONS = 50
_VOLUME_TOLERANCE = 1e-7  # of the last step, which leaves its square as the error


class PlaneStressState(Protocol):
    """A material in some strain: its energy, and the derivatives by the strain."""

    def energy(self) -> Array:
        """Return the energy per natural volume, J/m3, shape (...)."""

    def stress(self) -> Array:
        """Return its derivative by the strain, Pa, shape (3, ...)."""

    def tangent(self) -> Array:
        """Return the stress's own derivative by the strain, Pa, shape (3, 3, ...)."""


class PlaneStressLaw(Protocol):
    """An energy per natural volume in plane stress."""

    def at(self, strain: Array, prestretch: Array) -> PlaneStressState:
        """Return the material in a strain.

        Parameters
        ----------
        strain : (3, ...) array of float
            From the flat bonded state.
        prestretch : (2, 2, ...) array of float
            Of the flat bonded state; its trailing axes are the strain's or broadcast to them.
        """


@dataclass(frozen=True)
class PlaneMooneyRivlin:
    """Mooney-Rivlin in plane stress; neo-Hookean where c01 = 0.

    With c = C33 = J^2 / D and r = J^(1/3), the energy of `bilayer.specimen.material` is

        W = C10 (T / r^2 + r^4 / D - 3) + C01 (D / r^4 + T r^2 / D - 3) + (r^3 - 1)^2 / D1,

    least in r by Newton's method; r = 1 where D1 = 0 (incompressible).

    Parameters
    ----------
    c10, c01, d1 : float
        Constants in Pa, Pa and 1/Pa.
    """

    c10: float
    c01: float
    d1: float

    def at(self, strain: Array, prestretch: Array) -> "_MooneyRivlinState":
        """See `PlaneStressLaw`."""
        return _MooneyRivlinState(self, strain, prestretch)


class _MooneyRivlinState:
    def __init__(self, law: PlaneMooneyRivlin, strain: Array, prestretch: Array) -> None:
        self._law = law
        self._doubled = 1 + 2 * strain[0], 1 + 2 * strain[1], strain[2]
        self._squared = _squared(prestretch)
        xx, yy, xy, area2 = self._squared
        a, b, g = self._doubled
        self._T = xx * a + yy * b + 2 * xy * g
        self._D = area2 * (a * b - g * g)
        self._per_D = 1 / self._D
        self._r = self._least()

    def energy(self) -> Array:
        """See `PlaneStressState`."""
        T, D, per_D, r, law = self._T, self._D, self._per_D, self._r, self._law
        r2 = r * r
        per_r2 = 1 / r2
        energy = law.c10 * (T * per_r2 + r2 * r2 * per_D - 3)
        energy += law.c01 * (D * per_r2 * per_r2 + T * r2 * per_D - 3)
        if law.d1 > 0:
            energy += (r2 * r - 1) ** 2 / law.d1
        return np.where(D > 0, energy, np.inf)  # a fibre turned inside out is out of reach

    def stress(self) -> Array:
        """See `PlaneStressState`."""
        W_T, W_D = self._first
        T_e, D_e = self._invariant_slopes
        return W_T * T_e + W_D * D_e

    def tangent(self) -> Array:
        """See `PlaneStressState`."""
        _, W_D = self._first
        W_TT, W_TD, W_DD = self._second()
        T_e, D_e = self._invariant_slopes
        tangent = T_e[:, None] * (W_TT * T_e + W_TD * D_e)
        tangent += D_e[:, None] * (W_TD * T_e + W_DD * D_e)
        twice = 2 * self._squared[3] * W_D  # D's own second derivative
        tangent[0, 1] += 2 * twice
        tangent[1, 0] += 2 * twice
        tangent[2, 2] -= twice
        return tangent

    @cached_property
    def _invariant_slopes(self) -> tuple[Array, Array]:
        """Return the derivatives of T and D by the strain."""
        xx, yy, xy, area2 = self._squared
        a, b, g = self._doubled
        T_e = np.stack(np.broadcast_arrays(xx, yy, xy, a)[:3])
        return 2 * T_e, 2 * area2 * np.stack([b, a, -g])

    @cached_property
    def _first(self) -> tuple[Array, Array]:
        """Return the derivatives by T and D; r counts as fixed, because W_r = 0."""
        a, b, per_D = self._law.c10, self._law.c01, self._per_D
        r2 = self._r * self._r
        per_r2 = 1 / r2
        W_T = a * per_r2 + b * r2 * per_D
        return W_T, b * per_r2 * per_r2 - (a * r2 + b * self._T) * r2 * per_D * per_D

    def _second(self) -> tuple[Array, Array, Array]:
        """Second derivatives by T and D, with r following: W_XY - W_Xr W_Yr / W_rr."""
        a, b, per_D, T, r = self._law.c10, self._law.c01, self._per_D, self._T, self._r
        r2 = r * r
        W_TT, W_TD = np.zeros_like(T), -b * r2 * per_D**2
        W_DD = 2 * (a * r2 + b * T) * r2 * per_D**3
        if self._law.d1 > 0:
            per_bend = 1 / self._volume_derivatives(r)[1]
            W_Tr = 2 * b * r * per_D - 2 * a / (r2 * r)
            W_Dr = -4 * b / (r2 * r2 * r) - (4 * a * r2 + 2 * b * T) * r * per_D**2
            W_TT, W_TD = W_TT - W_Tr**2 * per_bend, W_TD - W_Tr * W_Dr * per_bend
            W_DD = W_DD - W_Dr**2 * per_bend
        return W_TT, W_TD, W_DD

    def _least(self) -> Array:
        """Return r, the cube root of the volume over the natural one, of the least energy."""
        if self._law.d1 == 0:
            return np.ones_like(self._T)
        r = self._nearly_least()
        for _ in range(_VOLUME_ITERATIONS):
            slope, bend = self._volume_derivatives(r)
            step = slope / bend
            r = np.maximum(r - step, 0.8 * r)
            # what is turned inside out has infinite energy, whatever its r
            if not np.any((np.abs(step) > _VOLUME_TOLERANCE * r) & (self._D > 0)):
                break
        return r

    def _nearly_least(self) -> Array:
        """Return r after one Newton step from 1 in J, where a stiff volume is nearly quadratic."""
        a, b, k = self._law.c10 / 9, self._law.c01 / 9, 2 / self._law.d1
        aT, aD = a * self._T, a * self._per_D
        bD, bT = b * self._D, b * self._T * self._per_D
        slope = 12 * (aD - bD) + 6 * (bT - aT)
        bend = 10 * aT + 4 * aD + 28 * bD - 2 * bT + k
        j = np.maximum(-slope / bend, -0.5)
        return (3 + 2 * j) / (3 + j)  # the cube root of 1 + j, to the second order

    def _volume_derivatives(self, r: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of the energy by r."""
        a, b, k = 2 * self._law.c10, 2 * self._law.c01, 6 / self._law.d1
        q = 1 / r
        q2, r2 = q * q, r * r
        q4, kr = q2 * q2, k * r
        aT, aD = a * self._T * q4, 2 * a * self._per_D * r2
        bT, bD = b * self._T * self._per_D, 2 * b * self._D * (q4 * q2)
        r3 = r2 * r
        slope = r * (aD + bT - aT - bD + kr * (r3 - 1))
        bend = 3 * (aT + aD) + 5 * bD + bT + kr * (5 * r3 - 2)
        return slope, bend


@dataclass(frozen=True)
class PlaneLinear:
    """St. Venant-Kirchhoff in plane stress, of the strain plus the prestretch's initial strain.

        W = E / (2 (1 - nu^2)) [ (1 - nu) e:e + nu (tr e)^2 ],      e = e_bonded + S - 1

    That is the linear law of the paper (eqs. 8-9; see `bilayer.specimen.material.LinearElastic`).

    Parameters
    ----------
    young_modulus : float
        E, Pa.
    poisson_ratio : float
        nu.
    """

    young_modulus: float
    poisson_ratio: float

    @property
    def stiffness(self) -> Array:
        """Of stress by strain, Pa, shape (3, 3)."""
        nu = self.poisson_ratio
        rows = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        return self.young_modulus / (1 - nu**2) * rows

    def at(self, strain: Array, prestretch: Array) -> "_LinearState":
        """See `PlaneStressLaw`."""
        S = prestretch
        initial = (S[0, 0] - 1, S[1, 1] - 1, S[0, 1] + S[1, 0])
        whole = np.stack([given + own for given, own in zip(strain, initial, strict=True)])
        return _LinearState(self.stiffness, whole)


@dataclass(frozen=True, eq=False)
class _LinearState:
    stiffness: Array
    strain: Array  # from the natural state

    def energy(self) -> Array:
        """See `PlaneStressState`."""
        return 0.5 * (self.strain * self.stress()).sum(axis=0)

    def stress(self) -> Array:
        """See `PlaneStressState`."""
        return np.einsum("ij,j...->i...", self.stiffness, self.strain)

    def tangent(self) -> Array:
        """See `PlaneStressState`."""
        return np.multiply.outer(self.stiffness, np.ones(self.strain.shape[1:]))


@singledispatch
def plane_stress_law(material: Law) -> PlaneStressLaw:
    """Return the plane-stress law of a layer's material; InputError where there is none."""
    raise InputError(f"law = {type(material).__name__}: the discrete shell has no plane-stress law")


@plane_stress_law.register
def _(material: MooneyRivlin) -> PlaneStressLaw:
    return PlaneMooneyRivlin(material.c10, material.c01, material.d1)


@plane_stress_law.register
def _(material: LinearElastic) -> PlaneStressLaw:
    return PlaneLinear(material.young_modulus, material.poisson_ratio)


def _squared(prestretch: Array) -> tuple[Array, Array, Array, Array]:
    """Return xx, yy and xy of the prestretch's square S S, and its determinant."""
    S = prestretch
    xx, yy = S[0, 0] ** 2 + S[0, 1] ** 2, S[1, 1] ** 2 + S[0, 1] ** 2
    xy = S[0, 1] * (S[0, 0] + S[1, 1])
    return xx, yy, xy, (S[0, 0] * S[1, 1] - S[0, 1] ** 2) ** 2
