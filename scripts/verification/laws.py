"""Hyperelastic laws with their closed forms, written down without the laws' own code. SI units.

A closed form is the energy and t_i = l_i dW / dl_i by the principal stretches at constant volume:
the Cauchy stress of an incompressible body is t_i less the pressure.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer import ArrudaBoyce, Gent, MooneyRivlin, NeoHookean, Ogden, Yeoh
from verification.rung import Check

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LawCase:
    """An incompressible law and its closed form."""

    law: object
    energy: Callable[[Array], float]
    tension: Callable[[Array], Array]

    def compressible(self, d1: float):
        """The same law with a compressibility, 1/Pa."""
        return replace(self.law, d1=d1)

    def uniaxial_nominal(self, stretch: float) -> float:
        """Nominal stress of a bar."""
        along, across, _ = self.tension(np.array([stretch, stretch**-0.5, stretch**-0.5]))
        return (along - across) / stretch

    def equibiaxial_cauchy(self, stretch: float) -> float:
        """Cauchy stress of a sheet that is stretched equally in both directions."""
        along, _, across = self.tension(np.array([stretch, stretch, stretch**-2]))
        return along - across

    def planar_nominal(self, stretch: float) -> tuple[float, float]:
        """Nominal stresses, along and across, of a sheet whose width is held."""
        along, width, across = self.tension(np.array([stretch, 1.0, 1 / stretch]))
        return (along - across) / stretch, width - across

    def first_piola(self, F: Array, d1: float) -> tuple[float, Array]:
        """Energy density and first Piola-Kirchhoff stress of the compressible law."""
        turned, stretches, axes = np.linalg.svd(F)
        J = stretches.prod()
        isochoric = stretches * J ** (-1 / 3)
        tension = self.tension(isochoric)
        tension = tension - tension.mean() + J * 2 * (J - 1) / d1
        energy = self.energy(isochoric) + (J - 1) ** 2 / d1
        return energy, turned @ np.diag(tension / stretches) @ axes


def _of_invariants(law, energy, slopes) -> LawCase:
    """A law by w(I1, I2) and its derivatives by them."""

    def tension(stretches: Array) -> Array:
        squares = stretches**2
        by_I1, by_I2 = slopes(squares.sum(), (1 / squares).sum())
        return 2 * (by_I1 * squares - by_I2 / squares)

    def density(stretches: Array) -> float:
        return energy((stretches**2).sum(), (stretches**-2.0).sum())

    return LawCase(law, density, tension)


def _yeoh(c10: float, c20: float, c30: float) -> LawCase:
    return _of_invariants(
        Yeoh(c10, c20, c30),
        lambda I1, I2: c10 * (I1 - 3) + c20 * (I1 - 3) ** 2 + c30 * (I1 - 3) ** 3,
        lambda I1, I2: (c10 + 2 * c20 * (I1 - 3) + 3 * c30 * (I1 - 3) ** 2, 0.0),
    )


def _gent(mu: float, jm: float) -> LawCase:
    return _of_invariants(
        Gent(mu, jm),
        lambda I1, I2: -mu * jm / 2 * np.log(1 - (I1 - 3) / jm),
        lambda I1, I2: (mu / 2 * jm / (jm - I1 + 3), 0.0),
    )


def _arruda_boyce(mu: float, lambda_m: float) -> LawCase:
    c = np.array([1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750])
    i = np.arange(1, 6)
    weights = mu * c / lambda_m ** (2.0 * i - 2)
    return _of_invariants(
        ArrudaBoyce(mu, lambda_m),
        lambda I1, I2: float(weights @ (I1**i - 3.0**i)),
        lambda I1, I2: (float(weights @ (i * I1 ** (i - 1.0))), 0.0),
    )


def _mooney_rivlin(law: MooneyRivlin) -> LawCase:
    return _of_invariants(
        law,
        lambda I1, I2: law.c10 * (I1 - 3) + law.c01 * (I2 - 3),
        lambda I1, I2: (law.c10, law.c01),
    )


def _ogden(mu: list[float], alpha: list[float]) -> LawCase:
    m, a = np.array(mu), np.array(alpha)
    return LawCase(
        Ogden(mu, alpha),
        lambda x: float((2 * m / a**2) @ ((x ** a[:, None]).sum(axis=1) - 3)),
        lambda x: (2 * m / a) @ x ** a[:, None],
    )


LAW_CASES = {
    "mooney-rivlin": _mooney_rivlin(MooneyRivlin(4839.1, 14_536.0)),
    "neo-hookean": _mooney_rivlin(NeoHookean(19_375.0)),
    "yeoh": _yeoh(19_000.0, -2000.0, 900.0),
    "gent": _gent(38_750.0, 5.0),
    "arruda-boyce": _arruda_boyce(35_000.0, 2.0),
    "ogden": _ogden([30_000.0, 8000.0, 1000.0], [1.3, -2.0, 4.0]),
}
"""Each law with constants of the tape's order; Ogden's exponents whole and not."""

STRETCHES = (1.06, 1.24)


def law_checks(
    name: str,
    case: LawCase,
    stretch: float,
    uniaxial: float,
    equibiaxial: float,
    planar: tuple[float, float],
) -> Iterator[Check]:
    """Stresses that a solver finds beside the closed forms."""
    at = f"{name}, {stretch:g}"
    expected = case.uniaxial_nominal(stretch)
    yield Check(f"{at}: uniaxial, nominal (Pa)", uniaxial, expected, 1e-6)
    expected = case.equibiaxial_cauchy(stretch)
    yield Check(f"{at}: equibiaxial, Cauchy (Pa)", equibiaxial, expected, 1e-6)
    for side, found, closed in zip(
        ("along", "across"), planar, case.planar_nominal(stretch), strict=True
    ):
        yield Check(f"{at}: planar, {side} (Pa)", found, closed, 1e-6)
