"""The paper's figures 5a, 5b and 6 and its number of strips as studies: data, pictures, findings.

Started by scripts/paper_studies, which sets the environment up. What is computed stays in
results/studies/NAME and is not computed again.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import xarray as xr
from studies.findings import model_findings, most_important, range_findings

import bilayer
from bilayer.figures import draw_quality_against, save_figure
from bilayer.progress import progress_bar
from bilayer.study.plan import StudyPlan, read_study
from bilayer.study.run import run_study
from bilayer.study_figure import draw_study
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


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    try:
        run_studies([one_of("STUDY", name, NAMES) for name in options.study] or NAMES,
                    options.solver or SOLVERS, options.jobs)  # fmt: skip
    except bilayer.BilayerError as error:
        print(f"scripts/paper_studies: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    return 0


def run_studies(names: Sequence[str], solvers: Sequence[str], jobs: int | None = None) -> None:
    """Compute what is missing, draw it, and write what all studies say."""
    for name in names:
        compute(name, solvers, jobs)
        draw(name)
    text = report()
    (RESULTS / "findings.txt").write_text(text, encoding="utf-8")
    print(text, end="")
    print(f"Data, figures and these findings are in {RESULTS}")


def compute(name: str, solvers: Sequence[str], jobs: int | None) -> None:
    """Compute what a study lacks, of some of its solvers."""
    plan = read_study(STUDIES / f"{name}.toml")
    folder = RESULTS / name
    folder.parent.mkdir(parents=True, exist_ok=True)
    with progress_bar(name) as progress:
        run_study(_only(plan, solvers), folder, jobs=jobs, progress=progress)


def draw(name: str) -> None:
    """Draw what there is of a study."""
    study = bilayer.open_study(RESULTS / name)
    if name == MODELS:
        save_figure(draw_study(study, "prestretch", "quality", "model"), RESULTS / "models.png")
        _draw_figure_6(study)
        return
    for solver in finished_solvers(study):
        figure = draw_study(study, FIELDS[name], "quality", "prestretch", {"solver": solver})
        save_figure(figure, RESULTS / f"{name}_{solver}.png")


def report() -> str:
    """Return what the studies that are there say of the paper's conclusions."""
    there = {
        name: bilayer.open_study(RESULTS / name)
        for name in NAMES
        if (RESULTS / name / "plan.json").exists()
    }
    ranges = {FIELDS[name]: study for name, study in there.items() if name in FIELDS}
    lines = [line for field, study in ranges.items() for line in range_findings(study, field)]
    lines += most_important(ranges)
    if MODELS in there:
        lines += model_findings(there[MODELS])
    return "\n".join(lines) + "\n"


def finished_solvers(study: xr.Dataset) -> list[str]:
    """Return the solvers of which a study holds results."""
    solvers, files = study["solver"].values.ravel(), study["case_file"].values.ravel()
    if solvers.size != files.size:  # a dimension of its own
        files = study["case_file"].transpose("solver", ...).values.reshape(len(solvers), -1)
        return [str(s) for s, of_one in zip(solvers, files, strict=True) if (of_one != "").any()]
    return sorted({str(s) for s, file in zip(solvers, files, strict=True) if file})


def _only(plan: StudyPlan, solvers: Sequence[str]) -> StudyPlan:
    return replace(plan, cases=tuple(case for case in plan.cases if case.solver in solvers))


def _draw_figure_6(study: xr.Dataset) -> None:
    """Draw each shell model's quality against that of the finite elements, if they are there."""
    names = (study[name].values.ravel() for name in ("model", "case_file"))
    files = dict(zip(*names, strict=True))
    if not files.get("solid"):
        return
    reference = bilayer.open_result(files["solid"])
    for model in ("morley", "hinge", "paper"):
        figure = draw_quality_against(bilayer.open_result(files[model]), reference)
        save_figure(figure, RESULTS / f"{model}_against_fenics.png")


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/paper_studies",
        description="The paper's figures 5a, 5b and 6 and its number of strips as studies.",
        epilog="example:\n  scripts/paper_studies cutout_angle --solver dshell",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "study", nargs="*", metavar="STUDY", help=f"some of {', '.join(NAMES)}; all if left out"
    )
    parser.add_argument("--solver", action="append", choices=SOLVERS, help="only this one")
    parser.add_argument("--jobs", type=int, metavar="N", help="cases at a time")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
