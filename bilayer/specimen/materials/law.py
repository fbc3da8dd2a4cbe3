"""The members of a material law that the rest of the project uses."""

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol

Stretches = tuple[float, float]


class Functions(Protocol):
    """The functions that an energy may use besides arithmetic: NumPy, UFL and `Jet` have them."""

    def log(self, x: Any, /) -> Any:
        """Return the natural logarithm."""

    def sqrt(self, x: Any, /) -> Any:
        """Return the square root."""

    def exp(self, x: Any, /) -> Any:
        """Return the exponential."""


class Law(Protocol):
    """The material of a layer: its constants, its small-strain moduli and its natural state.

    Attributes
    ----------
    name : str
        What a specimen file calls the law.
    units : mapping of str to str
        Keys of its constants in a file, each with its unit.
    moduli : mapping of str to str
        Keys of the other way to give it, by moduli, each with its unit; empty: there is none.
    """

    name: ClassVar[str]
    units: ClassVar[Mapping[str, str]]
    moduli: ClassVar[Mapping[str, str]]

    @property
    def shear_modulus(self) -> float:
        """Small-strain shear modulus mu, Pa."""

    @property
    def bulk_modulus(self) -> float:
        """Small-strain bulk modulus K, Pa; infinite if the law is incompressible."""

    @property
    def young_modulus(self) -> float:
        """Small-strain Young's modulus E, Pa."""

    @property
    def poisson_ratio(self) -> float:
        """Small-strain Poisson ratio nu."""

    def natural_scale(self, stretch: Stretches) -> tuple[float, float, float]:
        """Return natural lengths over bonded ones of a layer that is bonded under a stretch.

        Parameters
        ----------
        stretch : (float, float)
            Principal stretches in the plane.

        Returns
        -------
        (float, float, float)
            Along the two principal axes and through the thickness.

        Raises
        ------
        InputError
            The layer has no stress-free state.
        """
