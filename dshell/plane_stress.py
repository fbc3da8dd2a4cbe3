"""Material laws in plane stress: energy, stress and tangent from the strain in the plane.

The strain is the Green strain from the flat bonded state, as components (exx, eyy, 2 exy) first.
A layer's natural state is its prestretch, a symmetric tensor S of the plane: C = S (1 + 2 e) S is
what the material feels. An isotropic material feels only T = tr C and D = det C, which need no
more of S than S S (the inverse of the natural metric):

    T = S S : (1 + 2 e),      D = det(S)^2 det(1 + 2 e).

The stretch of the thickness, sqrt(C33), is eliminated: the energy is least in it (plane stress).
"""

from dataclasses import dataclass
from functools import singledispatch
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.material import Law, LinearElastic, MooneyRivlin

Array = NDArray[np.float64]

_VOLUME_ITERATIONS = 50
_VOLUME_TOLERANCE = 1e-8  # of the last step, which leaves its square as the error


class PlaneStressLaw(Protocol):
    """An energy per natural volume in plane stress.

    Strains have shape (3, ...), prestretches (2, 2, ...) with the same trailing axes or ones that
    broadcast to them.
    """

    def energy(self, strain: Array, prestretch: Array) -> Array:
        """Return the energy per natural volume, J/m3, shape (...)."""

    def stress(self, strain: Array, prestretch: Array) -> Array:
        """Return its derivative by the strain, Pa, shape (3, ...)."""

    def stress_and_tangent(self, strain: Array, prestretch: Array) -> tuple[Array, Array]:
        """Return the stress with its own derivative by the strain, Pa, shape (3, 3, ...)."""


@dataclass(frozen=True)
class PlaneMooneyRivlin:
    """Mooney-Rivlin in plane stress; neo-Hookean where c01 = 0.

    With c = C33 = J^2 / D, the energy of `bilayer.material` is

        W = C10 (T J^(-2/3) + J^(4/3) / D - 3) + C01 (D J^(-4/3) + T J^(2/3) / D - 3)
            + (J - 1)^2 / D1,

    least in J by Newton's method; J = 1 where D1 = 0 (incompressible).

    Parameters
    ----------
    c10, c01, d1 : float
        Constants in Pa, Pa and 1/Pa.
    """

    c10: float
    c01: float
    d1: float

    def energy(self, strain: Array, prestretch: Array) -> Array:
        """See `PlaneStressLaw`."""
        T, D = _invariants(strain, prestretch)
        J = self._volume(T, D)
        r2 = np.cbrt(J) ** 2
        first = T / r2 + r2 * r2 / D - 3
        second = D / (r2 * r2) + T * r2 / D - 3
        volumetric = (J - 1) ** 2 / self.d1 if self.d1 > 0 else 0.0
        energy = self.c10 * first + self.c01 * second + volumetric
        return np.where(D > 0, energy, np.inf)  # a fibre turned inside out is out of reach

    def stress(self, strain: Array, prestretch: Array) -> Array:
        """See `PlaneStressLaw`."""
        T, D = _invariants(strain, prestretch)
        T_e, D_e, _ = _invariant_derivatives(strain, prestretch)
        W_T, W_D = self._first(T, D, np.cbrt(self._volume(T, D)))
        return W_T * T_e + W_D * D_e

    def stress_and_tangent(self, strain: Array, prestretch: Array) -> tuple[Array, Array]:
        """See `PlaneStressLaw`."""
        T, D = _invariants(strain, prestretch)
        T_e, D_e, D_ee = _invariant_derivatives(strain, prestretch)
        r = np.cbrt(self._volume(T, D))
        W_T, W_D = self._first(T, D, r)
        W_TT, W_TD, W_DD = self._second(T, D, r)
        tangent = W_D * D_ee
        tangent += T_e[:, None] * (W_TT * T_e + W_TD * D_e)
        tangent += D_e[:, None] * (W_TD * T_e + W_DD * D_e)
        return W_T * T_e + W_D * D_e, tangent

    def _first(self, T: Array, D: Array, r: Array) -> tuple[Array, Array]:
        """Return the derivatives by T and D at r = J^(1/3); J counts as fixed, because W_J = 0."""
        a, b = self.c10, self.c01
        r2 = r * r
        return a / r2 + b * r2 / D, b / r2**2 - (a * r2 + b * T) * r2 / D**2

    def _second(self, T: Array, D: Array, r: Array) -> tuple[Array, Array, Array]:
        """Second derivatives by T and D, with J following: W_XY - W_XJ W_YJ / W_JJ."""
        a, b = self.c10, self.c01
        r2 = r * r
        W_TT, W_TD = np.zeros_like(T), -b * r2 / D**2
        W_DD = 2 * (a * r2 + b * T) * r2 / D**3
        if self.d1 > 0:
            W_JJ = self._volume_derivatives(T, D, r)[1]
            W_TJ = 2 / 3 * (b / (r * D) - a / (r2 * r2 * r))
            W_DJ = -2 / 3 * ((2 * a * r + b * T / r) / D**2 + 2 * b / (r2**3 * r))
            W_TT, W_TD = W_TT - W_TJ**2 / W_JJ, W_TD - W_TJ * W_DJ / W_JJ
            W_DD = W_DD - W_DJ**2 / W_JJ
        return W_TT, W_TD, W_DD

    def _volume(self, T: Array, D: Array) -> Array:
        """Return J, the volume over the natural one, at which the energy is least."""
        J = np.ones_like(T)
        if self.d1 == 0:
            return J
        for _ in range(_VOLUME_ITERATIONS):
            W_J, W_JJ = self._volume_derivatives(T, D, np.cbrt(J))
            step = W_J / W_JJ
            J = np.maximum(J - step, 0.5 * J)
            if not np.any(np.abs(step) > _VOLUME_TOLERANCE * J):
                break
        return J

    def _volume_derivatives(self, T: Array, D: Array, r: Array) -> tuple[Array, Array]:
        """Return the first and second derivative by J, at r = J^(1/3)."""
        a, b = 2 / 3 * self.c10, 2 / 3 * self.c01
        q = 1 / r
        q2 = q * q
        q4, per_D = q2 * q2, 1 / D
        aT, bT = a * T * q4, b * T * per_D * q
        a2, b2 = 2 * a * per_D, 2 * b * D * q4 * q2 * q
        slope = a2 * r - aT * q + bT - b2 + 2 / self.d1 * (r * r * r - 1)
        bend = a2 * q2 + 5 * aT * q4 + (7 * b2 - bT) * (q2 * q)
        return slope, bend / 3 + 2 / self.d1


