"""The paper's specimen with both solvers, their comparison, and what the paper said of it.

Started by scripts/reproduce, which sets the environment up.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import xarray as xr
from paper_observations import accurate_shell_conclusion, observations
from paper_studies import NAMES, SOLVERS, run_studies

import bilayer
from bilayer.figures import (
    draw_birds_eye,
    draw_distances,
    draw_isometric,
    draw_mesh,
    draw_quality,
    draw_quality_against,
    save_figure,
)
from bilayer.results.comparison import compare, comparison_table
from bilayer.results.report import result_table
from bilayer.runtime.progress import progress_bar
from bilayer.solvers.registry import settings_class

RESULTS = Path(__file__).parents[1] / "results"
QUICK_MILESTONES = (1.03, 1.06, 1.15, 1.24)
QUICK_SOLVERS = ("dshell",)
QUICK_MESH = bilayer.MeshSize(0.006)
SHELLS = {
    "morley": "The accurate shell (morley)",
    "hinge": "Hinges and springs with the natural lengths and angles of laminate theory (hinge)",
    "paper": "The paper's shell as printed, its substrate of constant thickness (paper)",
}
PRINTED = "paper"
"""The shell whose thousands of time steps take longer than everything else together."""


def main() -> int:
    options = _options()
    specimen = bilayer.paper_specimen()
    if options.quick:
        specimen = replace(specimen, mesh=QUICK_MESH).with_milestones(QUICK_MILESTONES)
    folder = options.output or RESULTS / ("quick" if options.quick else "paper")
    folder.mkdir(parents=True, exist_ok=True)
    try:
        reproduce(specimen, folder)
        if options.all:
            run_studies(NAMES, QUICK_SOLVERS if options.quick else SOLVERS)
    except bilayer.BilayerError as error:
        print(f"scripts/reproduce: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    return 0


def reproduce(specimen: bilayer.Specimen, folder: Path) -> None:
    """Compute, draw and report; every result is on the disk as soon as it is there."""
    mesh = bilayer.generate_mesh(specimen)
    save_figure(draw_mesh(mesh), folder / "mesh.png")
    with ProcessPoolExecutor(1, get_context("spawn")) as second_core:
        others = second_core.submit(_all_but_printed, specimen, mesh, folder)
        printed = _solved(specimen, mesh, "dshell", PRINTED, folder)
        fenics, shells = others.result()
    shells[PRINTED] = printed
    _draw(fenics, shells, folder)
    report = report_of(fenics, shells)
    (folder / "report.txt").write_text(report, encoding="utf-8")
    print(report, end="")
    print(f"\nResults, figures and this report are in {_shown(folder)}")


def _all_but_printed(
    specimen: bilayer.Specimen, mesh: bilayer.PlanarMesh, folder: Path
) -> tuple[xr.Dataset, dict[str, xr.Dataset]]:
    """Compute, without a bar, what fits into the time of the printed shell: FE and its shells."""
    shells = {
        model: _solved(specimen, mesh, "dshell", model, folder, shown=False)
        for model in SHELLS
        if model != PRINTED
    }
    return _solved(specimen, mesh, "fenics", "solid", folder, shown=False), shells


def _solved(
    specimen: bilayer.Specimen,
    mesh: bilayer.PlanarMesh,
    solver: str,
    model: str,
    folder: Path,
    shown: bool = True,
) -> xr.Dataset:
    settings = settings_class(solver, model)()
    with progress_bar(f"{solver} {model}", shown) as progress:
        result = bilayer.solve(specimen, solver, settings, mesh=mesh, progress=progress)
    name = "fenics.nc" if solver == "fenics" else f"shell_{model}.nc"
    bilayer.write_result(result, folder / name)
    return result


def _draw(fenics: xr.Dataset, shells: dict[str, xr.Dataset], folder: Path) -> None:
    for result, name in ((fenics, "fenics"), (shells[PRINTED], "shell_paper")):
        save_figure(draw_isometric(result), folder / f"{name}_isometric.png")
        save_figure(draw_birds_eye(result), folder / f"{name}_birdseye.png")
    save_figure(draw_quality([fenics, *shells.values()]), folder / "quality.png")
    save_figure(
        draw_quality_against(shells[PRINTED], fenics), folder / "quality_shell_against_fenics.png"
    )
    comparisons = [compare(fenics, shell) for shell in shells.values()]
    save_figure(draw_distances(comparisons), folder / "shells_against_fenics.png")


def report_of(fenics: xr.Dataset, shells: dict[str, xr.Dataset]) -> str:
    """Return the tables of all results, their comparisons, and the paper's observations."""
    parts = [_titled("The finite-element model", result_table(fenics))]
    for model, shell in shells.items():
        parts.append(_titled(SHELLS[model], result_table(shell), shell.attrs["stop_reason"]))
    for model, shell in shells.items():
        title = f"The finite-element model (a) and the shell {model!r} (b)"
        parts.append(_titled(title, comparison_table(compare(fenics, shell))))
    parts.append(_titled("What the paper observed", *observations(fenics, shells[PRINTED])))
    parts.append(accurate_shell_conclusion(fenics, shells["morley"]))
    return "\n\n".join(parts) + "\n"


def _titled(title: str, *lines: str) -> str:
    return "\n".join([title, *(line for line in lines if line)])


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/reproduce",
        description="The paper's specimen with both solvers, their comparison and figures.",
        epilog="example:\n  scripts/reproduce --quick",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="6 mm mesh, four of the prestretches")
    parser.add_argument(
        "--all", action="store_true",
        help="also compute the studies of scripts/paper_studies (with --quick: of the shell only)",
    )  # fmt: skip
    parser.add_argument(
        "--output", type=Path, metavar="DIR",
        help="folder to write to (default: results/paper, or results/quick with --quick)",
    )  # fmt: skip
    return parser.parse_args()


def _shown(folder: Path) -> Path:
    here = Path.cwd()
    return folder.relative_to(here) if folder.is_relative_to(here) else folder


if __name__ == "__main__":
    sys.exit(main())
