"""The specimen: a flat disc of two bonded layers, what is cut out of one, what is stretched.

z = 0 is the bond. The substrate is whole; the kirigami layer may be cut and lies above it or below.
The one or the other or both are pre-stretched. `Specimen.bonded_layers` says what lies where, and
how stretched: that is all a solver needs. Everything is in SI units and checked when it is made.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from bilayer.errors import InputError
from bilayer.specimen.material import Law
from bilayer.validation import not_negative, one_of, positive, whole

LAYERS = ("substrate", "kirigami")
SIDES = ("above", "below")
BARE, KIRIGAMI = 0, 1
"""Regions of the disc: where the kirigami layer is cut out, and where it lies."""
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
class BondedLayer:
    """A layer where it lies in the flat bonded state, and how far that is from its natural one.

    Parameters
    ----------
    name : {"substrate", "kirigami"}
        Which one.
    layer : Layer
        What it is made of.
    bottom, top : float
        Heights above the bond, m; one of them is 0.
    stretch : (float, float)
        (lambda_x, lambda_y) from the natural state.
    regions : tuple of int
        Which regions of the disc it covers: `BARE`, `KIRIGAMI`.
    """

    name: str
    layer: Layer
    bottom: float
    top: float
    stretch: tuple[float, float]
    regions: tuple[int, ...]

    @property
    def thickness(self) -> float:
        """Thickness as bonded, m."""
        return self.top - self.bottom

    @property
    def is_above(self) -> bool:
        """Whether it lies on the upper side of the bond."""
        return self.top > 0


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
    """The prestretch, as a path of milestones, each a shape to be computed.

    Parameters
    ----------
    milestones : sequence of float or of (float, float)
        Stretch at each milestone, in the order in which the path takes them: one number for an
        equibiaxial stretch or a pair (lambda_x, lambda_y). It may come down again, and a stretch
        may come more than once.
    thickness : {"natural", "constant"}
        "natural": a stretched layer keeps its volume, bonded thickness = natural / (lambda_x
        lambda_y). "constant": `Layer.thickness` whatever the stretch, the paper's simplification.
    layers : sequence of {"substrate", "kirigami"}
        Which are stretched, one or both.
    """

    milestones: tuple[tuple[float, float], ...]
    thickness: str = "natural"
    layers: tuple[str, ...] = ("substrate",)

    def __post_init__(self) -> None:
        if isinstance(self.milestones, str) or not isinstance(self.milestones, Iterable):
            raise InputError(
                f"prestretch.milestones = {self.milestones!r}: expected a list of numbers"
            )
        pairs = tuple(_stretch_pair(milestone) for milestone in self.milestones)
        if not pairs:
            raise InputError("prestretch.milestones = []: expected at least one")
        object.__setattr__(self, "milestones", pairs)
        one_of("prestretch.thickness", self.thickness, BONDED_THICKNESS_RULES)
        object.__setattr__(self, "layers", _stretched_layers(self.layers))

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

    size: float = 0.003
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
        The whole layer and the one that may be cut.
    prestretch : Prestretch
        Milestones, and which of the layers are stretched.
    cut : CutPattern or None
        What is cut out of the kirigami layer; None leaves it whole.
    mesh : MeshSize
        Edge lengths of the planar mesh.
    gravity : float
        Acceleration of the true weight along -z, m/s2.
    name : str
        A label for figures and files.
    kirigami_side : {"above", "below"}
        Where the kirigami layer lies, seen from the substrate.
    """

    outer_radius: float
    substrate: Layer
    kirigami: Layer
    prestretch: Prestretch
    cut: CutPattern | None = None
    mesh: MeshSize = MeshSize()
    gravity: float = 0.0
    name: str = "specimen"
    kirigami_side: str = "above"

    def __post_init__(self) -> None:
        positive("specimen.outer_radius", self.outer_radius, "m")
        not_negative("gravity.acceleration", self.gravity, "m/s2")
        one_of("kirigami.side", self.kirigami_side, SIDES)
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

    @property
    def kirigami_share(self) -> float:
        """Part of the disc's area that the kirigami layer covers, from 0 to 1."""
        if self.cut is None:
            return 1.0
        sectors = self.cut.strips * self.cut.cutout_angle / (2 * math.pi)
        return 1.0 - sectors * (1.0 - (self.cut.inner_radius / self.outer_radius) ** 2)

    def bonded_layers(self, stretch: tuple[float, float]) -> tuple[BondedLayer, BondedLayer]:
        """Return both layers in the flat bonded state, the lower one first.

        Parameters
        ----------
        stretch : (float, float)
            (lambda_x, lambda_y) of the layers that are stretched.
        """
        above = self.bonded_layer("kirigami", stretch).is_above
        names = LAYERS if above else LAYERS[::-1]
        lower, upper = (self.bonded_layer(name, stretch) for name in names)
        return lower, upper

    def bonded_layer(self, name: str, stretch: tuple[float, float]) -> BondedLayer:
        """Return one layer, by its name, in the flat bonded state; see `bonded_layers`."""
        layer = {"substrate": self.substrate, "kirigami": self.kirigami}[name]
        own = stretch if name in self.prestretch.layers else (1.0, 1.0)
        kept = self.prestretch.thickness == "constant"
        thickness = layer.thickness if kept else layer.thickness / (own[0] * own[1])
        above = (name == "kirigami") == (self.kirigami_side == "above")
        bottom, top = (0.0, thickness) if above else (-thickness, 0.0)
        regions = (BARE, KIRIGAMI) if name == "substrate" else (KIRIGAMI,)
        return BondedLayer(name, layer, bottom, top, own, regions)

    def with_milestones(self, milestones: Sequence[float | tuple[float, float]]) -> "Specimen":
        """Return the same specimen with other prestretches."""
        path = replace(self.prestretch, milestones=tuple(milestones))  # type: ignore[arg-type]
        return replace(self, prestretch=path)


def _stretched_layers(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names in the order of `LAYERS`."""
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise InputError(f"prestretch.layers = {names!r}: expected a list, such as ['substrate']")
    given = [one_of("prestretch.layers", name, LAYERS) for name in names]
    if not given or len(set(given)) < len(given):
        raise InputError(f"prestretch.layers = {given}: expected one or both, each once")
    return tuple(name for name in LAYERS if name in given)


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
