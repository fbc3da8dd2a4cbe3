"""The paper's specimen with both solvers, their comparison, and what the paper said of it.

Started by scripts/reproduce, which sets the environment up.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import xarray as xr
from paper_observations import observations

import bilayer
from bilayer.comparison import compare, comparison_table
from bilayer.figures import (
    draw_birds_eye,
    draw_comparison,
    draw_isometric,
    draw_mesh,
    draw_quality,
    draw_quality_against,
    save_figure,
)
from bilayer.progress import progress_bar
from bilayer.report import result_table
from bilayer.solvers import settings_kind

RESULTS = Path(__file__).parents[1] / "results"
QUICK_MILESTONES = (1.03, 1.06, 1.15, 1.24)
QUICK_MESH = bilayer.MeshSize(0.006)


def main() -> int:
    options = _options()
    specimen = bilayer.paper_specimen()
    if options.quick:
        specimen = replace(specimen, mesh=QUICK_MESH).with_milestones(QUICK_MILESTONES)
    folder = options.output or RESULTS / ("quick" if options.quick else "paper")
    folder.mkdir(parents=True, exist_ok=True)
    try:
        reproduce(specimen, folder)
    except bilayer.BilayerError as error:
        print(f"scripts/reproduce: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    return 0


def reproduce(specimen: bilayer.Specimen, folder: Path) -> None:
    """Compute, draw and report; every result is on the disk as soon as it is there."""
    mesh = bilayer.generate_mesh(specimen)
    save_figure(draw_mesh(mesh), folder / "mesh.png")
    shell = _solved(specimen, mesh, "dshell", "paper", folder / "shell_paper.nc")
    fenics = _solved(specimen, mesh, "fenics", "solid", folder / "fenics.nc")
    _draw(fenics, shell, folder)
    report = _report(fenics, shell)
    (folder / "report.txt").write_text(report, encoding="utf-8")
    print(report, end="")
    print(f"\nResults, figures and this report are in {_shown(folder)}")


def _solved(
    specimen: bilayer.Specimen, mesh: bilayer.PlanarMesh, solver: str, model: str, path: Path
) -> xr.Dataset:
    settings = settings_kind(solver, model)()
    with progress_bar(f"{solver} {model}") as progress:
        result = bilayer.solve(specimen, solver, settings, mesh=mesh, progress=progress)
    bilayer.write_result(result, path)
    return result


def _draw(fenics: xr.Dataset, shell: xr.Dataset, folder: Path) -> None:
    for result, name in ((fenics, "fenics"), (shell, "shell_paper")):
        save_figure(draw_isometric(result), folder / f"{name}_isometric.png")
        save_figure(draw_birds_eye(result), folder / f"{name}_birdseye.png")
    save_figure(draw_quality([fenics, shell]), folder / "quality.png")
    save_figure(draw_quality_against(shell, fenics), folder / "quality_shell_against_fenics.png")
    save_figure(draw_comparison(compare(fenics, shell)), folder / "comparison.png")


def _report(fenics: xr.Dataset, shell: xr.Dataset) -> str:
    parts = [
        "The finite-element model",
        result_table(fenics),
        "",
        "The paper's shell, as printed",
        result_table(shell),
        *([shell.attrs["stop_reason"]] if shell.attrs["stop_reason"] else []),
        "",
        "Side by side",
        comparison_table(compare(fenics, shell)),
        "",
        "What the paper observed",
        *observations(fenics, shell),
    ]
    return "\n".join(parts) + "\n"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/reproduce",
        description="The paper's specimen with both solvers, their comparison and figures.",
        epilog="example:\n  scripts/reproduce --quick",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="6 mm mesh, four of the prestretches")
    parser.add_argument(
        "--output", type=Path, metavar="DIR",
        help="where to write; results/paper, or results/quick with --quick, where left out",
    )  # fmt: skip
    return parser.parse_args()


def _shown(folder: Path) -> Path:
    here = Path.cwd()
    return folder.relative_to(here) if folder.is_relative_to(here) else folder


if __name__ == "__main__":
    sys.exit(main())
