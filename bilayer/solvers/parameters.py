"""The parameters of a specimen by name, for derivatives: how each is changed a little.

- `prestretch`: both stretches together; `prestretch.x`, `prestretch.y`: one of them
- `gravity`: the acceleration of the true weight, m/s2
- `LAYER.thickness`: the natural thickness of a layer, m
- `LAYER.density`: kg/m3
- `LAYER.modulus`: the shear modulus of its law, Pa; all constants of the law go with it
- `LAYER.share.K`: the share at a node of the layer's field of density
- `LAYER.material.CONSTANT`: a constant of its law, such as `substrate.material.C10`, Pa

`difference_by` differentiates whatever is a smooth function of specimen and prestretch. Such
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

CENTRAL = {1.0: 0.5, -1.0: -0.5}
FORWARD = {0.0: -1.5, 1.0: 2.0, 2.0: -0.5}
"""Weights of the values after so many steps, over the step, in a first derivative."""
RELATIVE_CHANGE = 1e-5
"""Of a parameter: the difference errs by its square and by round-off over it, about 1e-10."""


def difference_by(
    value: Callable[[Specimen, StretchPair], NDArray[np.float64]],
    specimen: Specimen,
    stretch: StretchPair,
    parameter: str,
) -> NDArray[np.float64]:
    """Return the derivative of a function by a parameter, by differences of the second order.

    They are central, but for a parameter that is 0: it may have to stay positive, as gravity and
    a compressibility have to, so that these are forward differences.

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
    is_zero = parameter_value(specimen, stretch, parameter) == 0
    weights = FORWARD if is_zero else CENTRAL
    values = [
        weight * value(*changed(specimen, stretch, parameter, steps * change))
        for steps, weight in weights.items()
    ]
    return np.asarray(sum(values) / change)


def parameter_scale(specimen: Specimen, stretch: StretchPair, parameter: str) -> float:
    """Return the size that a change of a parameter is measured by: its value unless it is 0.

    Then it is 1 in the parameter's unit, or what the layer's shear modulus makes of Pa and 1/Pa.
    """
    value = parameter_value(specimen, stretch, parameter)
    match parameter.split("."):
        case [_, "share", _]:
            return 1.0
        case [layer, "material", name]:
            material = specimen.layer(layer).material
            modulus = material.shear_modulus
            scales = {"Pa": modulus, "1/Pa": 1 / modulus}
            return abs(value) or scales.get(material.units.get(name, ""), 1.0)
    return abs(value) or 1.0


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
        case [layer, "share", place] if layer in specimen.layer_names:
            shares = getattr(specimen.layer(layer).pattern, "share", ())
            if place.isdigit() and int(place) < len(shares):
                return float(shares[int(place)])
        case [layer, "modulus"] if layer in specimen.layer_names:
            return float(specimen.layer(layer).material.shear_modulus)
        case [layer, "material", name] if layer in specimen.layer_names:
            material = specimen.layer(layer).material
            constant = _constant(material, name)
            if constant is not None:
                return float(getattr(material, constant))
    raise InputError(
        f"parameter = {parameter!r}: expected prestretch, prestretch.x, prestretch.y, gravity, or "
        "LAYER.thickness, LAYER.density, LAYER.modulus, LAYER.share.K or LAYER.material.CONSTANT "
        "with a layer of "
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
        case [layer, "share", place]:
            pattern: Any = specimen.layer(layer).pattern
            shares = list(pattern.share)
            shares[int(place)] = value
            return specimen.with_layer(layer, pattern=replace(pattern, share=shares)), stretch
        case [layer, "modulus"]:
            material = specimen.layer(layer).material
            stiffer = _stiffened(material, value / material.shear_modulus)
            return specimen.with_layer(layer, material=stiffer), stretch
        case [layer, name]:
            return specimen.with_layer(layer, **{name: value}), stretch
    raise AssertionError(parameter)


def _stiffened(material: Any, factor: float) -> Any:
    """Return a law with all of its stresses multiplied by a factor."""
    powers = {"Pa": factor, "1/Pa": 1 / factor}
    changes = {}
    for field in fields(material):
        value, power = getattr(material, field.name), powers.get(material.units.get(field.name, ""))
        if field.init and power is not None:
            many = isinstance(value, (tuple, list))
            changes[field.name] = tuple(power * part for part in value) if many else power * value
    return replace(material, **changes)


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
