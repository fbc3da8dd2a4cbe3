"""Neo-Hookean: w = C10 (I1 - 3), mu = 2 C10."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from bilayer.errors import InputError
from bilayer.specimen.materials.mooney_rivlin import MooneyRivlin


@dataclass(frozen=True)
class NeoHookean(MooneyRivlin):
    """Mooney-Rivlin without the second invariant: C01 = 0.

    Examples
    --------
    >>> import bilayer
    >>> round(bilayer.NeoHookean(c10=20e3).young_modulus)
    120000
    """

    c01: float = 0.0

    name: ClassVar[str] = "neo-hookean"
    units: ClassVar[Mapping[str, str]] = {"c10": "Pa", "d1": "1/Pa"}
    moduli: ClassVar[Mapping[str, str]] = {"young_modulus": "Pa", "poisson_ratio": ""}

    def _check_moduli(self) -> None:
        if self.c01 != 0:
            raise InputError(f"c01 = {self.c01} Pa: expected 0 for law = 'neo-hookean'")
        super()._check_moduli()
