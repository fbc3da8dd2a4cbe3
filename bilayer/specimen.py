"""The specimen: a flat disc of two bonded layers, what is cut out of one, what stretches the other.

The substrate lies below (z < 0) and is pre-stretched; the kirigami layer lies above (z > 0) and
is not. z = 0 is the bond. Everything is in SI units and checked when it is made.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from bilayer.errors import InputError
from bilayer.material import Law
from bilayer.validation import not_negative, one_of, positive, whole

BONDED_THICKNESS_RULES = ("natural", "constant")
SMALLEST_STRETCH, LARGEST_STRETCH = 0.1, 10.0


@dataclass(frozen=True)
class Layer:
    """One homogeneous layer.

    Parameters
    ----------
    thickness : float
        Natural (unstretched) thickness, m.
    material : MooneyRivlin, NeoHookean or LinearElastic
        The law with its constants.
    density : float
        Mass density, kg/m3.
    """

    thickness: float
    material: Law
    density: float = 960.0

    def __post_init__(self) -> None:
        positive("thickness", self.thickness, "m")
        positive("density", self.density, "kg/m3")


@dataclass(frozen=True)
class CutPattern:
    """Equal sectors cut out of the kirigami layer, from the inner radius to the rim.

    Cutout k of n is centred at the angle 2 pi (k + 1/2) / n, so the first strip's centre line
    is the x axis.

    Parameters
    ----------
    strips : int
        Number of strips, as many as cutouts.
    inner_radius : float
        Where the cutouts begin, m.
    cutout_angle : float
        Central angle of one cutout (the paper's dTheta), rad.
    """

    strips: int
    inner_radius: float
    cutout_angle: float

    def __post_init__(self) -> None:
        if self.strips == 0:
            raise InputError("cut.strips = 0: leave the [cut] table out for an uncut disc")
        whole("cut.strips", self.strips, at_least=1)
        positive("cut.inner_radius", self.inner_radius, "m")
        positive("cut.cutout_angle", self.cutout_angle, "rad")
        widest = 2 * math.pi / self.strips
        if self.cutout_angle >= widest:
            raise InputError(
                f"cut.cutout_angle = {self.cutout_angle} rad: {self.strips} cutouts need less "
                f"than 2*pi/{self.strips} = {widest:.4g} rad each, or they overlap"
            )

    @property
    def cutout_centres(self) -> list[float]:
        """Angles of the cutouts' centre lines, rad."""
        return [2 * math.pi * (k + 0.5) / self.strips for k in range(self.strips)]


@dataclass(frozen=True)
class Prestretch:
    """The substrate's prestretch, as a path of milestones, each a shape to be computed.

    Parameters
    ----------
    milestones : sequence of float or of (float, float)
        Stretch at each milestone, ascending: one number for an equibiaxial stretch or a pair
        (lambda_x, lambda_y). A pair counts in the order by its larger number.
    thickness : {"natural", "constant"}
        "natural": the substrate keeps its volume, bonded thickness = natural / (lambda_x lambda_y).
        "constant": bonded thickness = natural whatever the stretch, the paper's simplification.
    """

    milestones: tuple[tuple[float, float], ...]
    thickness: str = "natural"

    def __post_init__(self) -> None:
        if isinstance(self.milestones, str) or not isinstance(self.milestones, Iterable):
            raise InputError(
                f"prestretch.milestones = {self.milestones!r}: expected a list of numbers"
            )
        pairs = tuple(_stretch_pair(milestone) for milestone in self.milestones)
        if not pairs:
            raise InputError("prestretch.milestones = []: expected at least one")
        nominal = [max(pair) for pair in pairs]
        for before, after in pairwise(nominal):
            if after <= before:
                raise InputError(
                    f"prestretch.milestones = {list(self.milestones)}: expected ascending numbers, "
                    f"each once, but {after} follows {before}"
                )
        object.__setattr__(self, "milestones", pairs)
        one_of("prestretch.thickness", self.thickness, BONDED_THICKNESS_RULES)

    @property
    def nominal(self) -> list[float]:
        """The larger stretch of each milestone: the coordinate `prestretch` of a result."""
        return [max(pair) for pair in self.milestones]


@dataclass(frozen=True)
class MeshSize:
    """Edge lengths asked of the planar mesh.

    Parameters
    ----------
    size : float
        Edge length, m.
    corner_size : float or None
        Edge length at the cutouts' inner corners, m; None: `size` everywhere.
    """

    size: float = 0.004
    corner_size: float | None = None

    def __post_init__(self) -> None:
        positive("mesh.size", self.size, "m")
        if self.corner_size is not None:
            positive("mesh.corner_size", self.corner_size, "m")
            if self.corner_size > self.size:
                raise InputError(
                    f"mesh.corner_size = {self.corner_size} m: expected at most "
                    f"mesh.size = {self.size} m"
                )


@dataclass(frozen=True)
class Specimen:
    """A flat bilayer, what it is made of, and the prestretches at which its shape is wanted.

    Parameters
    ----------
    outer_radius : float
        Radius of the bonded disc, m.
    substrate, kirigami : Layer
        The lower, pre-stretched layer and the upper, unstretched one.
    prestretch : Prestretch
        Milestones of the substrate's prestretch.
    cut : CutPattern or None
        What is cut out of the kirigami layer; None leaves it whole.
    mesh : MeshSize
        Edge lengths of the planar mesh.
    gravity : float
        Acceleration of the true weight along -z, m/s2.
    name : str
        A label for figures and files.
    """

    outer_radius: float
    substrate: Layer
    kirigami: Layer
    prestretch: Prestretch
    cut: CutPattern | None = None
    mesh: MeshSize = MeshSize()
    gravity: float = 0.0
    name: str = "specimen"

    def __post_init__(self) -> None:
        positive("specimen.outer_radius", self.outer_radius, "m")
        not_negative("gravity.acceleration", self.gravity, "m/s2")
        if self.cut is not None and self.cut.inner_radius >= self.outer_radius:
            raise InputError(
                f"cut.inner_radius = {self.cut.inner_radius} m: expected less than "
                f"specimen.outer_radius = {self.outer_radius} m"
            )
        if self.mesh.size > self.outer_radius:
            raise InputError(
                f"mesh.size = {self.mesh.size} m: expected at most "
                f"specimen.outer_radius = {self.outer_radius} m"
            )

    def bonded_thickness(self, stretch: tuple[float, float]) -> float:
        """Thickness of the stretched substrate when it is bonded, m.

        Parameters
        ----------
        stretch : (float, float)
            (lambda_x, lambda_y).
        """
        if self.prestretch.thickness == "constant":
            return self.substrate.thickness
        return self.substrate.thickness / (stretch[0] * stretch[1])

    def with_milestones(self, milestones: Sequence[float | tuple[float, float]]) -> "Specimen":
        """Return the same specimen with other prestretches."""
        path = Prestretch(tuple(milestones), self.prestretch.thickness)  # type: ignore[arg-type]
        return replace(self, prestretch=path)


def _stretch_pair(milestone: float | Sequence[float]) -> tuple[float, float]:
    field = "prestretch.milestones"
    if isinstance(milestone, Sequence) and not isinstance(milestone, str):
        if len(milestone) != 2:
            raise InputError(
                f"{field} = {list(milestone)}: expected one number or [lambda_x, lambda_y]"
            )
        return _stretch(milestone[0]), _stretch(milestone[1])
    return _stretch(milestone), _stretch(milestone)


def _stretch(value: float) -> float:
    number = positive("prestretch.milestones", value)
    if not SMALLEST_STRETCH <= number <= LARGEST_STRETCH:
        raise InputError(
            f"prestretch.milestones = {value}: expected stretches from {SMALLEST_STRETCH:g} to "
            f"{LARGEST_STRETCH:g}"
        )
    return number
