"""Material laws in plane stress: energy, stress and tangent from the strain in the plane.

The strain is the Green strain from the flat bonded state, as components (exx, eyy, 2 exy) first.
A layer's natural state is its prestretch, a symmetric tensor S of the plane: C = S (1 + 2 e) S is
what the material feels. An isotropic material feels only T = tr C and D = det C, which need no
more of S than S S (the inverse of the natural metric):

    T = S S : (1 + 2 e),      D = det(S)^2 det(1 + 2 e).

The stretch of the thickness, sqrt(C33), is eliminated: the energy is least in it (plane stress).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial, singledispatch
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.materials import Hyperelastic, Jet, Law, LinearElastic

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

    def thickness_stretch(self) -> Array:
        """Return present over natural thickness, shape (...)."""


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
class PlaneHyperelastic:
    """A hyperelastic law in plane stress.

    With c = C33 = J^2 / D and r = J^(1/3), the invariants of `bilayer.specimen.materials` are

        I1 = T / r^2 + r^4 / D,    I2 = D / r^4 + T r^2 / D,

    and W = w(I1, I2) + (r^3 - 1)^2 / D1 is least in r by Newton's method; r = 1 if D1 = 0
    (incompressible).

    Parameters
    ----------
    law : Hyperelastic
        The law with its constants.
    """

    law: Hyperelastic

    def at(self, strain: Array, prestretch: Array) -> "HyperelasticState":
        """See `PlaneStressLaw`."""
        return HyperelasticState(self, strain, prestretch)

    @cached_property
    def constant_slopes(self) -> Jet | None:
        """Derivatives of w by I1 and I2, if they are the same everywhere, as Mooney-Rivlin's."""
        somewhere = self.law.slopes(np.full(1, 3.0), np.full(1, 3.0))
        return somewhere if somewhere.is_linear else None


class HyperelasticState:
    """A hyperelastic material in plane stress; see `PlaneStressState`."""

    def __init__(self, plane: PlaneHyperelastic, strain: Array, prestretch: Array) -> None:
        self._doubled = 1 + 2 * strain[0], 1 + 2 * strain[1], strain[2]
        self._squared = _squared(prestretch)
        xx, yy, xy, area2 = self._squared
        a, b, g = self._doubled
        T = xx * a + yy * b + 2 * xy * g
        self._D = area2 * (a * b - g * g)
        self._expanded = self._expand(plane, T)

    def _expand(self, plane: PlaneHyperelastic, T: Array) -> "Expansion":
        per_D = 1 / self._D
        return of_least_energy(partial(Expansion, plane, T, self._D, per_D), plane, T, self._D)

    def energy(self) -> Array:
        """See `PlaneStressState`."""
        energy = self._expanded.energy()
        # a fibre turned inside out is out of reach, and so is one beyond where its law locks
        return np.where((self._D > 0) & np.isfinite(energy), energy, np.inf)

    def stress(self) -> Array:
        """See `PlaneStressState`."""
        W_T, W_D = self._first
        T_e, D_e = self._invariant_slopes
        return W_T * T_e + W_D * D_e

    def tangent(self) -> Array:
        """See `PlaneStressState`."""
        _, W_D = self._first
        W_TT, W_TD, W_DD = self._expanded.second()
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

    def thickness_stretch(self) -> Array:
        """See `PlaneStressState`: J / sqrt(D)."""
        return self._expanded.volume_ratio / np.sqrt(self._D)

    @cached_property
    def _first(self) -> tuple[Array, Array]:
        return self._expanded.first()


