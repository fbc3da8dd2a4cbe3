"""The parameters of a specimen by name, for derivatives: how each is changed a little.

- `prestretch`: both stretches together; `prestretch.x`, `prestretch.y`: one of them
- `gravity`: the acceleration of the true weight, m/s2
- `LAYER.thickness`: the natural thickness of a layer, m
- `LAYER.density`: kg/m3
- `LAYER.material.CONSTANT`: a constant of its law, such as `substrate.material.C10`, Pa

`central_difference` differentiates whatever is a smooth function of specimen and prestretch. Such
a function is computed without iteration, so its noise is round-off alone.
"""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

RELATIVE_CHANGE = 1e-5
"""Of a parameter: the difference errs by its square and by round-off over it, about 1e-10."""


def central_difference(
    value: Callable[[Specimen, StretchPair], NDArray[np.float64]],
    specimen: Specimen,
    stretch: StretchPair,
    parameter: str,
) -> NDArray[np.float64]:
    """Return the derivative of a function by a parameter.

    Parameters
    ----------
    value : callable
        Takes a specimen and its prestretch.
    specimen, stretch
        Where it is differentiated.
    parameter : str
        See the module.

    Raises
    ------
    InputError
        The specimen has no such parameter.
    """
    change = RELATIVE_CHANGE * parameter_scale(specimen, stretch, parameter)
    above, below = (
        value(*changed(specimen, stretch, parameter, sign * change)) for sign in (1.0, -1.0)
    )
    return np.asarray((above - below) / (2 * change))


def parameter_scale(specimen: Specimen, stretch: StretchPair, parameter: str) -> float:
    """Return the size that a change of a parameter is measured by: its value, 1 if that is 0."""
    value = parameter_value(specimen, stretch, parameter)
    return abs(value) if value else 1.0


def parameter_value(specimen: Specimen, stretch: StretchPair, parameter: str) -> float:
    """Return a parameter; that of `prestretch` is the larger stretch."""
    match parameter.split("."):
        case ["prestretch"]:
            return max(stretch)
        case ["prestretch", ("x" | "y") as axis]:
            return stretch["xy".index(axis)]
        case ["gravity"]:
            return specimen.gravity
        case [layer, ("thickness" | "density") as name] if layer in specimen.layer_names:
            return float(getattr(specimen.layer(layer), name))
        case [layer, "material", name] if layer in specimen.layer_names:
            material = specimen.layer(layer).material
            constant = _constant(material, name)
            if constant is not None:
                return float(getattr(material, constant))
    raise InputError(
        f"parameter = {parameter!r}: expected prestretch, prestretch.x, prestretch.y, gravity, or "
        "LAYER.thickness, LAYER.density or LAYER.material.CONSTANT with a layer of "
        f"{list(specimen.layer_names)}"
    )


def changed(
    specimen: Specimen, stretch: StretchPair, parameter: str, change: float
) -> tuple[Specimen, StretchPair]:
    """Return a specimen and its prestretch with a parameter changed by so much."""
    value = parameter_value(specimen, stretch, parameter) + change
    match parameter.split("."):
        case ["prestretch"]:
            return specimen, (stretch[0] + change, stretch[1] + change)
        case ["prestretch", axis]:
            return specimen, (value, stretch[1]) if axis == "x" else (stretch[0], value)
        case ["gravity"]:
            return replace(specimen, gravity=value), stretch
        case [layer, "material", name]:
            material: Any = specimen.layer(layer).material
            material = replace(material, **{str(_constant(material, name)): value})
            return specimen.with_layer(layer, material=material), stretch
        case [layer, name]:
            return specimen.with_layer(layer, **{name: value}), stretch
    raise AssertionError(parameter)


def _constant(material: Any, name: str) -> str | None:
    """Return the field of a law's constant, in whatever case its name is; None: there is none.

    Constants that are lists of numbers, as those of Ogden's law, are not among them.
    """
    names = {
        field.name.casefold(): field.name
        for field in fields(material)
        if field.init and isinstance(getattr(material, field.name), (int, float))
    }
    return names.get(name.casefold())
