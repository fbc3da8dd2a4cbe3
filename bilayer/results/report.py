"""Results as text: the table of one run, and its provenance."""

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.contact.package import HOW_TO_INSTALL, PACKAGE
from bilayer.mesh.agreement import layers_defined_by
from bilayer.results.caveats import (
    SHARPEST_TURN,
    is_coarse,
    rms_turns,
)
from bilayer.results.effort import effort_lines
from bilayer.results.load_variables import LOAD, RESPONSE
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import (
    CONTACT_CROSSES,
    LOWER_STATE,
    NOT_MEASURED,
    result_mesh,
    result_specimen,
)
from bilayer.results.sheet_report import (
    sheet_lines,
    warnings_of_laws,
    warnings_of_thickness,
)
from bilayer.results.table import as_shown, cells, stretch_text, stretches, time_column
from bilayer.runtime.terminal import one_line
from bilayer.specimen.doubts import doubts
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml_text import parse_toml

FLAT_FROM = 1e4
"""Radius of the best sphere over that of the sheet from which on a shape is called flat.

Such a sheet rises by less than a twenty-thousandth of its radius.
"""


def result_table(result: xr.Dataset) -> str:
    """Return one line per milestone, under two of titles and units: shape, stability, effort."""
    result = along_milestones(result)
    span = result["span"].values
    columns = {
        ("pre-", "stretch"): [stretch_text(pair) for pair in stretches(result)],
        **time_column(result),
        **load_columns(result),
        ("", "reached"): ["yes" if done else "no" for done in result["converged"].values],
        ("", "quality"): cells(result["quality"].values, "{:.3f}"),
        ("radius", "mm"): _radii(result),
        ("rmse", "mm"): cells(1e3 * result["sphere_rmse"].values, "{:.2f}"),
        ("height", "mm"): cells(1e3 * result["height"].values, "{:.2f}"),
        ("span x", "mm"): cells(1e3 * span[:, 0], "{:.2f}"),
        ("span y", "mm"): cells(1e3 * span[:, 1], "{:.2f}"),
        ("hemi-", "sphere"): cells(result["hemisphere_distance"].values, "{:.3f}"),
        ("gap to", "itself"): gap_words(result),
        ("unstable", "modes"): [str(n) if n >= 0 else "?" for n in result["unstable_modes"].values],
        ("load", "steps"): [str(count) for count in result["load_steps"].values],
        ("Newton", "steps"): [str(count) for count in result["iterations"].values],
        ("", "residual"): cells(result["residual"].values, "{:.0e}"),
        ("time", "s"): cells(result["wall_time"].values, "{:.1f}"),
    }
    return pd.DataFrame(columns).to_string(index=False)


def load_columns(result: xr.Dataset) -> dict[tuple[str, str], list[str]]:
    """Return the columns of a table with the loads and what they do their work on."""
    columns = {}
    for load in result_specimen(result).loads:
        for name in (f"{LOAD}{load.name}", f"{RESPONSE}{load.name}"):
            if name in result.variables:
                told = result[name].attrs.get("units", "")
                values, unit = as_shown(result[name].values, told)
                columns[load.name, unit] = cells(values, "{:.4g}")
    return columns


def provenance(result: xr.Dataset) -> str:
    """Return the provenance of a result: solver, specimen, mesh, settings, versions; its table."""
    result = along_milestones(result)
    specimen = result_specimen(result)
    done = int(result["converged"].sum())
    lines = [
        f"solver      {result.attrs['solver']}, model {result.attrs['model']}",
        *sheet_lines(specimen),
        f"mesh        {result.sizes['node']} nodes, {result.sizes['face']} triangles",
        *_patterns_of_the_mesh(specimen, result),
        "settings    " + ", ".join(f"{k} = {v!r}" for k, v in _settings(result).items()),
        f"versions    {result.attrs['versions']}",
        f"git commit  {result.attrs['git_commit'] or 'unknown'}",
        f"milestones  {done} of {result.sizes['prestretch']} reached",
        *effort_lines(result),
        f"energy      {_energies(result)}",
    ]
    if result.attrs["stop_reason"]:
        lines.append(f"stopped     {result.attrs['stop_reason']}")
    if NOT_MEASURED in result.attrs:
        lines.append(f"unmeasured  {result.attrs[NOT_MEASURED]}")
    shown = [one_line(line) for line in lines]  # a name in the file makes no further lines
    return "\n".join([*shown, "", result_table(result), "", describe_trust(result)])


