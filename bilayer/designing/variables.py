"""The numbers of a specimen that a design may change, by name, with their bounds.

Beside those of `bilayer.solvers.parameters` these are numbers of outline and pattern, which move
the planar mesh:

- `outline.FIELD`, such as `outline.width`
- `LAYER.pattern.FIELD`, such as `kirigami.pattern.cutout_angle`
- `LAYER.pattern.FIELD.K`, of a list: `kirigami.pattern.half_angles.0`
- `LAYER.pattern.inner_radius`, also of a profile: its other radii keep their shares of the way to
  the last one

A design is a specimen with one milestone, the prestretch at which it shall have its shape.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.solvers.parameters import changed, parameter_value
from bilayer.specimen.pattern import SectorProfile
from bilayer.specimen.specimen import Specimen
from bilayer.validation import finite

Array = NDArray[np.float64]

UNITS = {
    "thickness": "m", "inner_radius": "m", "width": "m", "height": "m", "half_angles": "rad",
    "cutout_angle": "rad", "modulus": "Pa", "outer_radius": "m", "radius": "m",
}  # fmt: skip
"""The SI unit of a number by its kind, the last word of its name."""


@dataclass(frozen=True)
class Variable:
    """A number that is free between bounds.

    Parameters
    ----------
    name : str
        See the module.
    low, high : float
        Bounds, SI units.
    """

    name: str
    low: float
    high: float

    def __post_init__(self) -> None:
        low, high = finite(f"{self.name}: from", self.low), finite(f"{self.name}: to", self.high)
        if not low < high:
            raise InputError(f"{self.name}: from = {low:g}, expected less than to = {high:g}")

    @property
    def is_of_the_sheet(self) -> bool:
        """Whether it changes the flat sheet, and with it the planar mesh."""
        return is_of_the_sheet(self.name)


def kind_of(name: str) -> str:
    """Return the last word of a name that is no number."""
    return next((part for part in name.split(".")[::-1] if not part.isdigit()), "")


def is_of_the_sheet(name: str) -> bool:
    """Whether a number of this name changes the flat sheet."""
    parts = name.split(".")
    return parts[0] == "outline" or parts[1:2] == ["pattern"]


@dataclass(frozen=True)
class Variables:
    """The variables of a design, each scaled to go from 0 to 1 between its bounds.

    Parameters
    ----------
    variables : sequence of Variable
        With different names.
    """

    variables: tuple[Variable, ...]

    def __post_init__(self) -> None:
        names = [variable.name for variable in self.variables]
        twice = [name for name in names if names.count(name) > 1]
        if twice or not names:
            what = f"{twice[0]!r} is there twice" if twice else "there are none"
            raise InputError(f"free: {what}, expected one or more parameters, each once")

    @property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(variable.name for variable in self.variables)

    @property
    def ranges(self) -> Array:
        """Distance of the bounds of each, SI units."""
        return np.array([variable.high - variable.low for variable in self.variables])

    def values(self, shares: Array) -> Array:
        """Return the values of scaled variables, SI units."""
        return np.array([v.low for v in self.variables]) + shares * self.ranges

    def shares_of(self, specimen: Specimen) -> Array:
        """Return the scaled variables that a specimen has."""
        values = np.array([value_of(specimen, name) for name in self.names])
        return (values - [v.low for v in self.variables]) / self.ranges

    def specimen(self, base: Specimen, shares: Array) -> Specimen:
        """Return a specimen with these scaled variables."""
        return with_values(base, dict(zip(self.names, self.values(shares), strict=True)))


def value_of(specimen: Specimen, name: str) -> float:
    """Return a number of a specimen by its name, SI units; InputError if it has none such."""
    match name.split("."):
        case ["outline", field]:
            return float(_number(specimen.outline, field, name))
        case [layer, "pattern", "inner_radius"] if _is_profile(specimen, layer):
            return float(_pattern(specimen, layer, name).radii[0])
        case [layer, "pattern", field]:
            return float(_number(_pattern(specimen, layer, name), field, name))
        case [layer, "pattern", field, place]:
            values = getattr(_pattern(specimen, layer, name), field, None)
            if isinstance(values, tuple) and place.isdigit() and int(place) < len(values):
                return float(values[int(place)])
            raise InputError(f"parameter = {name!r}: the pattern has no such number")
    return parameter_value(specimen, _stretch(specimen), name)


def with_values(specimen: Specimen, values: Mapping[str, float]) -> Specimen:
    """Return a specimen with other numbers."""
    of_sheet = {name: float(v) for name, v in values.items() if is_of_the_sheet(name)}
    if of_sheet:
        specimen = _with_sheet(specimen, of_sheet)
    stretch = _stretch(specimen)
    for name in [name for name in values if name not in of_sheet]:
        change = float(values[name]) - parameter_value(specimen, stretch, name)
        specimen, stretch = changed(specimen, stretch, name, change)
    return specimen.with_milestones([stretch])


def _with_sheet(specimen: Specimen, values: Mapping[str, float]) -> Specimen:
    """Return a specimen with other numbers of its outline and its patterns, made once."""
    outline: Any = specimen.outline
    of_outline = {n.split(".")[1]: v for n, v in values.items() if n.startswith("outline.")}
    changes: dict[Any, dict[str, Any]] = {}
    for name in values:
        if not name.startswith("outline."):
            layer, _, *place = name.split(".")
            pattern = _pattern(specimen, layer, name)
            _change(pattern, place, values[name], changes.setdefault(pattern, {}))
    patterns = {before: replace(before, **change) for before, change in changes.items()}
    layers = [
        replace(layer, pattern=patterns.get(layer.pattern, layer.pattern))
        for layer in specimen.layers
    ]
    return replace(specimen, outline=replace(outline, **of_outline), layers=tuple(layers))


def _change(pattern: Any, place: Sequence[str], value: float, changes: dict[str, Any]) -> None:
    """Add the change of one number of a pattern to the changed fields."""
    match place:
        case ["inner_radius"] if isinstance(pattern, SectorProfile):
            changes["radii"] = _stretched(pattern.radii, value)
        case [field]:
            changes[field] = value
        case [field, number]:
            values = list(changes.get(field, getattr(pattern, field)))
            values[int(number)] = value
            changes[field] = tuple(values)


def _stretched(radii: Sequence[float], first: float) -> tuple[float, ...]:
    """Return radii that begin at another one, at the same shares of the way to the last."""
    last = radii[-1]
    share = (last - first) / (last - radii[0])
    return (*(last - share * (last - radius) for radius in radii[:-1]), last)


def _stretch(specimen: Specimen) -> tuple[float, float]:
    return specimen.prestretch.milestones[-1]


def _is_profile(specimen: Specimen, layer: str) -> bool:
    return layer in specimen.layer_names and isinstance(
        specimen.layer(layer).pattern, SectorProfile
    )


def _pattern(specimen: Specimen, layer: str, name: str) -> Any:
    pattern = specimen.layer(layer).pattern
    if pattern is None:
        raise InputError(f"parameter = {name!r}: the layer {layer!r} is whole")
    return pattern


def _number(holder: Any, field: str, name: str) -> float:
    numbers = [f.name for f in fields(holder) if isinstance(getattr(holder, f.name), float)]
    if field not in numbers:
        raise InputError(f"parameter = {name!r}: expected one of {', '.join(numbers)}")
    return float(getattr(holder, field))
