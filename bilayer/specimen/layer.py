"""A layer of the sheet, what the prestretch does to it, and where it lies when it is bonded."""

import math
import re
from dataclasses import dataclass
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.materials import Law
from bilayer.specimen.pattern import Pattern
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair, stretch_pair
from bilayer.specimen.relaxation import ELASTIC, PronySeries
from bilayer.validation import finite, keep, one_of, positive, text

RESPONSES = ("none", "path", "fixed")
LONGEST_NAME = 100
"""Letters of a layer's name, which begins names of variables: NetCDF allows those 256."""
Tensor = tuple[tuple[float, float], tuple[float, float]]
"""A symmetric 2x2 tensor in the plane, by rows."""


@dataclass(frozen=True)
class Response:
    """The stretch that the prestretch gives a layer before it is bonded.

    Parameters
    ----------
    kind : {"none", "path", "fixed"}
        "none": the layer is bonded as it is. "path": it is stretched by each milestone. "fixed": by
        a stretch of its own, the same at every milestone.
    stretch : float or (float, float)
        The stretch of "fixed", along the two axes; (1, 1) otherwise.
    factor : float
        Of "path": the layer takes 1 + factor (lambda - 1) along each axis.
    angle : float
        Of the first axis from x, rad.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Response("path", factor=0.5).axial((1.06, 1.06))
    (1.03, 1.03)
    """

    kind: str = "none"
    stretch: StretchPair = UNSTRETCHED
    factor: float = 1.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        keep(self, one_of, "kind", choices=RESPONSES)
        keep(self, stretch_pair, "stretch")
        keep(self, finite, "factor", "angle")
        if self.kind != "fixed" and self.stretch != UNSTRETCHED:
            raise InputError(f"stretch = {list(self.stretch)}: expected with kind = 'fixed' alone")
        if self.kind != "path" and self.factor != 1.0:
            raise InputError(f"factor = {self.factor}: expected with kind = 'path' alone")
        if self.kind == "none" and self.angle != 0.0:
            raise InputError(f"angle = {self.angle} rad: expected with kind = 'path' or 'fixed'")

    @property
    def is_along_axes(self) -> bool:
        """Whether it stretches along x and y."""
        return self.angle == 0.0 or (self.kind == "fixed" and self.stretch[0] == self.stretch[1])

    def axial(self, path: StretchPair) -> StretchPair:
        """Return the stretches along the layer's own two axes where the path is at a stretch."""
        if self.kind == "path":
            x, y = (self._of_path(stretch) for stretch in path)
            return x, y
        return self.stretch

    def tensor(self, path: StretchPair) -> Tensor:
        """Return the stretch from the natural state to the bonded one, in x and y."""
        first, second = self.axial(path)
        if self.angle == 0.0 or first == second:
            return (first, 0.0), (0.0, second)
        c, s = math.cos(self.angle), math.sin(self.angle)
        shear = (first - second) * c * s
        return (first * c * c + second * s * s, shear), (shear, first * s * s + second * c * c)

    def _of_path(self, stretch: float) -> float:
        own = stretch if self.factor == 1.0 else 1.0 + self.factor * (stretch - 1.0)
        if own <= 0:
            raise InputError(
                f"factor = {self.factor}: makes a stretch of {own:g} of the path's {stretch:g}, "
                "expected a number greater than 0"
            )
        return own


@dataclass(frozen=True)
class Layer:
    """One homogeneous layer.

    Parameters
    ----------
    name : str
        Its own among the layers of a specimen: letters, digits, - and _, a letter first.
    thickness : float
        Natural (unstretched) thickness, m.
    material : MooneyRivlin, NeoHookean or LinearElastic
        The law with its constants.
    density : float
        Mass density, kg/m3.
    pattern : Pattern or None
        Where on the sheet it lies; None: everywhere, a whole layer.
    response : Response
        What the prestretch does to it.
    relaxation : PronySeries
        How its stress relaxes; elastic if left out.

    Examples
    --------
    >>> import bilayer
    >>> tape = bilayer.MooneyRivlin(c10=4839.1, c01=14536.0)
    >>> bilayer.Layer("substrate", 1e-3, tape, response=bilayer.Response("path")).is_whole
    True
    """

    name: str
    thickness: float
    material: Law
    density: float = 960.0
    pattern: Pattern | None = None
    response: Response = Response()
    relaxation: PronySeries = ELASTIC

    def __post_init__(self) -> None:
        keep(self, layer_name, "name")
        keep(self, positive, "thickness", unit="m")
        keep(self, positive, "density", unit="kg/m3")
        if not isinstance(self.response, Response):
            raise InputError(f"response = {self.response!r}: expected a Response")

    @property
    def is_whole(self) -> bool:
        """Whether it lies everywhere on the sheet."""
        return self.pattern is None

    @property
    def is_stretched(self) -> bool:
        """Whether the prestretch does anything to it."""
        return self.response.kind != "none"


@dataclass(frozen=True)
class BondedLayer:
    """A layer where it lies in the flat bonded state, and how far that is from its natural one.

    Parameters
    ----------
    name : str
        Which one.
    layer : Layer
        What it is made of.
    bottom, top : float
        Heights above the specimen's reference surface, m.
    stretch : ((float, float), (float, float))
        The symmetric in-plane tensor U from the natural state, in x and y.

    Examples
    --------
    >>> import bilayer
    >>> lower, upper = bilayer.paper_specimen().bonded_layers((1.06, 1.06))
    >>> lower.name, upper.name, [round(1e3 * z, 3) for z in (lower.bottom, lower.top)]
    ('substrate', 'kirigami', [-0.89, 0.0])
    """

    name: str
    layer: Layer
    bottom: float
    top: float
    stretch: Tensor

    @property
    def thickness(self) -> float:
        """Thickness as bonded, m."""
        return self.top - self.bottom

    @property
    def determinant(self) -> float:
        """Area as bonded over the natural one."""
        (a, b), (_, c) = self.stretch
        return a * c - b * b

    @property
    def axial_stretch(self) -> StretchPair:
        """Stretch along x and along y, all that there is if the axes are not turned."""
        return self.stretch[0][0], self.stretch[1][1]

    @property
    def principal_stretches(self) -> StretchPair:
        """The larger and the smaller stretch, along axes at right angles."""
        (a, b), (_, c) = self.stretch
        mean, half = (a + c) / 2, math.hypot((a - c) / 2, b)
        return mean + half, mean - half

    @property
    def is_above(self) -> bool:
        """Whether all of it lies above the reference surface."""
        return self.bottom >= 0


def layer_name(field: str, value: Any) -> str:
    """Return a layer's name; raise InputError unless it is one."""
    name = text(field, value)
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", name):
        raise InputError(f"{field} = {name!r}: expected letters, digits, - and _, a letter first")
    if len(name) > LONGEST_NAME:
        raise InputError(
            f"{field} = '{name[:20]}...': has {len(name)} letters, expected at most {LONGEST_NAME}"
        )
    return name
