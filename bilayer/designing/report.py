"""What a design leaves beside its evaluations: the specimen, cut files, pictures and a report.

specimen.toml         the designed specimen, for `bilayer solve`
cut-specimen.toml     the same with its fields of density cut out
parts-LAYER.dxf       what has to be cut
shape.png             the shape beside the target
search.png            the distance over the evaluations
report.md             all of it in words
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from bilayer.cutting.files import CutFile, write_cut_files
from bilayer.designing.distance import Place
from bilayer.designing.evaluation import ShapeFound
from bilayer.designing.fields import cut_out, has_fields
from bilayer.designing.height_image import PIXELS, similarity
from bilayer.designing.run import DesignOutcome
from bilayer.designing.variables import UNITS, kind_of, value_of
from bilayer.geometry.nearest_point import NearestPoint
from bilayer.geometry.surface import Surface
from bilayer.measures.shape import measure_shape
from bilayer.mesh.planar import flat_surface
from bilayer.runtime.output_file import whole_file
from bilayer.specimen.toml import specimen_to_toml

SPECIMEN, REPORT, PARTS = "specimen.toml", "report.md", "parts.dxf"
CUT_SPECIMEN = "cut-specimen.toml"
SHOWN_UNITS = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "Pa": (1e-3, "kPa")}
MM = 1e3
PA_PER_MM = 1e-3
"""For N/m3."""


def write_design(outcome: DesignOutcome, folder: str | Path) -> Path:
    """Write the files of a design into its folder; return the report's.

    Raises
    ------
    NotWrittenError
        Writing failed.
    """
    place = Path(folder)
    with whole_file(place / SPECIMEN, "specimen file") as written:
        written.write_text(specimen_to_toml(outcome.specimen), encoding="utf-8")
    cut = cut_out(outcome.specimen)
    if cut is not outcome.specimen:
        with whole_file(place / CUT_SPECIMEN, "specimen file") as written:
            written.write_text(specimen_to_toml(cut), encoding="utf-8")
    least_web = max(outcome.task.widths.least_web, 1e-3)
    parts = write_cut_files(cut, place / PARTS, least_web=least_web)
    _draw(outcome, place)
    report = place / REPORT
    with whole_file(report, "report") as written:
        written.write_text(report_text(outcome, parts), encoding="utf-8")
    return report


def _draw(outcome: DesignOutcome, folder: Path) -> None:
    from bilayer.figures.design import draw_search, draw_target  # matplotlib takes half a second
    from bilayer.figures.saving import save_figure

    shape, at = _last_shape(outcome)
    target = placed(outcome.task.target.surface, at)
    away = NearestPoint(target).vectors_to(shape.corners.mean(axis=1))
    save_figure(draw_target(shape, target, np.linalg.norm(away, axis=1)), folder / "shape.png")
    nominal = [each.distances[0] if each.distances else np.nan for each in outcome.history]
    worst = [max(each.distances, default=np.nan) for each in outcome.history]
    best = [each.best for each in outcome.history]
    save_figure(draw_search(nominal, worst, best), folder / "search.png")


def placed(target: Surface, place: Place) -> Surface:
    """Return a target at a place."""
    return Surface(place.take(target.points), target.triangles)


def report_text(outcome: DesignOutcome, parts: Sequence[CutFile]) -> str:
    """Return the report, in Markdown."""
    task, by_elements = outcome.task, outcome.solves_by_elements
    specimen = outcome.specimen
    lines = [
        f"# Design of {outcome.specimen.name}",
        "",
        f"Target: {task.target.words}, diagonal {MM * task.target.diagonal:.4g} mm.",
        f"Shapes computed: {outcome.solves} by the shell"
        + (f", {by_elements} by the finite-element model." if by_elements else "."),
        "",
        *_verdict(outcome),
        "",
        "![The shape beside the target](shape.png)",
        "",
        "## The numbers",
        "",
        "| parameter | from | to | begin | design |",
        "|---|---|---|---|---|",
        *_numbers(outcome),
        "",
        *_distances(outcome),
        "",
        *_stiffness(outcome),
        _seen_from_above(outcome),
        "",
        "![The search](search.png)",
        "",
        "## To make it",
        "",
        f"Specimen: [{SPECIMEN}]({SPECIMEN})"
        + (f", cut out: [{CUT_SPECIMEN}]({CUT_SPECIMEN})." if has_fields(specimen) else "."),
        "",
        *[f"- {part.words}" for part in parts],
        *[f"- {part.part.layer}: {obstacle}" for part in parts for obstacle in part.obstacles],
    ]
    return "\n".join(lines) + "\n"


def _verdict(outcome: DesignOutcome) -> Iterable[str]:
    """Yield what is reached, by which model, and what holds the design."""
    diagonal = outcome.task.target.diagonal
    if outcome.checks:
        last = outcome.checks[-1]
        yield f"**Reached, by the finite-element model: {_away(last.distance.rms, diagonal)}.**"
        yield last.words
        yield from _lowest(outcome)
    else:
        found = outcome.from_flat.shapes[0]
        yield f"**Reached, by the shell alone: {_away(found.distance, diagonal)}.**"
        yield "The finite-element model has not checked it."
    if outcome.check_failure:
        yield f"Of the last design, {outcome.check_failure}."
    if not outcome.is_the_same_from_flat:
        along = outcome.along_the_way.shapes[0].distance
        yield (
            f"It is reachable only along the way of the search: there it is {MM * along:.3g} mm "
            "from the target. From the flat sheet "
            f"{outcome.flat_failure or 'another shape is reached'}."
        )
    held = outcome.bounds_reached
    yield f"It is held by {', '.join(held)}." if held else "No bound holds it."


def _lowest(outcome: DesignOutcome) -> Iterable[str]:
    """Yield what a search for lower states found."""
    found, diagonal = outcome.lowest, outcome.task.target.diagonal
    if found is None:
        return
    yield found.words
    if found.lowest is not None and not found.is_checked_shape:
        yield (
            "So the checked shape is reachable only along its way from flat: the lower state is "
            f"{_away(found.lowest.distance.rms, diagonal)}."
        )


def _away(distance: float, diagonal: float) -> str:
    return f"{MM * distance:.4g} mm from the target ({distance / diagonal:.2%} of the diagonal)"


def _numbers(outcome: DesignOutcome) -> Iterable[str]:
    for variable in outcome.task.variables.variables:
        factor, unit = SHOWN_UNITS.get(UNITS.get(kind_of(variable.name), ""), (1.0, ""))
        begin = value_of(outcome.task.specimen, variable.name)
        end = value_of(outcome.specimen, variable.name)
        values = " | ".join(
            f"{factor * value:.5g}" for value in (variable.low, variable.high, begin, end)
        )
        yield f"| `{variable.name}`{f' ({unit})' if unit else ''} | {values} |"


def _distances(outcome: DesignOutcome) -> Iterable[str]:
    radius = outcome.specimen.characteristic_length
    yield "| shape | rms (mm) | mean (% of diagonal) | largest (%) | quality | HD | gap (mm) |"
    yield "|---|---|---|---|---|---|---|"
    for name, found in _shapes(outcome):
        measured = measure_shape(outcome.mesh, found.position, radius)
        yield _row(
            name, found.distance, found.mean_distance, found.largest_distance,
            outcome.task.target.diagonal, measured.quality, measured.hemisphere_distance, found.gap,
        )  # fmt: skip
    for number, check in enumerate(outcome.checks, start=1):
        away = check.distance
        yield _row(
            f"finite elements, run {number}", away.rms, away.mean, away.largest,
            outcome.task.target.diagonal, check.quality, check.hemisphere_distance, check.gap,
        )  # fmt: skip


def _stiffness(outcome: DesignOutcome) -> Iterable[str]:
    """Yield how far from a loss of stability the design is, if a margin is wanted."""
    wanted = outcome.task.least_stiffness
    if not wanted:
        return
    softest = min(found.stiffness for found in outcome.from_flat.shapes)
    yield (
        f"Against its softest deformation the softest shape has {PA_PER_MM * softest:.3g} Pa/mm, "
        f"where at least {PA_PER_MM * wanted:.3g} Pa/mm were wanted."
    )
    yield ""


def _seen_from_above(outcome: DesignOutcome) -> str:
    shape, _ = _last_shape(outcome)
    found = similarity(outcome.task.target.surface, shape, flat_surface(outcome.mesh))
    return (
        f"Heights seen from above, {PIXELS} x {PIXELS} pixels: their similarity SSIM with those of "
        f"the target is {found.shape:.3f}. That of a plain cap of the target's area and height is "
        f"{found.plain_cap:.3f}, that of the flat sheet {found.flat:.3f}."
    )


def _last_shape(outcome: DesignOutcome) -> tuple[Surface, Place]:
    """Return the shape of the last check, or else of the shell, and the target's place."""
    if outcome.checks:
        last = outcome.checks[-1]
        return last.surface, last.distance.place
    found = outcome.from_flat.shapes[0]
    return Surface(found.position, outcome.mesh.triangles), found.place


def _row(
    name: str, rms: float, mean: float, largest: float, diagonal: float, quality: float,
    hemisphere: float, gap: float,
) -> str:  # fmt: skip
    gap_text = "far" if np.isinf(gap) else f"{MM * gap:.3g}"
    return (
        f"| {name} | {MM * rms:.4g} | {100 * mean / diagonal:.3g} | {100 * largest / diagonal:.3g} "
        f"| {quality:.3f} | {hemisphere:.3f} | {gap_text} |"
    )


def _shapes(outcome: DesignOutcome) -> Iterable[tuple[str, ShapeFound]]:
    scenarios = outcome.task.robustness.scenarios
    is_along = outcome.is_by_elements and outcome.flat_failure
    model = "finite elements, along the way" if is_along else "shell"
    for scenario, found in zip(scenarios, outcome.from_flat.shapes, strict=True):
        yield f"{model}, {scenario.words}", found
