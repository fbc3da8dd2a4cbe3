"""The short form of a specimen file: `[cut] [substrate] [kirigami]`, the disc of two layers."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bilayer.errors import InputError, fields_of
from bilayer.specimen.layer import Layer
from bilayer.specimen.materials import law_from_table, law_keys, law_to_table
from bilayer.specimen.outline import Disc
from bilayer.specimen.pattern import CutPattern
from bilayer.specimen.specimen import KIRIGAMI_LAYER, SUBSTRATE, Specimen
from bilayer.specimen.tables import (
    COMMON,
    Tables,
    check_keys,
    common_fields,
    last_tables,
    milestones_in_file,
    required,
)
from bilayer.specimen.two_layers import LAYERS, TwoLayers, disc_bilayer
from bilayer.specimen.units import UNITS, in_si

CUT = ("strips", "inner_radius", "cutout_angle")
_OWN = ("thickness", "density")
"""Keys of a layer besides those of its law."""


def short_tables() -> dict[str, tuple[str, ...]]:
    """Return the tables of this form, each with its keys."""
    layer = ("thickness", *law_keys(), "density")
    return {
        "specimen": COMMON["specimen"],
        "cut": CUT,
        SUBSTRATE: layer,
        KIRIGAMI_LAYER: (*layer, "side"),
        "prestretch": ("milestones", "layers", "thickness"),
        **{table: COMMON[table] for table in ("gravity", "mesh", "supports", "loads", "obstacles")},
    }


def bilayer_from_tables(data: Tables) -> Specimen:
    """Return the disc of two layers that the tables of a file describe.

    Raises
    ------
    InputError
        A key is unknown or missing, or a value is out of its range.
    """
    known = short_tables()
    if "outline" in data.get("specimen", {}):
        raise InputError(
            "specimen.outline: expected together with [[layers]], of which there are none"
        )
    for table, content in data.items():
        if known[table]:
            check_keys(table, content, known[table])
    sheet = in_si("specimen", data.get("specimen", {}))
    radius = required("specimen", sheet, "outer_radius")
    with fields_of("specimen"):
        disc = Disc(radius)
    kirigami = dict(data.get(KIRIGAMI_LAYER, {}))
    side = kirigami.pop("side", "above")
    common = common_fields(data)
    held = {key: common.pop(key) for key in ("supports", "loads", "obstacles")}
    sheet_alone = disc_bilayer(
        outer_radius=disc.radius,
        cut=_cut(data["cut"], disc) if "cut" in data else None,
        substrate=_layer(SUBSTRATE, data.get(SUBSTRATE, {})),
        kirigami=_layer(KIRIGAMI_LAYER, kirigami),
        stretched=data.get("prestretch", {}).get("layers", [SUBSTRATE]),
        kirigami_side=side,
        **common,
    )
    return replace(sheet_alone, **held)


def bilayer_of(specimen: Specimen) -> TwoLayers | None:
    """Return the two layers of a specimen that this form can express, None of any other."""
    try:
        bilayer = TwoLayers.of(specimen, "the short form")
    except InputError:
        return None
    expressible = (
        isinstance(specimen.outline, Disc)
        and isinstance(bilayer.kirigami.pattern, CutPattern | None)
        and bilayer.follow_the_path
        and len(bilayer.stretched) > 0
        and not any(layer.relaxation.terms for layer in specimen.layers)
        and specimen.schedule is None
    )
    return bilayer if expressible else None


def bilayer_to_tables(specimen: Specimen, bilayer: TwoLayers) -> dict[str, Any]:
    """Return the tables that read back as the same disc of two layers."""
    cut = bilayer.kirigami.pattern
    kirigami = _layer_table(bilayer.kirigami) | {"side": bilayer.kirigami_side}
    return {
        "specimen": {"name": specimen.name, "outer_radius": specimen.characteristic_length},
        **({} if cut is None else {"cut": {key: getattr(cut, key) for key in CUT}}),
        SUBSTRATE: _layer_table(bilayer.substrate),
        KIRIGAMI_LAYER: kirigami,
        "prestretch": {
            "milestones": milestones_in_file(specimen),
            "layers": [name for name in LAYERS if name in bilayer.stretched],
            "thickness": specimen.prestretch.thickness,
        },
        **last_tables(specimen),
    }


def _cut(content: Mapping[str, Any], disc: Disc) -> CutPattern:
    given = {key: required("cut", content, key) for key in CUT}
    if given["strips"] == 0:
        raise InputError("cut.strips = 0: leave the [cut] table out for an uncut disc")
    quantities = in_si("cut", given)
    with fields_of("cut"):
        cut = CutPattern(**quantities)
        cut.check_fit(disc)
    return cut


def _layer(table: str, content: Mapping[str, Any]) -> Layer:
    quantities = in_si(table, content, UNITS | law_keys())
    thickness = required(table, quantities, "thickness")
    law = law_from_table({k: v for k, v in quantities.items() if k not in _OWN}, table)
    with fields_of(table):
        return Layer(table, thickness, law, quantities.get("density", 960.0))


def _layer_table(layer: Layer) -> dict[str, Any]:
    law = law_to_table(layer.material)
    return {"thickness": layer.thickness, **law, "density": layer.density}
