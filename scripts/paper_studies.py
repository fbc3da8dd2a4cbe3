"""The paper's figures 5a, 5b and 6 and its number of strips as studies: data, pictures, findings.

Started by scripts/paper_studies, which sets the environment up. What is computed stays in
results/studies and is not computed again. Pictures, scalars and findings are made anew after every
study, so that whatever ends the command leaves those of what is computed.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
import xarray as xr
from studies.findings import (
    bounded,
    conclusions,
    contact_findings,
    model_findings,
    no_points,
    points_of,
    range_findings,
    spans_findings,
)
from studies.merged import with_contact

import bilayer
from bilayer.figures import draw_quality_against, save_figure
from bilayer.runtime.output_file import whole_file
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.time_limit import read_duration
from bilayer.study.figure import draw_study
from bilayer.study.folder import StudyFolder
from bilayer.study.index import write_index
from bilayer.study.plan import StudyPlan, read_study
from bilayer.study.run import run_study
from bilayer.validation import one_of

STUDIES = Path(__file__).parent / "studies"
RESULTS = Path(__file__).parents[1] / "results" / "studies"
FIELDS = {
    "cutout_angle": "cut.cutout_angle",
    "radius_ratio": "cut.inner_radius",
    "strips": "cut.strips",
}
MODELS = "models"
NAMES = (*FIELDS, MODELS)
SOLVERS = ("dshell", "fenics")
SOLID_UP_TO = 1.15
"""Prestretch up to which the fields are judged by the finite elements: beyond, most shapes press on
themselves, and were not computed with contact."""
SHAPES = ("position", "reference_position", "face_nodes", "region", "case_file")
"""Variables that are left out of the scalars: large ones, and paths of this machine."""


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    try:
        run_studies([one_of("STUDY", name, NAMES) for name in options.study] or NAMES,
                    options.solver or SOLVERS, _study_options(options))  # fmt: skip
    except bilayer.BilayerError as error:
        print(f"scripts/paper_studies: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    return 0


@dataclass(frozen=True)
class StudyOptions:
    """How studies are computed; see `bilayer.study.run.run_study`."""

    jobs: int | None = None
    limit: float | None = None
    retry_failed: bool = False


def run_studies(
    names: Sequence[str], solvers: Sequence[str], options: StudyOptions | None = None
) -> None:
    """Compute what is missing, the quick solver first; draw it, and write what all studies say."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # for the processes of the cases
    for solver in solvers:
        for name in names:
            compute(name, solver, StudyOptions() if options is None else options)
            text = report()
            with whole_file(RESULTS / "findings.txt", "findings") as partial:
                partial.write_text(text, encoding="utf-8")
    print(text, end="")
    print(f"Data, figures and these findings are in {RESULTS}")


def study_names(name: str, solver: str) -> tuple[str, ...]:
    """Return the names of a study's files and folders.

    Each solver has its own. Of the finite elements there are two: with contact there are only those
    cases that touch themselves without it.
    """
    if name == MODELS or solver == "dshell":
        return (name,)
    return f"{name}_{solver}", f"{name}_{solver}_contact"


def compute(name: str, solver: str, options: StudyOptions) -> None:
    """Compute what a study lacks of one solver; keep its scalars, and draw it."""
    for study in study_names(name, solver):
        plan, folder = read_study(STUDIES / f"{study}.toml"), StudyFolder(RESULTS / study)
        folder.path.parent.mkdir(parents=True, exist_ok=True)
        with progress_bar(study) as progress:
            run_study(_only(plan, solver), folder.path, progress=progress, **vars(options))
        folder.keep_plan(plan)  # whole again: what the other solver computed counts, too
        write_index(folder)
        _keep_scalars(folder.path)
    draw(name, solver)


def draw(name: str, solver: str) -> None:
    """Draw what there is of a study."""
    studies = [bilayer.open_study(RESULTS / study) for study in study_names(name, solver)]
    study = with_contact(*studies)
    if name == MODELS:
        save_figure(draw_study(study, "prestretch", "quality", "model"), RESULTS / "models.png")
        _draw_figure_6(study)
        return
    figure = draw_study(study, FIELDS[name], "quality", "prestretch")
    save_figure(figure, RESULTS / f"{name}_{solver}.png")


def report() -> str:
    """Return the findings of the finished studies on the paper's conclusions."""
    points = bounded({field: _points(name, field) for name, field in FIELDS.items()})
    lines = [line for field, table in points.items() for line in range_findings(table, field)]
    lines += [*contact_findings(points), *spans_findings(points)]
    models = _points(MODELS)
    lines += model_findings(models)
    lines += conclusions(points, models)
    return "\n".join(lines) + "\n"


def _points(name: str, field: str | None = None) -> pd.DataFrame:
    """Return the points of a study, of all solvers that are there."""
    studies = dict.fromkeys(study_names(name, solver) for solver in SOLVERS)
    there = [
        [_scalars(part) for part in parts if _scalars_file(RESULTS / part).exists()]
        for parts in studies
    ]
    tables = [points_of(with_contact(*parts), field) for parts in there if parts]
    if not tables:
        return no_points(field)
    points = pd.concat(tables, ignore_index=True)
    beyond = (points["solver"] == "fenics") & (points["prestretch"] > SOLID_UP_TO)
    return points[~beyond] if field is not None else points


def _scalars_file(folder: Path) -> Path:
    return folder / "scalars.nc"


def _keep_scalars(folder: Path) -> None:
    """Write what a study says besides its shapes: small enough to be kept with the program."""
    study = bilayer.open_study(folder)
    scalars = study.drop_vars(SHAPES, errors="ignore").assign_attrs(study=folder.name)
    with whole_file(_scalars_file(folder), "scalars of a study") as partial:
        scalars.to_netcdf(partial)


def _scalars(study: str) -> xr.Dataset:
    with xr.open_dataset(_scalars_file(RESULTS / study)) as stored:
        return stored.load()


def _study_options(options: argparse.Namespace) -> StudyOptions:
    limit = None if options.limit is None else read_duration("--limit", options.limit)
    return StudyOptions(options.jobs, limit, options.retry_failed)


def _only(plan: StudyPlan, solver: str) -> StudyPlan:
    return replace(plan, cases=tuple(case for case in plan.cases if case.solver == solver))


def _draw_figure_6(study: xr.Dataset) -> None:
    """Draw each shell model's quality against that of the finite elements, if they are there."""
    names = (study[name].values.ravel() for name in ("model", "case_file"))
    files = dict(zip(*names, strict=True))
    if not files.get("solid"):
        return
    reference = bilayer.open_result(files["solid"])
    for model in ("morley", "hinge", "paper"):
        if not files.get(model):
            continue
        figure = draw_quality_against(bilayer.open_result(files[model]), reference)
        save_figure(figure, RESULTS / f"{model}_against_fenics.png")


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/paper_studies",
        description="The paper's figures 5a, 5b and 6 and its number of strips as studies. "
        "A second start goes on where the first one was ended.",
        epilog="example:\n  scripts/paper_studies cutout_angle --solver dshell",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "study", nargs="*", metavar="STUDY", help=f"some of {', '.join(NAMES)}; all if left out"
    )
    parser.add_argument("--solver", action="append", choices=SOLVERS, help="only this one")
    parser.add_argument("--jobs", type=int, metavar="N", help="cases at a time")
    parser.add_argument(
        "--limit", metavar="TIME", help="most time for a milestone, such as 5min; the case stops "
        "there, --retry-failed goes on",
    )  # fmt: skip
    parser.add_argument("--retry-failed", action="store_true", help="go on with what stopped early")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