@dataclass(frozen=True)
class PlaneLinear:
    """St. Venant-Kirchhoff in plane stress, of the strain plus the prestretch's initial strain.

        W = E / (2 (1 - nu^2)) [ (1 - nu) e:e + nu (tr e)^2 ],      e = e_bonded + S - 1

    That is the linear law of the paper (eqs. 8-9; see `bilayer.material.LinearElastic`).

    Parameters
    ----------
    young_modulus : float
        E, Pa.
    poisson_ratio : float
        nu.
    """

    young_modulus: float
    poisson_ratio: float

    def energy(self, strain: Array, prestretch: Array) -> Array:
        """See `PlaneStressLaw`."""
        return 0.5 * (self._total(strain, prestretch) * self.stress(strain, prestretch)).sum(axis=0)

    def stress(self, strain: Array, prestretch: Array) -> Array:
        """See `PlaneStressLaw`."""
        return np.einsum("ij,j...->i...", self._stiffness(), self._total(strain, prestretch))

    def stress_and_tangent(self, strain: Array, prestretch: Array) -> tuple[Array, Array]:
        """See `PlaneStressLaw`."""
        stress = self.stress(strain, prestretch)
        return stress, np.multiply.outer(self._stiffness(), np.ones(stress.shape[1:]))

    def _stiffness(self) -> Array:
        nu = self.poisson_ratio
        rows = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        return self.young_modulus / (1 - nu**2) * rows

    @staticmethod
    def _total(strain: Array, prestretch: Array) -> Array:
        S = prestretch
        return strain + np.stack([S[0, 0] - 1, S[1, 1] - 1, S[0, 1] + S[1, 0]])


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


def _invariants(strain: Array, prestretch: Array) -> tuple[Array, Array]:
    """Return T and D."""
    xx, yy, xy, area2 = _squared(prestretch)
    a, b, g = 1 + 2 * strain[0], 1 + 2 * strain[1], strain[2]
    return xx * a + yy * b + 2 * xy * g, area2 * (a * b - g * g)


def _invariant_derivatives(strain: Array, prestretch: Array) -> tuple[Array, Array, Array]:
    """Return the derivatives of T and D by the strain, and the second one of D."""
    xx, yy, xy, area2 = _squared(prestretch)
    a, b, g = 1 + 2 * strain[0], 1 + 2 * strain[1], strain[2]
    one = np.ones_like(a)
    T_e = 2 * np.stack([xx * one, yy * one, xy * one])
    D_e = 2 * area2 * np.stack([b, a, -g])
    rows = np.array([[0, 4, 0], [4, 0, 0], [0, 0, -2]], dtype=float)
    return T_e, D_e, np.multiply.outer(rows, area2)


def _squared(prestretch: Array) -> tuple[Array, Array, Array, Array]:
    """Return xx, yy and xy of the prestretch's square S S, and its determinant."""
    S = prestretch
    xx, yy = S[0, 0] ** 2 + S[0, 1] ** 2, S[1, 1] ** 2 + S[0, 1] ** 2
    xy = S[0, 1] * (S[0, 0] + S[1, 1])
    return xx, yy, xy, (S[0, 0] * S[1, 1] - S[0, 1] ** 2) ** 2
