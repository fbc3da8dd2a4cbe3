"""Specimens that are valid and hardly meant: what a user would want to be asked about."""

from bilayer.specimen.specimen import Specimen

STRONG_COMPRESSION = 0.5
"""Stretch below which a layer that is bonded so is no sheet that anybody has bonded."""


def doubts(specimen: Specimen) -> list[str]:
    """Return a line for each property of a specimen that is hardly meant.

    Too thick a sheet is among the errors of `bilayer.specimen.toml.read_specimen`, and among the
    caveats of a result.
    """
    return [*_nothing_stretched(specimen), *_strongly_compressed(specimen)]


def _nothing_stretched(specimen: Specimen) -> list[str]:
    if specimen.gravity or specimen.loads or any(layer.is_stretched for layer in specimen.layers):
        return []
    return [
        "no layer has a response to the prestretch, so the sheet stays flat: expected "
        "response = 'path' in one of [[layers]], or a layer's name in prestretch.layers"
    ]


def _strongly_compressed(specimen: Specimen) -> list[str]:
    stretches = {
        stretch
        for milestone in specimen.prestretch.milestones
        for layer in specimen.layers
        if layer.is_stretched
        for stretch in layer.response.axial(milestone)
        if stretch < STRONG_COMPRESSION
    }
    if not stretches:
        return []
    listed = ", ".join(f"{stretch:g}" for stretch in sorted(stretches)[:3])
    return [
        f"prestretch {listed}: a layer is compressed to less than half its length before it is "
        "bonded; its wrinkles are not modelled, and few laws are measured so far"
    ]
