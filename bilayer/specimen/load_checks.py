"""Loads that no sheet of this kind can be meant to bear, and places where there is no sheet."""

from collections.abc import Iterator, Sequence

import shapely

from bilayer.errors import InputError
from bilayer.specimen.layer import Layer
from bilayer.specimen.load import Load
from bilayer.specimen.outline import Outline
from bilayer.specimen.part import Part
from bilayer.specimen.supported import Support

MOST_FORCE = 100.0
"""Force over that which would stretch the sheet to twice its length: beyond, a unit is wrong."""
MOST_WAY = 10.0
"""An imposed displacement in characteristic lengths."""
ON_EDGE = 1e-4
"""Distance over the characteristic length up to which a place is on the edge of the sheet."""


def check_loads(loads: Sequence[Load], layers: Sequence[Layer], length: float) -> None:
    """Raise InputError if a load is far too large for a sheet of a characteristic length, m.

    A unit that was forgotten is a factor of 1e3 or more. The solvers would take minutes to find
    that there is no equilibrium.
    """
    for load in loads:
        most = MOST_WAY if load.kind == "displacement" else MOST_FORCE
        unit_load = _unit_load(load, layers, length)
        if load.largest > most * unit_load:
            raise InputError(
                f"loads.{load.name}.{load.kind} = {load.largest:g} {load.unit}: expected at most "
                f"{most * unit_load:.3g} {load.unit} on a sheet of this size and stiffness; a "
                f"bare number is in {load.unit}"
            )


def _unit_load(load: Load, layers: Sequence[Layer], length: float) -> float:
    """Return the load that would stretch a sheet to about twice its length, in the load's unit."""
    thickness = sum(layer.thickness for layer in layers)
    tension = sum(layer.thickness * layer.material.young_modulus for layer in layers)
    return {
        "pressure": tension / length,
        "force": tension * length,
        "line_force": tension,
        "body_force": tension / (length * thickness),
        "displacement": length,
    }[load.kind]


def check_places(supports: Sequence[Support], loads: Sequence[Load], outline: Outline) -> None:
    """Raise InputError if a point lies outside of the sheet, or a line ends within it."""
    near = ON_EDGE * outline.characteristic_length
    sheet = outline.polygon
    for field, part in _parts(supports, loads):
        if part.point is not None and sheet.distance(shapely.Point(part.point)) > near:
            raise InputError(f"{field} = {part}: lies outside of the sheet, expected a point of it")
        for x, y in _ends(part.line):
            inside = sheet.contains(shapely.Point(x, y))
            if inside and sheet.boundary.distance(shapely.Point(x, y)) > near:
                raise InputError(
                    f"{field} = a line: ends within the sheet at ({1e3 * x:g}, {1e3 * y:g}) mm, "
                    "expected one from edge to edge of the sheet, or a closed one"
                )


def _parts(supports: Sequence[Support], loads: Sequence[Load]) -> Iterator[tuple[str, Part]]:
    """Yield the parts that are held or loaded, each with its place in a file."""
    for support in supports:
        yield f"supports.{support.name}.where", support.part
    for load in loads:
        yield f"loads.{load.name}.where", load.part


def _ends(line: Sequence[tuple[float, float]]) -> Sequence[tuple[float, float]]:
    """Return the ends of a line; a closed one has none."""
    return () if not line or line[0] == line[-1] else (line[0], line[-1])
