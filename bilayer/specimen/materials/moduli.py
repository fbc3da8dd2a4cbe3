"""Small-strain moduli, checked."""

import math
from typing import Any

from bilayer.errors import InputError
from bilayer.validation import finite, positive


def shear_and_bulk(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Return mu = E / (2 (1 + nu)) and K = E / (3 (1 - 2 nu)), Pa; K is infinite at nu = 1/2."""
    young = positive("young_modulus", young_modulus, "Pa")
    nu = finite("poisson_ratio", poisson_ratio)
    if not 0 <= nu <= 0.5:
        raise InputError(f"poisson_ratio = {poisson_ratio}: expected from 0 to 0.5")
    bulk = young / (3 * (1 - 2 * nu)) if nu < 0.5 else math.inf
    return young / (2 * (1 + nu)), bulk


def plain_number(field: str, value: Any) -> float:
    """Return a finite number as Python's own; whole numbers stay whole, as a file has them."""
    number = finite(field, value)
    return value if isinstance(value, int) else number
