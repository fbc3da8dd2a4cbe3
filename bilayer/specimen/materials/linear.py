"""The linear law of the paper's eqs. 8-9."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from bilayer.errors import InputError
from bilayer.specimen.materials.law import Stretches
from bilayer.specimen.materials.moduli import plain_number, shear_and_bulk


@dataclass(frozen=True)
class LinearElastic:
    """The linear law of the paper's eqs. 8-9, a linear answer to strain plus initial strain.

    Eq. 8 prints the prestress of an equibiaxial stretch as E eps (1 - nu); Hooke's law in plane
    stress gives E eps / (1 - nu), which is what this law does (2.0 E eps against the printed
    0.5 E eps at nu = 1/2).

    Parameters
    ----------
    young_modulus : float
        E, Pa.
    poisson_ratio : float
        nu, from 0 to 0.5.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.LinearElastic(young_modulus=116250.0, poisson_ratio=0.49).young_modulus
    116250.0
    """

    young_modulus: float
    poisson_ratio: float

    name: ClassVar[str] = "linear"
    units: ClassVar[Mapping[str, str]] = {"young_modulus": "Pa", "poisson_ratio": ""}
    moduli: ClassVar[Mapping[str, str]] = {}

    def __post_init__(self) -> None:
        shear_and_bulk(self.young_modulus, self.poisson_ratio)
        for key in self.units:
            object.__setattr__(self, key, plain_number(key, getattr(self, key)))

    @property
    def shear_modulus(self) -> float:
        """Shear modulus mu, Pa."""
        return shear_and_bulk(self.young_modulus, self.poisson_ratio)[0]

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus K, Pa; infinite if nu = 1/2."""
        return shear_and_bulk(self.young_modulus, self.poisson_ratio)[1]

    def natural_scale(self, stretch: Stretches) -> tuple[float, float, float]:
        """See `Law`.

        The energy is that of the strain e = E + eps0, E the Green strain from the bonded flat
        state. With A = sqrt(I - 2 eps0), e = A E' A, where E' is the Green strain from the mesh
        scaled by A: A is the natural state.
        """
        in_plane = stretch[0] - 1, stretch[1] - 1
        nu = self.poisson_ratio
        strains = (*in_plane, -nu / (1 - nu) * sum(in_plane))  # eq. 9 of the paper
        squares = [1 - 2 * strain for strain in strains]
        if min(squares) <= 0:
            raise InputError(
                f"prestretch.milestones = {max(stretch):g}: the linear law has no stress-free "
                "state there, expected less than 1.5"
            )
        x, y, z = (math.sqrt(square) for square in squares)
        return x, y, z
