"""Two revisions side by side: this checkout, and an earlier commit in a worktree of its own.

Both run the same computations (`benchmarks.compared_cases`) with one interpreter and one set of
libraries, in turns, each time in a new process. Ratios are taken within a turn, so that what else
the machine does falls on both sides.
"""

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.compared_cases import CASES
from benchmarks.page import table_text
from bilayer.errors import ComputationError, InputError
from bilayer.runtime.output_file import whole_file

DESCRIPTION = "an earlier revision and this checkout, in turns: CPU time, iterations, memory"
EXAMPLES = """\
  scripts/benchmark compare HEAD~5 shell study
  scripts/benchmark compare v0.1 --turns 7 --write      # and results/benchmarks, docs

cases:
""" + "\n".join(f"  {name:14} {case.text}" for name, case in CASES.items())
CHECKOUT = Path(__file__).parents[2]
KEPT = CHECKOUT / "results" / "benchmarks"
TURNS = 3


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the revision, the cases and the number of turns."""
    parser.add_argument("revision", metavar="REV", help="a commit, as git names it")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="see below; all if left out")
    parser.add_argument(
        "--turns", type=int, default=TURNS, metavar="N",
        help=f"runs of each revision; {TURNS} if left out",
    )  # fmt: skip


def tables(options: argparse.Namespace) -> Iterator[str]:
    """Yield the table of each case, and keep the numbers if asked to; then all that are kept."""
    names = options.cases or list(CASES)
    for name in names:
        if name not in CASES:
            raise InputError(f"CASE {name}: expected one of {', '.join(CASES)}")
    if options.turns < 1:
        raise InputError(f"--turns = {options.turns}: expected at least 1")
    with worktree_of(options.revision) as earlier:
        found = []
        for name in names:
            print(f"{name}: {CASES[name].text}", file=sys.stderr, flush=True)
            found.append(compared(name, earlier, options.turns))
    if options.write:
        found = keep(found)
    yield table(found)


@contextmanager
def worktree_of(revision: str) -> Iterator[Path]:
    """Give a checkout of a revision until the end of the block; InputError if there is none."""
    try:
        commit = _git("rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
    except subprocess.CalledProcessError:
        raise InputError(f"REV = {revision}: expected a commit of this repository") from None
    with tempfile.TemporaryDirectory(prefix="bilayer-earlier-") as name:
        folder = Path(name, "checkout")
        _git("worktree", "add", "--quiet", "--detach", str(folder), commit)
        try:
            yield folder
        finally:
            _git("worktree", "remove", "--force", str(folder))


@dataclass(frozen=True)
class Comparison:
    """One case on two revisions, a cost per turn of each as `Cost` in a dictionary.

    Parameters
    ----------
    case : str
        Its name in `CASES`.
    revision, earlier_revision : str
        Commits; "-dirty" if files differ from them.
    now, earlier : list of dict
        In the order of the turns.
    """

    case: str
    revision: str
    earlier_revision: str
    now: list[dict[str, Any]]
    earlier: list[dict[str, Any]]

    def ratios(self, quantity: str) -> list[float]:
        """Return the quantity now over that of the earlier revision, in each turn."""
        return [
            now[quantity] / before[quantity]
            for now, before in zip(self.now, self.earlier, strict=True)
        ]

    def largest_difference(self) -> float | None:
        """Return the largest relative difference of a result's numbers; None without numbers."""
        now, before = (np.array(side[0]["numbers"]) for side in (self.now, self.earlier))
        if len(now) != len(before):
            raise ComputationError(f"{self.case}: results of {len(before)} and {len(now)} numbers")
        scale = np.where(before == 0, 1.0, np.abs(before))
        return float((np.abs(now - before) / scale).max()) if len(now) else None


def compared(name: str, earlier: Path, turns: int) -> Comparison:
    """Run a case on both revisions; which comes first changes with each turn."""
    costs: dict[Path, list[dict[str, Any]]] = {CHECKOUT: [], earlier: []}
    for turn in range(turns):
        for checkout in (CHECKOUT, earlier) if turn % 2 else (earlier, CHECKOUT):
            costs[checkout].append(cost_of(name, checkout))
    return Comparison(
        name, revision_of(CHECKOUT), revision_of(earlier), costs[CHECKOUT], costs[earlier]
    )