class Expansion:
    """The energy as a function of T, D and r, with its derivatives.

    The invariants are sums of four monomials, I1 = p + q and I2 = s + t, whose derivatives are
    multiples of themselves:

        p = T / r^2,  q = r^4 / D,  s = D / r^4,  t = T r^2 / D.
    """

    def __init__(self, plane: PlaneHyperelastic, T: Array, D: Array, per_D: Array, r: Any) -> None:
        self._plane, self._per_D, self._r = plane, per_D, r
        self._r2 = r2 = r * r
        self._x, self._y = 1 / r2, r2 * per_D
        self._p, self._q = T * self._x, r2 * self._y
        self._s, self._t = D * (self._x * self._x), T * self._y

    def energy(self) -> Array:
        """Return the energy."""
        law = self._plane.law
        with np.errstate(invalid="ignore"):  # beyond where the law locks
            energy: Array = law.energy(self._p + self._q, self._s + self._t, np)
        if law.d1 > 0:
            energy = energy + (self._r2 * self._r - 1) ** 2 / law.d1
        return energy

    @property
    def volume_ratio(self) -> Array:
        """J = r^3."""
        return self._r2 * self._r

    def first(self) -> tuple[Array, Array]:
        """Return the derivatives by T and D; r counts as fixed, because W_r = 0."""
        by_I1, by_I2 = self.slopes.first
        W_T = by_I1 * self._x + by_I2 * self._y
        return W_T, (by_I2 * (self._s - self._t) - by_I1 * self._q) * self._per_D

    def second(self) -> tuple[Array, Array, Array]:
        """Return the second derivatives by T and D, r following: W_XY - W_Xr W_Yr / W_rr."""
        W_TT, W_TD, W_DD = self._second_at_volume()
        if self._plane.law.d1 > 0:
            per_bend = 1 / self.volume_derivatives()[1]
            W_Tr, W_Dr = self._along_volume()
            W_TT, W_TD = W_TT - W_Tr * W_Tr * per_bend, W_TD - W_Tr * W_Dr * per_bend
            W_DD = W_DD - W_Dr * W_Dr * per_bend
        return W_TT, W_TD, W_DD

    def _second_at_volume(self) -> tuple[Array, Array, Array]:
        """Return the second derivatives by T and D at a fixed r."""
        by_I1, by_I2 = self.slopes.first
        per_D, bend = self._per_D, self._bend
        W_TT = bend("T", "T")
        W_TD = bend("T", "D") - by_I2 * self._y * per_D
        W_DD = bend("D", "D") + 2 * (by_I1 * self._q + by_I2 * self._t) * per_D * per_D
        return W_TT, W_TD, W_DD

    def _along_volume(self) -> tuple[Array, Array]:
        """Return r W_Tr and r W_Dr."""
        by_I1, by_I2 = self.slopes.first
        W_Tr = self._bend("T", "r") + 2 * (by_I2 * self._y - by_I1 * self._x)
        W_Dr = by_I1 * (4 * self._q) + by_I2 * (4 * self._s + 2 * self._t)
        return W_Tr, self._bend("D", "r") - W_Dr * self._per_D

    def volume_derivatives(self) -> tuple[Array, Array]:
        """Return r W_r and r^2 W_rr."""
        by_I1, by_I2 = self.slopes.first
        r3 = self._r2 * self._r
        kr3 = 6 / self._plane.law.d1 * r3
        P, Q, S, T = by_I1 * self._p, by_I1 * self._q, by_I2 * self._s, by_I2 * self._t
        slope = 4 * (Q - S) + 2 * (T - P) + kr3 * (r3 - 1)
        bend = 6 * P + 12 * Q + 20 * S + 2 * T + kr3 * (5 * r3 - 2)
        return slope, bend + self._bend("r", "r")

    @cached_property
    def slopes(self) -> Jet:
        """Energy w with its derivatives by I1 and I2; the value is void if they are constant."""
        if self._plane.constant_slopes:
            return self._plane.constant_slopes
        with np.errstate(invalid="ignore"):  # beyond where the law locks
            return self._plane.law.slopes(self._p + self._q, self._s + self._t)

    def _bend(self, one: str, other: str) -> Any:
        """Return the part of a second derivative that comes of those of w by I1 and I2."""
        slopes = self.slopes
        return (
            0.0 if slopes.is_linear else slopes.second_along(self._along[one], self._along[other])
        )

    @cached_property
    def _along(self) -> dict[str, tuple[Array, Array]]:
        """Return the derivatives of I1 and I2 by T and D, and r times those by r."""
        p, q, s, t = self._p, self._q, self._s, self._t
        return {
            "T": (self._x, self._y),
            "D": (-q * self._per_D, (s - t) * self._per_D),
            "r": (4 * q - 2 * p, 2 * t - 4 * s),
        }


Expanded = TypeVar("Expanded", bound=Expansion)


def of_least_energy(
    expand: Callable[[Any], Expanded], plane: PlaneHyperelastic, T: Array, D: Array
) -> Expanded:
    """Return the expansion at the r of least energy, the cube root of the volume ratio.

    Parameters
    ----------
    expand : callable
        Returns the expansion at an r.
    plane, T, D
        Of the expansion.
    """
    return expand(1.0 if plane.law.d1 == 0 else _volume_of_least_energy(expand, T, D))


