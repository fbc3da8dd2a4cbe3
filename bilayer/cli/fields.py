"""The fields that a verb draws or writes: those of the file, or computed for it."""

from collections.abc import Sequence
from typing import Any

import xarray as xr

from bilayer.cli.parser import Parser, add_trust_argument
from bilayer.errors import InputError
from bilayer.mechanics.dataset import LAYER_FIELDS, SHAPE_FIELDS
from bilayer.mechanics.selection import FIELD_NAMES, ScalarField, needs_layers, scalar_field
from bilayer.runtime.terminal import tell
from bilayer.solvers.fields import fields, has_layer_fields

EXAMPLE = "cauchy_stress.substrate.top.xx"


def add_field_argument(verb: Parser, most: str) -> None:
    """Add the option that names fields; `most` says how many."""
    verb.add_argument(
        "--field", action="append", metavar="NAME", default=[],
        help=f"{most}, such as {EXAMPLE} or mean_curvature (docs/fields.md)",
    )  # fmt: skip
    add_trust_argument(verb)


def result_fields(result: xr.Dataset, options: Any, *, layers: bool = True) -> xr.Dataset:
    """Return the fields of a result: those that its file holds, or computed now.

    Parameters
    ----------
    result : Dataset
        From `open_result`.
    options : Namespace
        Of the verb, with `trust` and `quiet`.
    layers : bool
        Whether those of the layers are wanted.
    """
    held = [name for name in FIELD_NAMES if name in result]
    if not set(SHAPE_FIELDS) - set(held) and not (layers and set(LAYER_FIELDS) - set(held)):
        return result[held]
    if layers and not has_layer_fields(result):
        made_by = f"{result.attrs['solver']} {result.attrs['model']}"
        if not options.quiet:
            tell(f"bilayer: results of {made_by} have no strains and stresses, only shapes")
    elif layers and not options.quiet:
        tell("bilayer: finding the equilibria again, for their strains and stresses")
    return fields(result, layers=layers, trust=options.trust)


def scalar_fields(result: xr.Dataset, names: Sequence[str], options: Any) -> list[ScalarField]:
    """Return the fields of a result that were asked for by name."""
    if not names:
        return []
    layers = max(map(needs_layers, names))  # each name is checked
    if layers and not has_layer_fields(result) and not set(LAYER_FIELDS) <= set(result):
        made_by = f"{result.attrs['solver']} {result.attrs['model']}"
        raise InputError(
            f"--field {names[0]}: results of {made_by} have no strains and stresses, "
            f"expected one of {', '.join(SHAPE_FIELDS)}"
        )
    found = result_fields(result, options, layers=layers)
    return [scalar_field(found, name) for name in names]
