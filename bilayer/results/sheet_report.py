"""A sheet as text before it is solved: what lies where, and what is to be known of it."""

from collections.abc import Sequence

from bilayer.mesh.generation import estimated_triangles
from bilayer.results.caveats import THICKEST_SHELL, is_thick, thickness_share
from bilayer.results.table import stretch_text
from bilayer.runtime.terminal import one_line
from bilayer.specimen.doubts import doubts
from bilayer.specimen.layer import BondedLayer, Response
from bilayer.specimen.materials import stability_warning
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen


def sheet_report(specimen: Specimen) -> str:
    """Return what a sheet is, its path, and what is doubtful of it, as text."""
    milestones = specimen.prestretch.milestones
    warnings = [
        *(f"Doubtful: {doubt}." for doubt in doubts(specimen)),
        *warnings_of_thickness(specimen),
        *warnings_of_laws(specimen, milestones),
    ]
    lines = [
        *sheet_lines(specimen),
        *_shares(specimen),
        f"size        characteristic length {1e3 * specimen.characteristic_length:.4g} mm, "
        f"thickness {thickness_share(specimen):.2%} of it",
        f"prestretch  {', '.join(map(stretch_text, milestones))}",
        *_weight(specimen),
        f"mesh        size {1e3 * specimen.mesh.size:g} mm, about "
        f"{estimated_triangles(specimen):.0f} triangles",
    ]
    shown = [one_line(line) for line in lines]  # a name in the file makes no further lines
    return "\n".join([*shown, "", " ".join(warnings) or "Nothing in it is doubtful."])


def sheet_lines(specimen: Specimen) -> list[str]:
    """Return lines on the outline, the patterns and layers, and what acts on the sheet."""
    return [
        f"specimen    {specimen.name}: {specimen.outline.words}, {_cuts(specimen)}",
        *_layers(specimen),
        *(f"held        {support.words}" for support in specimen.supports),
        *(f"load        {load.words}" for load in specimen.loads),
        *(f"obstacle    {obstacle.words}" for obstacle in specimen.obstacles),
    ]


def warnings_of_laws(specimen: Specimen, milestones: Sequence[StretchPair]) -> list[str]:
    """Return a sentence for each layer that a milestone stretches beyond its law's stability."""
    bonded = [specimen.bonded_layers(pair) for pair in milestones]
    warnings = [
        stability_warning(
            parts[0].name, parts[0].layer.material, [part.principal_stretches for part in parts]
        )
        for parts in zip(*bonded, strict=True)
    ]
    return list(filter(None, warnings))


def warnings_of_thickness(specimen: Specimen) -> list[str]:
    """Return a sentence if a sheet is too thick for a shell."""
    if not is_thick(specimen):
        return []
    return [
        f"The sheet is TOO THICK FOR A SHELL: its whole thickness is "
        f"{thickness_share(specimen):.1%} of the radius of the circle of its area; above "
        f"{THICKEST_SHELL:.0%} the finite-element model can take another shape, so use that."
    ]


def _shares(specimen: Specimen) -> list[str]:
    """Return a line for each layer with a pattern: how much of the sheet it lies on."""
    shares = {
        layer.name: specimen.region_of(layer.name).area / specimen.sheet.area
        for layer in specimen.layers
        if not layer.is_whole
    }
    return [f"{name + ' ':<12}lies on {share:.1%} of the area" for name, share in shares.items()]


def _weight(specimen: Specimen) -> list[str]:
    return [f"weight      {specimen.gravity:g} m/s2"] if specimen.gravity else []


def _cuts(specimen: Specimen) -> str:
    """Say which patterns there are, each with its layers if there is more than one."""
    layers: dict[str, list[str]] = {}
    for layer in specimen.layers:
        if layer.pattern is not None:
            layers.setdefault(layer.pattern.words, []).append(layer.name)
    if len(layers) < 2:
        return next(iter(layers), "uncut")
    return "; ".join(f"{' and '.join(names)}: {words}" for words, names in layers.items())


def _layers(specimen: Specimen) -> list[str]:
    """Return a line for each layer, from the bottom up."""
    lines = []
    for part in specimen.bonded_layers((1.0, 1.0)):
        material = part.layer.material
        line = (
            f"{part.name + ' ':<12}{1e3 * part.layer.thickness:g} mm, {material.name}, "
            f"E = {material.young_modulus:.6g} Pa, nu = {material.poisson_ratio:.4g}"
        )
        if part.layer.is_stretched:
            line += f", stretched{_response(part.layer.response)}"
            line += f", bonded thickness {specimen.prestretch.thickness}"
        lines.append(f"{line}, {_place(part)}")
    return lines


def _place(part: BondedLayer) -> str:
    """Say where a layer lies, seen from the reference surface."""
    if part.is_above:
        return "above"
    return "below" if part.top <= 0 else "in the middle"


def _response(response: Response) -> str:
    """Say how a layer is stretched if it is not as the path has it."""
    words = "" if response.kind == "path" else " by {:g} and {:g}".format(*response.stretch)
    if response.factor != 1:
        words += f" {response.factor:g} times as much"
    return words + (f" at {response.angle:g} rad" if response.angle else "")