def _volume_of_least_energy(expand: Callable[[Any], "Expansion"], T: Array, D: Array) -> Array:
    """Return r, the cube root of the volume over the natural one, of the least energy."""
    r, inside = _first_guess_of_volume(expand, T, D)
    for _ in range(_VOLUME_ITERATIONS):
        slope, bend = expand(r).volume_derivatives()
        step = slope / bend
        locked = np.isnan(step)
        if locked.any():  # the law locks there: half way back
            step = np.where(locked, (1 - inside / r) / 2, step)
            inside = np.where(locked, inside, r)
        else:
            inside = r
        r = r * np.maximum(1 - step, 0.8)
        # what is turned inside out has infinite energy, whatever its r
        if not np.any((np.abs(step) > _VOLUME_TOLERANCE) & (D > 0)):
            break
    return r


def _first_guess_of_volume(
    expand: Callable[[Any], "Expansion"], T: Array, D: Array
) -> tuple[Array, Any]:
    """Return r after one Newton step from 1 in J, where a stiff volume is nearly quadratic.

    Second, an r from which the law is not locked, if there is one: 1, or else that of the least I1,
    which is then the guess.
    """
    slope, bend = expand(1.0).volume_derivatives()
    j = np.maximum(-3 * slope / (bend - 2 * slope), -0.5)
    r = (3 + 2 * j) / (3 + j)  # the cube root of 1 + j, to the second order
    locked = np.isnan(r)
    if not locked.any():
        return r, 1.0
    of_least_I1 = np.abs(T * D / 2) ** (1 / 6)
    return np.where(locked, of_least_I1, r), np.where(locked, of_least_I1, 1.0)


@dataclass(frozen=True)
class PlaneLinear:
    """St. Venant-Kirchhoff in plane stress, of the strain plus the prestretch's initial strain.

        W = E / (2 (1 - nu^2)) [ (1 - nu) e:e + nu (tr e)^2 ],      e = e_bonded + S - 1

    That is the linear law of the paper (eqs. 8-9; see `bilayer.specimen.materials.LinearElastic`).

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
        nu, area = self.poisson_ratio, S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]
        squared = 1 - 2 * nu / (1 - nu) * (strain[0] + strain[1])
        return _LinearState(self.stiffness, whole, squared, area)


@dataclass(frozen=True, eq=False)
class _LinearState:
    stiffness: Array
    strain: Array  # from the natural state
    squared: Array  # of the stretch of the thickness from the flat bonded state
    area: Array  # det S, which the bonded state is thinner by

    def energy(self) -> Array:
        """See `PlaneStressState`."""
        return 0.5 * (self.strain * self.stress()).sum(axis=0)

    def stress(self) -> Array:
        """See `PlaneStressState`."""
        return np.einsum("ij,j...->i...", self.stiffness, self.strain)

    def tangent(self) -> Array:
        """See `PlaneStressState`."""
        return np.multiply.outer(self.stiffness, np.ones(self.strain.shape[1:]))

    def thickness_stretch(self) -> Array:
        """See `PlaneStressState`; not a number if the strain is beyond what the law bears."""
        with np.errstate(invalid="ignore"):
            return np.sqrt(self.squared) / self.area


@singledispatch
def plane_stress_law(material: Law) -> PlaneStressLaw:
    """Return the plane-stress law of a layer's material; InputError if there is none."""
    raise InputError(f"law = {type(material).__name__}: the discrete shell has no plane-stress law")


@plane_stress_law.register
def _(material: Hyperelastic) -> PlaneStressLaw:
    return PlaneHyperelastic(material)


@plane_stress_law.register
def _(material: LinearElastic) -> PlaneStressLaw:
    return PlaneLinear(material.young_modulus, material.poisson_ratio)


def _squared(prestretch: Array) -> tuple[Array, Array, Array, Array]:
    """Return xx, yy and xy of the prestretch's square S S, and its determinant."""
    S = prestretch
    xx, yy = S[0, 0] ** 2 + S[0, 1] ** 2, S[1, 1] ** 2 + S[0, 1] ** 2
    xy = S[0, 1] * (S[0, 0] + S[1, 1])
    return xx, yy, xy, (S[0, 0] * S[1, 1] - S[0, 1] ** 2) ** 2
