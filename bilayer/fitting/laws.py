"""The laws that can be fitted: their unknowns, where these start and what bounds them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from bilayer.specimen.materials import (
    ArrudaBoyce,
    Gent,
    Hyperelastic,
    MooneyRivlin,
    NeoHookean,
    Ogden,
    Yeoh,
)


@dataclass(frozen=True)
class Fitted:
    """How a law is fitted.

    Parameters
    ----------
    law : callable
        Returns the law of the values of its unknowns and of D1.
    names : tuple of str
        Of the unknowns.
    units : tuple of str
        "Pa" or "".
    starts : callable
        Returns values from which to start, of the material's approximate shear modulus, Pa.
    lower, upper : tuple of float
        Bounds: within them the law is stable, or at least what its authors meant.
    needed : tuple of float
        Lower bounds that cannot be given up: beyond them there is no such law.
    """

    law: Callable[[Sequence[float], float], Hyperelastic]
    names: tuple[str, ...]
    units: tuple[str, ...]
    starts: Callable[[float], list[list[float]]]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    needed: tuple[float, ...]


def _ogden(terms: int) -> Fitted:
    """Return the fit of a law of Ogden; all its terms add to the stiffness, mu alpha > 0."""
    exponents = {
        1: [[2.0], [-2.0]],
        2: [[2.0, -2.0], [1.5, 5.0], [0.5, -5.0]],
        3: [[1.5, 5.0, -2.0], [0.5, 4.0, -5.0]],
    }[terms]

    def law(values: Sequence[float], d1: float) -> Hyperelastic:
        return Ogden(tuple(values[:terms]), tuple(values[terms:]), d1)

    def starts(shear: float) -> list[list[float]]:
        return [[shear / terms] * terms + given for given in exponents]

    return Fitted(
        law,
        tuple(f"mu{k + 1}" for k in range(terms)) + tuple(f"alpha{k + 1}" for k in range(terms)),
        ("Pa",) * terms + ("",) * terms,
        starts,
        (0.0,) * terms + (-20.0,) * terms,
        (math.inf,) * terms + (20.0,) * terms,
        (-math.inf,) * terms + (-20.0,) * terms,
    )


FITTED: dict[str, Fitted] = {
    "neo-hookean": Fitted(
        lambda v, d1: NeoHookean(v[0], 0.0, d1), ("c10",), ("Pa",),
        lambda mu: [[mu / 2]], (0.0,), (math.inf,), (0.0,),
    ),
    "mooney-rivlin": Fitted(
        lambda v, d1: MooneyRivlin(v[0], v[1], d1), ("c10", "c01"), ("Pa", "Pa"),
        lambda mu: [[mu / 4, mu / 4]], (0.0, 0.0), (math.inf,) * 2, (-math.inf,) * 2,
    ),
    "yeoh": Fitted(
        lambda v, d1: Yeoh(v[0], v[1], v[2], d1), ("c10", "c20", "c30"), ("Pa",) * 3,
        lambda mu: [[mu / 2, 0.0, 0.0]], (0.0, -math.inf, 0.0), (math.inf,) * 3,
        (0.0, -math.inf, -math.inf),
    ),
    "gent": Fitted(
        lambda v, d1: Gent(v[0], v[1], d1), ("mu", "jm"), ("Pa", ""),
        lambda mu: [[mu, 50.0], [mu, 5.0]], (0.0, 0.0), (math.inf, 1e4), (0.0, 0.0),
    ),
    "arruda-boyce": Fitted(
        lambda v, d1: ArrudaBoyce(v[0], v[1], d1), ("mu", "lambda_m"), ("Pa", ""),
        lambda mu: [[mu, 5.0], [mu, 2.0]], (0.0, 1.0), (math.inf, 100.0), (0.0, 1.0),
    ),
    "ogden-1": _ogden(1),
    "ogden-2": _ogden(2),
    "ogden-3": _ogden(3),
}  # fmt: skip
"""By name; of Ogden's law with its number of terms."""
