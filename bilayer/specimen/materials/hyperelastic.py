"""Hyperelastic laws: the energy of a change of shape, with compressibility composed in.

    W = w(I1, I2) + (J - 1)^2 / D1,    I1 = J^(-2/3) tr C,  I2 = J^(-4/3) ((tr C)^2 - tr C^2) / 2

Conventions are those of Abaqus, which the paper used: K = 2 / D1, and D1 = 0 is incompressible. A
law writes w once, in arithmetic that floats, arrays, jets and UFL expressions share; stresses and
moduli follow by differentiation, and how is the business of each solver.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from typing import Any, ClassVar, Self

import numpy as np

from bilayer.errors import InputError
from bilayer.specimen.materials.jet import Jet, JetFunctions
from bilayer.specimen.materials.law import Functions, Stretches
from bilayer.specimen.materials.moduli import plain_number, shear_and_bulk
from bilayer.validation import not_negative


class Hyperelastic(ABC):
    """A law of an energy; subclasses are frozen dataclasses of their constants.

    A new law is a subclass with the fields of its constants (`d1` the last of them), `name`,
    `units` and `energy`; `moduli` and `from_moduli` let a file give it by its moduli.
    `register_law` makes it known to specimen files and results.

    Attributes
    ----------
    name, units, moduli
        See `Law`.
    structure : tuple of str
        Constants that decide which expression the energy is: a solver that compiles energies
        compiles anew for each of their values.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> isinstance(bilayer.NeoHookean(c10=20e3), bilayer.Hyperelastic)
    True
    """

    name: ClassVar[str]
    units: ClassVar[Mapping[str, str]]
    moduli: ClassVar[Mapping[str, str]] = {}
    structure: ClassVar[tuple[str, ...]] = ()
    d1: float

    def __post_init__(self) -> None:
        for key in self.units:
            self._check(key)
        not_negative("d1", self.d1, "1/Pa")
        self._check_moduli()

    def _check(self, key: str) -> None:
        """Check one constant and keep what the check returns."""
        object.__setattr__(self, key, plain_number(key, getattr(self, key)))

    def _check_moduli(self) -> None:
        if not self.shear_modulus > 0:
            raise InputError(
                f"law = {self.name!r}: the constants make a shear modulus of "
                f"{self.shear_modulus:.6g} Pa, expected more than 0"
            )
        largest = 3 / self.shear_modulus
        if self.d1 > largest * (1 + 1e-12):
            raise InputError(
                f"d1 = {self.d1} 1/Pa: expected at most {largest:.6g} 1/Pa, "
                "which is a Poisson ratio of 0"
            )

    @abstractmethod
    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """Return w, the energy of the change of shape, per natural volume, J/m3.

        Parameters
        ----------
        I1, I2 : float, array, Jet or UFL expression
            Isochoric invariants of C; both are 3 in the natural state, where w is 0.
        functions : Functions
            `log`, `sqrt` and `exp` for the kind of number that I1 and I2 are.
        """

    def slopes(self, I1: Any, I2: Any, functions: Any = np) -> Jet:
        """Return w with its first and second derivatives by I1 and I2, Pa; see `energy`."""
        expanded = self.energy(*Jet.variables(I1, I2), JetFunctions(functions))
        return expanded if isinstance(expanded, Jet) else Jet(expanded)

    def numbers(self) -> dict[str, Any]:
        """Return the constants whose values leave the expression of the energy the same."""
        return {key: getattr(self, key) for key in self.units if key not in self.structure}

    def with_symbols(self, symbols: Mapping[str, Any]) -> Self:
        """Return the law with symbols in place of `numbers`; its energy is then symbolic."""
        law = copy(self)
        for name, symbol in symbols.items():
            object.__setattr__(law, name, symbol)
        return law

    @property
    def shear_modulus(self) -> float:
        """Small-strain shear modulus mu = 2 (dw/dI1 + dw/dI2), Pa."""
        by_I1, by_I2 = self.slopes(3.0, 3.0).first
        return float(2 * (by_I1 + by_I2))

    @property
    def bulk_modulus(self) -> float:
        """Small-strain bulk modulus K, Pa; infinite if d1 = 0."""
        return 2 / self.d1 if self.d1 > 0 else math.inf

    @property
    def poisson_ratio(self) -> float:
        """Small-strain Poisson ratio."""
        ratio = self.shear_modulus * self.d1 / 2  # mu / K
        return max(0.0, (3 - 2 * ratio) / (6 + 2 * ratio))

    @property
    def young_modulus(self) -> float:
        """Small-strain Young's modulus, Pa."""
        return 2 * self.shear_modulus * (1 + self.poisson_ratio)

    def natural_scale(self, stretch: Stretches) -> tuple[float, float, float]:
        """See `Law`; the volume is kept: (1 / lx, 1 / ly, lx ly)."""
        x, y = stretch
        return 1 / x, 1 / y, x * y


def shear_and_d1(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Return mu, Pa, and D1, 1/Pa, of small-strain moduli."""
    shear, bulk = shear_and_bulk(young_modulus, poisson_ratio)
    return shear, 2 / bulk