def _energies(result: xr.Dataset) -> str:
    """Return the sum of the energy terms (a weight has none) at each milestone reached."""
    if "energy" not in result or result.sizes["term"] == 0:
        return "unknown"
    total = 1e3 * result["energy"].sum("term", skipna=False).values[result["converged"].values == 1]
    if len(total) == 0:
        return "unknown"
    return ", ".join(f"{energy:.5g}" for energy in total) + " mJ"


def _radii(result: xr.Dataset) -> list[str]:
    """Return the radius of the best sphere at each milestone, in mm; a flat sheet has none."""
    radius = result["sphere_radius"].values
    flattest = FLAT_FROM * result_specimen(result).characteristic_length
    shown = cells(1e3 * radius, "{:#.5g}")
    return ["flat" if r > flattest else cell for r, cell in zip(radius, shown, strict=True)]


def gap_words(result: xr.Dataset) -> list[str]:
    """Return for each milestone the gap of the body to itself: "1.34 mm", "touches" or "wide".

    "wide" if the gap is too wide to be measured; "-" if there is no shape, "?" if the file is older
    than the measure.
    """
    if "self_contact_gap" not in result:
        return ["?"] * result.sizes["prestretch"]
    gaps = result["self_contact_gap"].values
    if CONTACT_CROSSES in result:  # the barrier's own gap, if it acts
        gaps = np.where(np.isfinite(result["contact_gap"].values), result["contact_gap"], gaps)
        gaps = np.where(result[CONTACT_CROSSES].values == 1, 0.0, gaps)
    return [_gap_word(gap) for gap in gaps]


def _gap_word(gap: float) -> str:
    if np.isnan(gap):
        return "-"
    if gap == 0:
        return "touches"
    return "wide" if np.isinf(gap) else f"{1e3 * gap:.2f} mm"


def describe_trust(result: xr.Dataset) -> str:
    """Return a few sentences on the trust that the result deserves."""
    return " ".join(trust_sentences(result))


def trust_sentences(result: xr.Dataset) -> list[str]:
    """Return the sentences of `describe_trust`."""
    if not result["converged"].values.any():
        return ["No milestone was reached: there is no equilibrium in this file."]
    lost = stretches(result)[result["converged"].values == 0]
    missing = [f"NOT REACHED: {', '.join(map(stretch_text, lost))}."] if len(lost) else []
    return [
        _describe_equilibrium(result),
        *describe_lower_states(result),
        _describe_contact(result),
        *(f"Doubtful: {doubt}." for doubt in doubts(result_specimen(result))),
        *table_warnings(result),
        *missing,
    ]


def _describe_equilibrium(result: xr.Dataset) -> str:
    done = result["converged"].values.astype(bool)
    modes = result["unstable_modes"].values[done]
    residual = result["residual"].values[done].max()
    solved = f"Every reached milestone is solved to a relative residual of {residual:.0e}"
    if (modes < 0).any():
        return f"{solved}; this method cannot tell whether it is stable."
    if (modes > 0).any():
        unstable = ", ".join(map(stretch_text, stretches(result)[done][modes > 0]))
        return f"{solved}; NOT STABLE at {unstable}: another shape has less energy."
    return f"{solved}, and stable."


def law_warnings(result: xr.Dataset) -> list[str]:
    """Return a sentence for each layer that a milestone stretches beyond its law's stability."""
    reached = stretches(result)[result["converged"].values == 1]
    return warnings_of_laws(result_specimen(result), [(float(x), float(y)) for x, y in reached])


def describe_lower_states(result: xr.Dataset) -> list[str]:
    """Return the milestones at which a lower state is known, if anybody has looked."""
    if LOWER_STATE not in result:
        return []
    pairs, below = stretches(result), result[LOWER_STATE].values
    known = [
        f"{stretch_text(pairs[row])} ({-below[row]:.2%} below)" for row in np.flatnonzero(below < 0)
    ]
    if known:
        return [f"A LOWER STATE is known at {', '.join(known)}."]
    return ["No lower state was found by the starts that were tried."]