def cost_of(name: str, checkout: Path) -> dict[str, Any]:
    """Return the cost of a case by a checkout, in a new process."""
    paths = os.pathsep.join([str(checkout), str(CHECKOUT / "scripts")])
    command = [sys.executable, "-P", "-m", "benchmarks.one_run", name]
    done = subprocess.run(
        command,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise ComputationError(f"{name} on {revision_of(checkout)}: {last[0]}")
    cost: dict[str, Any] = json.loads(done.stdout)
    return cost


def table(found: Sequence[Comparison]) -> str:
    """Return the comparisons as text, a row each."""
    rows = [
        {
            "what": CASES[one.case].text,
            "against": one.earlier_revision,
            "CPU s": f"{_middle(one.earlier, 'cpu'):.2f}→{_middle(one.now, 'cpu'):.2f}",
            "ratio": _spread(one.ratios("cpu")),
            "iterations": _counts(one, "iterations"),
            "factori- sations": _counts(one, "factorisations"),
            "GB": f"{_middle(one.earlier, 'gigabytes'):.2f}→{_middle(one.now, 'gigabytes'):.2f}",
            "apart": _power(one.largest_difference()),
        }
        for one in found
    ]
    title = (
        "The earlier revision → this one; ratio of the CPU time (least, most), and how far results "
        "are apart"
    )
    return f"{title}\n{table_text(rows)}"


def keep(found: Sequence[Comparison], folder: Path = KEPT) -> list[Comparison]:
    """Write comparisons into this machine's file; return all that it has, of cases still known."""
    path = folder / f"{machine_name()}.json"
    kept = json.loads(path.read_text(encoding="utf-8"))["comparisons"] if path.exists() else []
    every = {(one["case"], one["earlier_revision"]): Comparison(**one) for one in kept}
    every |= {(one.case, one.earlier_revision): one for one in found}
    known = [one for name in CASES for one in every.values() if one.case == name]
    path.parent.mkdir(exist_ok=True)
    document = {"machine": machine(), "comparisons": [vars(_rounded(one)) for one in known]}
    with whole_file(path, "comparisons") as partial:
        partial.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return known


def machine() -> dict[str, Any]:
    """Return what the numbers depend on: processor, memory, libraries."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_GB": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9),
        "system": platform.freedesktop_os_release().get("PRETTY_NAME", platform.system()),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "threads": os.environ.get("OMP_NUM_THREADS", ""),
    }


def machine_name() -> str:
    """Return a name for files: processor and cores."""
    words = re.sub(r"[^a-z0-9]+", "-", _processor().lower()).strip("-")
    return f"{words}-{os.cpu_count()}-cores"


def revision_of(checkout: Path) -> str:
    """Return the short commit of a checkout, with "-dirty" if tracked files have been changed."""
    commit = _git("rev-parse", "--short", "HEAD", at=checkout)
    changed = _git(
        "status", "--porcelain", "--untracked-files=no", ":!results", ":!docs", at=checkout
    )
    return f"{commit}-dirty" if changed else commit


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _git(*words: str, at: Path = CHECKOUT) -> str:
    command = ["git", "-C", str(at), *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def _rounded(one: Comparison) -> Comparison:
    """Return it without the numbers of all turns but the first: they are the same."""
    sides = (
        [cost | {"numbers": cost["numbers"] if turn == 0 else []} for turn, cost in enumerate(side)]
        for side in (one.now, one.earlier)
    )
    return Comparison(one.case, one.revision, one.earlier_revision, *sides)


def _middle(costs: Sequence[dict[str, Any]], quantity: str) -> float:
    return statistics.median(cost[quantity] for cost in costs)


def _spread(ratios: Sequence[float]) -> str:
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f}, {max(ratios):.2f})"


def _counts(one: Comparison, quantity: str) -> str:
    before, now = one.earlier[0][quantity], one.now[0][quantity]
    return "" if before is None or now is None else f"{before}→{now}"


def _power(difference: float | None) -> str:
    return "" if difference is None else f"{difference:.0e}"
