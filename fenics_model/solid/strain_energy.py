"""Strain energies in UFL: a material is its energy, stresses follow by differentiation.

Each law gives the energy per volume of the mesh from the mesh's own C = grad(x)^T grad(x) and
J = det grad(x), the natural state and the pressure. The natural state is a symmetric tensor G, see
`natural_tensor`: the elastic gradient is Fe = grad(x) G, and det G volumes of mesh hold one natural
volume. The bonded flat state is grad(x) = diag(1, 1, 1 / det G).

The energies are mixed: p is an unknown of its own, whose stationarity gives p = U'(J) (or
p = K tr e), so a law with D1 = 0 (or nu = 1/2) is as good as any other.

A layer that relaxes has, in a step of time, the energy of its law times a factor, and dead stresses
beside it; see `Remembered`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import singledispatch
from typing import Any, Protocol

import ufl

from bilayer.specimen.materials import Hyperelastic, Law, LinearElastic
from fenics_model.solid.unknown import freeze


@dataclass(frozen=True)
class Remembered:
    """What a layer remembers in a step of time; by default nothing, as an elastic one.

    See `bilayer.mechanics.memory`. The strain is split into a change of shape, E = s C / 2 with
    `StrainEnergy.scale` s, and that of volume. Each has its instantaneous stress: that of the
    change of shape, S0 = (2 / s) dW/dC (the deviator DEV of Simo and Hughes), and p0 = U'(J). At
    the end of a step they are factor S0 + pull and p = factor p0 + pressure.

    Parameters
    ----------
    factor : float or UFL constant
        c.
    pull : UFL tensor (3, 3) or None
        P of the change of shape, with the mesh as reference, Pa; None: zero.
    pressure : float or UFL expression
        P of the pressure, Pa.
    """

    factor: Any = 1
    pull: Any = None
    pressure: Any = 0

    def work(self, C: Any, scale: Any) -> Any:
        """Return P : E."""
        return 0 if self.pull is None else scale * ufl.inner(self.pull, C) / 2

    def instantaneous_pressure(self, pressure: Any) -> Any:
        """Return p0, Pa."""
        return (pressure - self.pressure) / self.factor


NOTHING = Remembered()


class StrainEnergy(Protocol):
    """The strain energy of a material, as the solid uses it."""

    def density(
        self, C: Any, J: Any, natural: Any, pressure: Any, memory: Remembered = NOTHING
    ) -> Any:
        """Energy per volume of the mesh, J/m3, as a UFL expression.

        Parameters
        ----------
        C : UFL tensor (3, 3)
            grad(x)^T grad(x), the deformation of the mesh without its rotation.
        J : UFL scalar
            det grad(x), which tells an inverted element from its mirror image.
        natural : UFL vector (4,)
            See `natural_tensor`.
        pressure : UFL scalar
            The independent pressure (positive in tension), Pa.
        memory : Remembered
            Of the layer.
        """
        ...

    def change_of_shape(self, C: Any, J: Any, natural: Any) -> Any:
        """Return the part of the energy that no pressure is needed for, J/m3."""
        ...

    def scale(self, J: Any, natural: Any) -> Any:
        """Return s of `Remembered`, with which C tells the change of shape alone."""
        ...

    @property
    def symbols(self) -> Mapping[str, Any]:
        """Symbols for the constants of the law, by the names of `energy_constants`."""
        ...


class UFLFunctions:
    """`bilayer.specimen.materials.Functions` of UFL expressions."""

    def log(self, x: Any, /) -> Any:
        """Return the natural logarithm."""
        return ufl.ln(x)

    def sqrt(self, x: Any, /) -> Any:
        """Return the square root."""
        return ufl.sqrt(x)

    def exp(self, x: Any, /) -> Any:
        """Return the exponential."""
        return ufl.exp(x)


_FUNCTIONS = UFLFunctions()


@dataclass(frozen=True)
class HyperelasticEnergy:
    """W = w(I1, I2) + p (J - 1) - p^2 D1 / 4, w the law's own energy of the isochoric invariants.

    The convention of Abaqus, whose U = (J - 1)^2 / D1 is regained by p = 2 (J - 1) / D1.

    UFL differentiates w if it is linear in the invariants, as Mooney-Rivlin's. Of any other w it
    differentiates the expansion to the second order about the present invariants,

        w + w_1 (I1 - present) + w_2 (I2 - present) + w_11 (I1 - present)^2 / 2 + ...,

    which has the value and the first two derivatives of w, and of which w and its derivatives are
    numbers: compiling a long w, such as Ogden's, takes a third of the time. The third derivative is
    another; nothing here needs it.

    Parameters
    ----------
    law : Hyperelastic
        With numbers, or with UFL constants in their place.
    """

    law: Hyperelastic

    def density(
        self, C: Any, J: Any, natural: Any, pressure: Any, memory: Remembered = NOTHING
    ) -> Any:
        """Energy per volume of the mesh; see `StrainEnergy`."""
        G = natural_tensor(natural)
        Je, own = J * ufl.det(G), pressure - memory.pressure
        isochoric = memory.factor * self._of_invariants(C, J, G)
        volumetric = pressure * (Je - 1) - own**2 * (self.law.d1 / memory.factor) / 4
        return (isochoric + volumetric) / ufl.det(G) + memory.work(C, self.scale(J, natural))

    def change_of_shape(self, C: Any, J: Any, natural: Any) -> Any:
        """Return w per volume of the mesh; see `StrainEnergy`."""
        G = natural_tensor(natural)
        return self._of_invariants(C, J, G) / ufl.det(G)

    def scale(self, J: Any, natural: Any) -> Any:
        """Return J^(-2/3); see `StrainEnergy`."""
        return ufl.exp(-2 / 3 * ufl.ln(J * ufl.det(natural_tensor(natural))))

    def _of_invariants(self, C: Any, J: Any, G: Any) -> Any:
        B = G * G
        I1, I2 = ufl.inner(C, B), ufl.inner(ufl.cofac(C), ufl.cofac(B))  # of Ce = G C G
        k = ufl.exp(-2 / 3 * ufl.ln(J * ufl.det(G)))
        return self._isochoric(k * I1, k * k * I2)

    def _isochoric(self, I1: Any, I2: Any) -> Any:
        present = freeze(I1), freeze(I2)
        w = self.law.slopes(*present, _FUNCTIONS)
        if w.is_linear:
            return self.law.energy(I1, I2, _FUNCTIONS)
        change = I1 - present[0], I2 - present[1]
        return w.value + w.first_along(change) + w.second_along(change, change) / 2

    @property
    def symbols(self) -> Mapping[str, Any]:
        """See `StrainEnergy`."""
        return self.law.numbers()


@dataclass(frozen=True)
class LinearEnergy:
    """w = mu dev(e):dev(e) + p tr(e) - p^2 / (2 K), of the strain e = E + eps0.

    E is the Green strain from the bonded flat state and eps0 the initial strain of eq. 9 of the
    paper, U - 1 in plane, with the thickness strain that leaves the bonded state in plane stress.
    That state's stress is E eps / (1 - nu), the corrected eq. 8.

    Parameters
    ----------
    shear_modulus : float or UFL constant
        mu, Pa.
    compliance : float or UFL constant
        1 / K, 1/Pa; 0 is incompressible.
    """

    shear_modulus: Any
    compliance: Any

    def density(
        self, C: Any, J: Any, natural: Any, pressure: Any, memory: Remembered = NOTHING
    ) -> Any:
        """Energy per volume of the mesh; see `StrainEnergy`."""
        thinning, strain = self._thinning_and_strain(C, natural)
        own = pressure - memory.pressure
        shear = memory.factor * self._shear(strain)
        bulk = pressure * ufl.tr(strain) - own**2 * (self.compliance / memory.factor) / 2
        return (shear + bulk) * thinning + memory.work(C, self.scale(J, natural))

    def change_of_shape(self, C: Any, J: Any, natural: Any) -> Any:
        """Return mu dev(e):dev(e) per volume of the mesh; see `StrainEnergy`."""
        thinning, strain = self._thinning_and_strain(C, natural)
        return self._shear(strain) * thinning

    def scale(self, J: Any, natural: Any) -> Any:
        """Return 1; see `StrainEnergy`."""
        return 1

    def _shear(self, strain: Any) -> Any:
        deviator = ufl.dev(strain)
        return self.shear_modulus * ufl.inner(deviator, deviator)

    def _thinning_and_strain(self, C: Any, natural: Any) -> tuple[Any, Any]:
        """Return the thickness of the bonded state over that in the mesh, and e."""
        thinning = 1 / ufl.det(natural_tensor(natural))
        thinned = ufl.diag(ufl.as_vector((1, 1, 1 / thinning)))
        strain = (thinned * C * thinned - ufl.Identity(3)) / 2 + self._initial_strain(natural)
        return thinning, strain

    @property
    def symbols(self) -> Mapping[str, Any]:
        """See `StrainEnergy`."""
        return vars(self)

    def _initial_strain(self, natural: Any) -> Any:
        ratio = self.shear_modulus * self.compliance
        poisson = (3 - 2 * ratio) / (6 + 2 * ratio)
        x, shear, y, _ = natural
        across = -poisson / (1 - poisson) * (x - 1 + y - 1)
        return ufl.as_matrix([[x - 1, shear, 0], [shear, y - 1, 0], [0, 0, across]])


def natural_tensor(natural: Any) -> Any:
    """Return G = [[Uxx, Uxy, 0], [Uxy, Uyy, 0], [0, 0, s]] of a natural state (Uxx, Uxy, Uyy, s).

    U is the in-plane stretch from the natural state to the bonded one, s the thickness in the mesh
    over the natural one. They may be numbers or UFL expressions.
    """
    x, shear, y, thickness = natural
    return ufl.as_matrix([[x, shear, 0], [shear, y, 0], [0, 0, thickness]])


def natural_determinant(natural: Any) -> float:
    """Return det G of a natural state in numbers, see `natural_tensor`."""
    x, shear, y, thickness = natural
    return float((x * y - shear * shear) * thickness)


def stress(
    energy: StrainEnergy, gradient: Any, natural: Any, pressure: Any, memory: Remembered = NOTHING
) -> Any:
    """Second Piola-Kirchhoff stress of a law, with the mesh as reference, Pa, as a UFL tensor.

    S = 2 dW/dC; its rows and columns are along the mesh's axes whatever the rotation.
    """
    C = ufl.variable(gradient.T * gradient)
    return 2 * ufl.diff(energy.density(C, ufl.sqrt(ufl.det(C)), natural, pressure, memory), C)


def stress_of_shape(energy: StrainEnergy, gradient: Any, natural: Any) -> Any:
    """Return S0 of `Remembered`, Pa, as a UFL tensor."""
    C = ufl.variable(gradient.T * gradient)
    J = ufl.sqrt(ufl.det(C))
    return 2 / energy.scale(J, natural) * ufl.diff(energy.change_of_shape(C, J, natural), C)


@singledispatch
def energy_constants(law: Law) -> tuple[Callable[..., StrainEnergy], dict[str, Any]]:
    """Return a function from the constants of a law to its energy, and their values.

    The values are numbers or tuples of them; UFL constants may be given in their place.
    """
    raise NotImplementedError(f"no strain energy for {type(law).__name__}")


@energy_constants.register
def _(law: Hyperelastic) -> tuple[Callable[..., StrainEnergy], dict[str, Any]]:
    def energy(**constants: Any) -> StrainEnergy:
        return HyperelasticEnergy(law.with_symbols(constants))

    return energy, law.numbers()


@energy_constants.register
def _(law: LinearElastic) -> tuple[Callable[..., StrainEnergy], dict[str, Any]]:
    return LinearEnergy, {"shear_modulus": law.shear_modulus, "compliance": 1 / law.bulk_modulus}
