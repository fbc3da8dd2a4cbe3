"""Every case of the maps with the finite-element model: reached, stable, and at what cost.

Started by scripts/fe_maps, which sets the environment up. A map is a study of scripts/studies with
the milestones and the mesh of its specimen. A case's result file stays in the folder and is not
computed again; an unfinished one goes on from its last milestone.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

import bilayer
from bilayer.runtime.output_file import whole_file
from bilayer.runtime.progress import Progress, progress_bar
from bilayer.solvers.path import LoadStep
from bilayer.study.plan import read_study
from bilayer.validation import one_of

STUDIES = Path(__file__).parent / "studies"
RESULTS = Path(__file__).parents[1] / "results" / "fe_maps"
PAGE = Path(__file__).parents[1] / "docs" / "fe_maps.md"
MAPS = {
    "strips": "cut.strips",
    "cutout_angle": "cut.cutout_angle",
    "radius_ratio": "cut.inner_radius",
}
OTHERS: Mapping[str, Sequence[str]] = {
    "disc of 50 mm, six strips": (
        "specimen.outer_radius=0.05", "cut.strips=6", "cut.cutout_angle=0.35",
        "cut.inner_radius=0.01", "mesh.size=0.005", "prestretch.milestones=[1.03, 1.06]",
    ),
    "straight to 1.34": ("prestretch.milestones=[1.34]",),
    "straight to 1.78": ("prestretch.milestones=[1.78]",),
}  # fmt: skip
"""Cases beside the maps, each by what it changes of the specimen."""

COLUMNS = ("reached", "unstable", "iterations", "factorisations", "CPU s", "flow steps")
NOT_COMPUTED = "not computed"
MOST_ITERATIONS, MOST_TIMES_MEDIAN = 40, 5.0
"""Of the median case, and of the slowest one over the time of the median."""


@dataclass(frozen=True)
class MapCase:
    """A case of a map.

    Parameters
    ----------
    name : str
        As it is shown, such as "strips = 3".
    specimen : Specimen
        What is released.
    """

    name: str
    specimen: bilayer.Specimen

    def file(self, folder: Path) -> Path:
        """Return where its result is kept."""
        words = "".join(letter if letter.isalnum() else "_" for letter in self.name)
        return folder / f"{words}.nc"


def map_cases() -> list[MapCase]:
    """Return the cases of all maps, each specimen once, and those beside them."""
    cases: dict[str, MapCase] = {}
    for study, field in MAPS.items():
        for case in read_study(STUDIES / f"{study}.toml").cases:
            name = f"{field.split('.')[1]} = {case.values[field]:g}"
            cases.setdefault(bilayer.specimen_to_toml(case.specimen), MapCase(name, case.specimen))
    return list(cases.values())


def other_cases() -> list[MapCase]:
    """Return the cases beside the maps."""
    return [
        MapCase(name, bilayer.read_specimen(STUDIES / "specimen.toml", changes))
        for name, changes in OTHERS.items()
    ]


def solve_case(case: MapCase, folder: Path, progress: Progress | None = None) -> xr.Dataset:
    """Compute a case, or what an earlier run has left of it."""
    file = case.file(folder)

    def told(step: LoadStep[Any, Any]) -> None:
        if step.ends_target:
            print(f"  {_milestone_line(step)}", file=sys.stderr, flush=True)

    return bilayer.solve(
        case.specimen,
        "fenics",
        progress=progress,
        observers=[told],
        output=file,
        resume=file if file.exists() else None,
    )


def _milestone_line(step: LoadStep[Any, Any]) -> str:
    effort, stretch = step.effort, max(step.target)
    return (
        f"{stretch:.6g}: {'reached' if step.is_at_target else step.failure}, "
        f"{step.point.unstable_modes} unstable modes, {effort.iterations} iterations, "
        f"{effort.work.factorisations} factorisations, {effort.guided_steps} guided steps, "
        f"{effort.load_steps} load steps, {effort.flow_steps} flow steps, {effort.work.total:.1f} s"
    )


def cost_row(result: xr.Dataset) -> dict[str, Any]:
    """Return what a case came to and what it cost, by the names of `COLUMNS`."""
    reached = result["converged"].values == 1
    modes = result["unstable_modes"].values
    return {
        "reached": f"{int(reached.sum())} of {len(reached)}",
        "unstable": int(np.sum(reached & (modes > 0))),
        "iterations": int(result["iterations"].sum()),
        "factorisations": int(result["factorisations"].sum()),
        "CPU s": float(result["cpu_time"].sum()),
        "flow steps": int(result["stabilised_steps"].sum()),
        "missed": int((~reached).sum()),
        "touching": int(np.sum(reached & (result["self_contact_gap"].values <= 0))),
        "milestones": len(reached),
    }


def cost_table(cases: Sequence[MapCase], folder: Path) -> pd.DataFrame:
    """Return the rows of all cases that are computed, by name."""
    rows = {
        case.name: cost_row(bilayer.open_result(case.file(folder)))
        for case in cases
        if case.file(folder).exists()
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def summary(table: pd.DataFrame) -> list[str]:
    """Return what the maps show together, a line each, with what is asked of it."""
    slowest = table["CPU s"].idxmax()
    times = table["CPU s"].max() / table["CPU s"].median()
    return [
        f"{len(table)} cases, {table['milestones'].sum()} points",
        f"not reached: {table['missed'].sum()} points (asked: 0)",
        f"unstable: {table['unstable'].sum()} points (asked: 0)",
        f"iterations: {table['iterations'].median():g} in the median case (asked: at most "
        f"{MOST_ITERATIONS}), {table['iterations'].max()} in the worst",
        f"CPU time: {table['CPU s'].median():.1f} s in the median case; the slowest, {slowest}, "
        f"takes {times:.1f} times that (asked: at most {MOST_TIMES_MEDIAN:g})",
    ]


def page(
    maps: pd.DataFrame,
    others: pd.DataFrame,
    map_names: Sequence[str] = (),
    other_names: Sequence[str] = (),
) -> str:
    """Return the page of the tables.

    Parameters
    ----------
    maps, others : DataFrame
        Rows of the cases that are computed.
    map_names, other_names : sequence of str
        All cases, in their order; those without a row are said not to be computed.
    """
    return "\n".join([
        "# The maps with the finite-element model",
        "",
        "`scripts/fe_maps` writes this page from its results. Each case is the paper's specimen",
        "with one field changed, on a planar mesh of 6 mm, at the eight prestretches 1.03 to 1.24,",
        "with the default settings. The fields and values are those of `scripts/studies`.",
        "Iterations are new tangents; factorisations count those for the stability, too. CPU time",
        "is that of one core, without the shell's own. Flow steps are time steps of the viscous",
        "flow, which leads where Newton's method does not. docs/theory-fenics.md says how a",
        "milestone is reached.",
        "",
        *[
            fill(line, 100, initial_indent="- ", subsequent_indent="  ")
            for line in [*_missing(maps, map_names), *summary(maps)]
        ],
        "",
        *_rows(maps, map_names),
        "",
        "## Beside the maps",
        "",
        *_rows(others, other_names),
        "",
    ])  # fmt: skip


def _missing(table: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """Return a line that warns of cases that are not computed; none if all are."""
    left = len([name for name in names if name not in table.index])
    if not left:
        return []
    return [
        f"**{left} of {len(names)} cases are not computed. What follows is of the others, and no "
        "median of the maps.**"
    ]


def _rows(table: pd.DataFrame, names: Sequence[str] = ()) -> list[str]:
    lines = ["| case | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    for name in names or table.index:
        if name not in table.index:
            lines.append(f"| {name} | {NOT_COMPUTED}" + " |" * len(COLUMNS))
            continue
        row = table.loc[name]
        shown = [f"{row[c]:.1f}" if c == "CPU s" else str(row[c]) for c in COLUMNS]
        lines.append(f"| {name} | " + " | ".join(shown) + " |")
    return lines


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    try:
        return run(options.cases, options.folder, options.page)
    except bilayer.BilayerError as error:
        print(f"scripts/fe_maps: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1


def run(names: Sequence[str], folder: Path, page_file: Path | None) -> int:
    """Compute what is missing of the named cases, or of all, and show the tables."""
    maps, others = map_cases(), other_cases()
    known = [case.name for case in (*maps, *others)]
    wanted = [one_of("CASE", name, known) for name in names] or known
    folder.mkdir(parents=True, exist_ok=True)
    for case in (*maps, *others):
        if case.name in wanted:
            with progress_bar(case.name) as progress:
                row = cost_row(solve_case(case, folder, progress))
            print(f"{case.name}: " + ", ".join(f"{c} {row[c]}" for c in COLUMNS), flush=True)
    tables = [cost_table(cases, folder) for cases in (maps, others)]
    if not tables[0].empty:
        print("\n".join(summary(tables[0])))
    if page_file is not None and not tables[0].empty:
        names = ([case.name for case in cases] for cases in (maps, others))
        with whole_file(page_file, "page") as partial:
            partial.write_text(page(*tables, *names), encoding="utf-8")
    return 0


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/fe_maps",
        description="Every case of the maps with the finite-element model: reached, stable, and "
        "at what cost. A second start goes on where the first one was ended.",
        epilog='example:\n  scripts/fe_maps "strips = 3"',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", help="some by name; all if left out")
    parser.add_argument("--folder", type=Path, default=RESULTS, help="of the result files")
    parser.add_argument(
        "--page",
        type=Path,
        metavar="FILE.md",
        help="write the tables there, and which cases are not computed",
    )
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
