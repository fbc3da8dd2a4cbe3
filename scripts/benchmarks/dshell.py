"""The discrete shell: iterations, CPU time by section and memory over meshes and prestretches."""

import argparse
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks import linear_solvers, peer
from benchmarks.shell_release import CPU_PARTS, BenchmarkCase, in_a_process_of_its_own, measure_cost
from dshell import MorleySettings
from dshell.release.coarse_start import GAIN

DESCRIPTION = "the discrete shell: iterations, CPU time by section, memory, sparse solvers"
EXAMPLES = """\
  scripts/benchmark dshell                             # about three minutes
  scripts/benchmark dshell --largest 100000            # one mesh more
  scripts/benchmark dshell --peer ../dismech-python    # its requirements in its own .venv
  scripts/benchmark dshell --write                     # and docs/performance.md"""
COARSE = MorleySettings().coarse_triangles
TRIANGLES = (1300, 2600, 5200, 10_000, 20_000)
TARGETS = (1.06, 1.15, 1.24)
STRIPS = (4, 5, 6)
GROWTH_UP_TO = 22_000
"""Triangles of the largest mesh that counts for the growth."""
FINEST_OF_ALL = 3000
"""Triangles of the largest mesh on which all numbers of strips are released."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what can be chosen: meshes, and the program to compare with."""
    parser.add_argument(
        "--triangles", type=int, nargs="+", default=TRIANGLES, metavar="N",
        help=f"sizes of the meshes, about; {' '.join(map(str, TRIANGLES))} if left out",
    )  # fmt: skip
    parser.add_argument(
        "--largest", type=int, metavar="N",
        help="one more mesh of about N triangles, which does not count for the growth",
    )  # fmt: skip
    parser.add_argument(
        "--peer", type=Path, metavar="PATH",
        help="a checkout of dismech-python, whose Newton iteration is timed beside ours",
    )  # fmt: skip
    parser.add_argument(
        "--peer-python", type=Path, metavar="PATH",
        help="interpreter with the peer's requirements; PATH/.venv/bin/python if left out",
    )  # fmt: skip


def tables(options: argparse.Namespace) -> Iterator[str]:
    """Yield the tables as texts."""
    if options.peer is not None:
        interpreter = options.peer_python or options.peer / ".venv" / "bin" / "python"
        peer.check_peer(options.peer, interpreter)
        beside_the_peer = _beside_the_peer(options.peer, interpreter)  # first: it may fail
    sizes = [*options.triangles, *([options.largest] if options.largest else [])]
    yield from _by_mesh(sizes)
    yield _iterations(options.triangles)
    yield _linear_solvers(options.triangles)
    if options.peer is not None:
        yield beside_the_peer


def _by_mesh(sizes: list[int]) -> Iterator[str]:
    rows = _measured([BenchmarkCase(size) for size in sizes])
    counts = ["triangles", "dofs", "iterations", "load steps", "unstable modes", "GB"]
    rows["kB per triangle"] = 1e6 * rows["GB"] / rows["triangles"]
    yield "One release from flat to a prestretch of 1.15, in one step\n" + _text(
        rows[[*counts, "kB per triangle", "sphere radius (mm)"]]
    )
    parts = [*CPU_PARTS, "rest", "total"]
    yield "CPU seconds; start-up and meshing are not in the total\n" + _text(
        rows[["triangles", "start-up", "meshing", *parts]], "{:.2f}"
    )
    shares = 100 * rows[parts].div(rows["total"], axis=0)
    yield "Shares of the total, %\n" + _text(
        pd.concat([rows["triangles"], shares], axis=1), "{:.0f}"
    )
    yield from _growth(rows, "from flat")
    fine = rows["triangles"] > GAIN * COARSE
    if fine.any():
        asked = np.array(sizes)[fine]
        started = _measured([BenchmarkCase(int(size), coarse_triangles=COARSE) for size in asked])
        yield _beside_flat(started, rows)
        yield from _growth(pd.concat([rows[~fine], started]), "by default")


def _measured(releases: list[BenchmarkCase]) -> pd.DataFrame:
    return pd.DataFrame([_reported(in_a_process_of_its_own(measure_cost, one)) for one in releases])


def _growth(rows: pd.DataFrame, start: str) -> Iterator[str]:
    """Exponents of the cost over the number of triangles."""
    few = rows[rows["triangles"] <= GROWTH_UP_TO]
    if len(few) > 1:
        sections = ["meshing", *CPU_PARTS, "rest", "total"]
        exponents = {name: _exponent(few, few[name]) for name in sections}
        title = f"Growth up to {few['triangles'].max()} triangles, {start}: CPU ~ triangles^p"
        yield f"{title}\n" + _text(pd.DataFrame([exponents]), "{:.2f}")


def _beside_flat(started: pd.DataFrame, from_flat: pd.DataFrame) -> str:
    """Releases from the shape on a coarse mesh, beside those from flat."""
    counts = ["triangles", "iterations", "unstable modes", "GB", "sphere radius (mm)", "total"]
    both = started[counts].merge(
        from_flat[["triangles", "total"]], on="triangles", suffixes=("", " from flat")
    )
    both["ratio"] = both["total from flat"] / both["total"]
    title = "By default: fine meshes start from the shape on a coarse one, which is in the total"
    return f"{title}\n" + _text(both)


def _reported(found: dict[str, Any]) -> dict[str, Any]:
    """Say on the way what a release took, so that an interrupted run has not been for nothing."""
    text = "{triangles} triangles: {iterations} iterations, {total:.1f} s of CPU, {GB:.2f} GB"
    print(text.format(**found), file=sys.stderr, flush=True)
    return found


def _exponent(rows: pd.DataFrame, seconds: pd.Series) -> float:
    return float(np.polyfit(np.log(rows["triangles"]), np.log(seconds), 1)[0])


def _iterations(sizes: list[int]) -> str:
    """Iterations over meshes, prestretches and strips."""
    rows = []
    for strips in STRIPS:
        for size in (size for size in sizes if size <= FINEST_OF_ALL):
            found = [measure_cost(BenchmarkCase(size, target, strips)) for target in TARGETS]
            counts = {f"{one['prestretch']:g}": _count(one) for one in found}
            rows.append({"strips": strips, "triangles": found[0]["triangles"], **counts})
    title = "Iterations from flat in one step, to a relative residual of 1e-8"
    return f"{title} (in brackets: load steps, where more)\n" + _text(pd.DataFrame(rows))


def _count(found: dict[str, Any]) -> str:
    if not found["converged"]:
        return "no convergence"
    steps = found["load steps"]
    return f"{found['iterations']}" + (f" ({steps})" if steps > 1 else "")


def _linear_solvers(sizes: list[int]) -> str:
    rows = [row for size in (min(sizes), max(sizes)) for row in linear_solvers.costs(size)]
    return "Sparse solvers on the stiffness of a dome\n" + _text(pd.DataFrame(rows), "{:.2g}")


def _beside_the_peer(checkout: Path, interpreter: Path) -> str:
    rows = pd.DataFrame(peer.costs(checkout, interpreter))
    title = "One Newton iteration beside dismech-python, CPU seconds, one thread, least of"
    return f"{title} {peer.REPEATS}\n" + _text(rows, "{:.4f}")


def _text(rows: pd.DataFrame, numbers: str = "{:.4g}") -> str:
    return rows.to_string(index=False, float_format=partial(str.format, numbers))
