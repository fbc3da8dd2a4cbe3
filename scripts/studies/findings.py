"""What the studies say of the paper's conclusions, each with its numbers."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

PRESTRETCH = 1.15
"""Where the fields are held against one another: between bending a little and curling up."""
PAPER_BEST = 0.1
"""Section VI: "currently the best result I can get is 0.1"."""
PAPER_SHIFT = 0.08
"""Section VII: the shell's quality "is about 0.08 behind that of the FEA results"."""


def sound_points(study: xr.Dataset, field: str | None = None) -> pd.DataFrame:
    """Return the points that a real specimen can show: reached, stable, not through itself."""
    names = ["quality", "converged", "unstable_modes", "self_contact_gap"]
    table = study[names].to_dataframe().reset_index()
    sound = table[
        (table["converged"] == 1) & (table["unstable_modes"] <= 0) & (table["self_contact_gap"] > 0)
    ]
    columns = ["solver", "model", "prestretch", *([] if field is None else [field]), "quality"]
    return sound[columns]


def range_findings(study: xr.Dataset, field: str) -> list[str]:
    """Say how far the quality moves with one field, and where it is best."""
    lines = [f"quality over {field}"]
    points = sound_points(study, field)
    for solver, of_one in points.groupby("solver"):
        best = of_one.loc[of_one["quality"].idxmin()]
        lines.append(
            f"  {solver}: best {best['quality']:.3f} at {field} = {best[field]:g}, prestretch "
            f"{best['prestretch']:g} (the paper's best: {PAPER_BEST}); "
            f"{len(of_one)} sound points"
        )
        at = of_one[np.isclose(of_one["prestretch"], PRESTRETCH)]
        values = ", ".join(f"{x:g}: {q:.3f}" for x, q in zip(at[field], at["quality"], strict=True))
        lines.append(f"  {solver}, prestretch {PRESTRETCH}: {values or 'no sound point'}")
    return [*lines, ""]


def most_important(studies: Mapping[str, xr.Dataset]) -> list[str]:
    """Say whether the number of strips moves the quality most, the paper's first conclusion."""
    rows = []
    for field, study in studies.items():
        points = sound_points(study, field)
        at = points[np.isclose(points["prestretch"], PRESTRETCH)]
        rows += [
            {"solver": solver, "field": field, "range": float(np.ptp(of_one["quality"]))}
            for solver, of_one in at.groupby("solver")
        ]
    lines = []
    for solver, ranges in pd.DataFrame(rows, columns=["solver", "field", "range"]).groupby(
        "solver"
    ):
        by_size = ranges.sort_values("range", ascending=False)
        listed = ", ".join(
            f"{row.field} {row.range:.3f}" for row in by_size.itertuples(index=False)
        )
        lines.append(f"{solver}, range of the quality at prestretch {PRESTRETCH}: {listed}")
        if set(by_size["field"]) >= {"cut.strips", "cut.cutout_angle", "cut.inner_radius"}:
            holds = "holds" if by_size["field"].iloc[0] == "cut.strips" else "does NOT hold"
            lines.append(f"  the paper's 'the number of the strips is the most important': {holds}")
    return [*lines, ""]


def model_findings(study: xr.Dataset) -> list[str]:
    """Say how far each shell model's quality is from that of the finite elements."""
    table = sound_points(study).pivot_table(index="prestretch", columns="model", values="quality")
    lines = ["quality of each model over the prestretch", table.round(3).to_string()]
    if "solid" in table:
        for model in table.columns.drop("solid"):
            shift = float((table["solid"] - table[model]).mean())
            lines.append(
                f"  {model}: {shift:+.3f} in the mean to the finite elements' "
                f"(the paper's shell: {PAPER_SHIFT} below)"
            )
    return lines