def _describe_contact(result: xr.Dataset) -> str:
    """Return the milestones at which the body touches itself, and the first contact, as a text."""
    if "self_contact_gap" not in result:
        return "Self-contact was not looked for when this file was made."
    names = [stretch_text(pair) for pair in stretches(result)]
    if CONTACT_CROSSES in result:
        return _describe_modelled_contact(result, names)
    gaps = result["self_contact_gap"].values
    touching = np.flatnonzero(gaps == 0)
    if len(touching) == 0:
        return "The body does not touch itself."
    first = touching[0]
    free = np.flatnonzero(gaps[:first] > 0)
    between = f"between {names[free[-1]]} and {names[first]}" if len(free) else f"by {names[first]}"
    return (
        f"The body TOUCHES ITSELF at {', '.join(names[k] for k in touching)}, first {between}; "
        f"contact is not modelled, so those shapes pass through themselves.{_missing(result)}"
    )


def _describe_modelled_contact(result: xr.Dataset, names: list[str]) -> str:
    pressed, crossing = result["contact_pairs"].values > 0, result[CONTACT_CROSSES].values == 1
    if crossing.any():
        where = ", ".join(names[k] for k in np.flatnonzero(crossing))
        return f"The body PASSES THROUGH ITSELF at {where}, although contact is modelled."
    if not pressed.any():
        return "The body does not touch itself."
    where = ", ".join(names[k] for k in np.flatnonzero(pressed))
    force, gap = result["contact_force"].max(), result["contact_gap"].min()
    return (
        f"The body presses on itself at {where}, with up to {1e3 * float(force):.3g} mN, and "
        f"nowhere passes through itself: contact is modelled, without friction, at gaps of "
        f"{1e3 * float(gap):.2g} mm and more."
    )


def _missing(result: xr.Dataset) -> str:
    """Say what to install if the settings ask for contact and the run could not model it."""
    if _settings(result).get("contact") != "barrier":
        return ""
    return f" Contact needs the package {PACKAGE}: {HOW_TO_INSTALL}"


def thickness_warnings(result: xr.Dataset) -> list[str]:
    """Return a sentence if the sheet of a shell's result is too thick for a shell."""
    return (
        warnings_of_thickness(result_specimen(result)) if result.attrs["solver"] == "dshell" else []
    )


def table_warnings(result: xr.Dataset) -> list[str]:
    """Return what has to be said under a table of shapes: beyond a law, a mesh, or a shell."""
    return [*thickness_warnings(result), *mesh_warnings(result), *law_warnings(result)]


def mesh_warnings(result: xr.Dataset) -> list[str]:
    """Return a sentence if the mesh of a shell is too coarse for the curvature of a shape."""
    coarse = (result["converged"].values == 1) & is_coarse(result)
    if not coarse.any():
        return []
    sharpest = rms_turns(result)[coarse].max()
    return [
        f"The mesh is TOO COARSE FOR THE CURVATURE at "
        f"{', '.join(map(stretch_text, stretches(result)[coarse]))}: from triangle to triangle the "
        f"surface turns by {np.degrees(sharpest):.0f} degrees (rms); above "
        f"{np.degrees(SHARPEST_TURN):.0f} the shape is a percent and more off, so use a mesh of "
        f"{SHARPEST_TURN / sharpest:.2g} of the size or less."
    ]


def _settings(result: xr.Dataset) -> dict[str, object]:
    return parse_toml(result.attrs["settings"], "settings of the result")


def _patterns_of_the_mesh(specimen: Specimen, result: xr.Dataset) -> list[str]:
    """Say which layers are whole in the specimen and have a pattern by the mesh alone."""
    if not all(layer.is_whole for layer in specimen.layers):
        return []
    return [
        f"            DEFINES THE PATTERN of {name}, which lies on {share:.1%} of the area; the "
        "specimen has none"
        for name, share in layers_defined_by(result_mesh(result), specimen).items()
    ]
