"""Fields of density in a design: sharper from stage to stage, and cut out at the end."""

from collections.abc import Iterator
from dataclasses import replace

from bilayer.specimen.density_field import DensityField
from bilayer.specimen.specimen import Specimen

LEAST_PART = 5e-4
"""Area of the parts and holes that are cut out, over that of the sheet; smaller ones are not."""


def has_fields(specimen: Specimen) -> bool:
    """Whether a layer has a field of density."""
    return any(_fields(specimen))


def field_layers(specimen: Specimen) -> list[str]:
    """Return the names of the layers that have a field of density."""
    return [name for name, _ in _fields(specimen)]


def with_sharpness(specimen: Specimen, sharpness: float) -> Specimen:
    """Return a specimen whose fields of density are so sharp."""
    for name, field in _fields(specimen):
        specimen = specimen.with_layer(name, pattern=replace(field, sharpness=sharpness))
    return specimen


def cut_out(specimen: Specimen) -> Specimen:
    """Return a specimen with the patterns that its fields of density become; else itself.

    Raises
    ------
    InputError
        A field keeps all of the sheet, or nothing.
    """
    outline = specimen.outline
    least = LEAST_PART * outline.area
    for name, field in _fields(specimen):
        specimen = specimen.with_layer(name, pattern=field.cut_pattern(outline, least_area=least))
    return specimen


def _fields(specimen: Specimen) -> Iterator[tuple[str, DensityField]]:
    for layer in specimen.layers:
        if isinstance(layer.pattern, DensityField):
            yield layer.name, layer.pattern
