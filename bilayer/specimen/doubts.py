"""Specimens that are valid and hardly meant: what a user would want to be asked about."""

from bilayer.specimen.specimen import Specimen

STRONG_COMPRESSION = 0.5
"""Stretch below which a layer that is bonded so is no sheet that anybody has bonded."""
STRONG_STRETCH = 2.0
"""Stretch above which few laws of soft materials are measured, and few sheets are bonded."""
THICK = 0.25
"""Thickness of a layer over the radius of the sheet's area from which on it is a block."""
SOFTEST, STIFFEST = 1e3, 1e12
"""Young's moduli of soft gels and of diamond, Pa: a modulus beyond has a forgotten unit."""
LIGHTEST, HEAVIEST = 5.0, 25e3
"""Densities of light foams and of the densest metals, kg/m3."""


def doubts(specimen: Specimen) -> list[str]:
    """Return a line for each property of a specimen that is hardly meant.

    Too thick a sheet is among the errors of `bilayer.specimen.toml.read_specimen`, and among the
    caveats of a result.
    """
    return [
        *_nothing_stretched(specimen),
        *_strongly_compressed(specimen),
        *_strongly_stretched(specimen),
        *_thick(specimen),
        *_odd_materials(specimen),
        *_nothing_relaxes(specimen),
    ]


def _nothing_stretched(specimen: Specimen) -> list[str]:
    if specimen.gravity or specimen.loads or any(layer.is_stretched for layer in specimen.layers):
        return []
    return [
        "no layer has a response to the prestretch, so the sheet stays flat: expected "
        "response = 'path' in one of [[layers]], or a layer's name in prestretch.layers"
    ]


def _stretches(specimen: Specimen) -> set[float]:
    """Return all stretches at which a layer is bonded."""
    return {
        stretch
        for milestone in specimen.prestretch.milestones
        for layer in specimen.layers
        if layer.is_stretched
        for stretch in layer.response.axial(milestone)
    }


def _strongly_stretched(specimen: Specimen) -> list[str]:
    stretches = {stretch for stretch in _stretches(specimen) if stretch > STRONG_STRETCH}
    if not stretches:
        return []
    listed = ", ".join(f"{stretch:g}" for stretch in sorted(stretches)[-3:])
    return [
        f"prestretch {listed}: a layer is bonded at more than {STRONG_STRETCH:g} times its length, "
        "where few laws are measured; 1.06 is a stretch by 6 %"
    ]


def _thick(specimen: Specimen) -> list[str]:
    radius = specimen.characteristic_length
    return [
        f"{layer.name}.thickness = {1e3 * layer.thickness:g} mm: the sheet has a radius of "
        f"{1e3 * radius:.4g} mm, so this layer is a block; a bare number is in metres"
        for layer in specimen.layers
        if layer.thickness > THICK * radius
    ]


def _odd_materials(specimen: Specimen) -> list[str]:
    """Return a line for each modulus and density of no known material: mostly a forgotten unit."""
    lines = []
    for layer in specimen.layers:
        modulus = layer.material.young_modulus
        if not SOFTEST <= modulus <= STIFFEST:
            lines.append(
                f"{layer.name}: Young's modulus of {modulus:.4g} Pa, no sheet is as "
                f"{'soft' if modulus < SOFTEST else 'stiff'}; a bare number is in Pa"
            )
        if not LIGHTEST <= layer.density <= HEAVIEST:
            lines.append(
                f"{layer.name}.density = {layer.density:g} kg/m3: no sheet is as "
                f"{'light' if layer.density < LIGHTEST else 'heavy'}; a bare number is in kg/m3"
            )
    return lines


def _strongly_compressed(specimen: Specimen) -> list[str]:
    stretches = {stretch for stretch in _stretches(specimen) if stretch < STRONG_COMPRESSION}
    if not stretches:
        return []
    listed = ", ".join(f"{stretch:g}" for stretch in sorted(stretches)[:3])
    return [
        f"prestretch {listed}: a layer is compressed to less than half its length before it is "
        "bonded; its wrinkles are not modelled, and few laws are measured so far"
    ]


def _nothing_relaxes(specimen: Specimen) -> list[str]:
    if specimen.schedule is None or any(layer.relaxation.terms for layer in specimen.layers):
        return []
    return [
        "[time]: no material relaxes, so all times have the same shape: expected "
        "relaxation = [[share, time], ...] in one of [materials.NAME]"
    ]
