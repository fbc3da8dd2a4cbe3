"""A run of eight milestones that is killed: what the processes of the tests do."""

import time
from dataclasses import replace
from pathlib import Path

from bilayer import MeshSize, MorleySettings, paper_specimen, solve

MILESTONES = [1.01, 1.02, 1.03, 1.04, 1.03, 1.02, (1.04, 1.03), 1.05]
"""Up, down again, and up by another way."""


def specimen():
    return replace(paper_specimen(), mesh=MeshSize(0.012)).with_milestones(MILESTONES)


def noting(log):
    """Return an observer that notes each milestone in a file, once it is kept."""

    def note(step):
        if step.is_at_target:
            with log.open("a") as lines:
                lines.write(f"{step.index} {time.monotonic()}\n")

    return note


def compute(output, log, resume):
    """Solve into a file; the log has the moment of the beginning and of each milestone."""
    with log.open("a") as lines:
        lines.write(f"begun {time.monotonic()}\n")
    solve(
        specimen(), "dshell", MorleySettings(), observers=[noting(log)], output=output,
        resume=output if resume else None,
    )  # fmt: skip


def noted(log: Path):
    """Return the numbers of the milestones in a log."""
    if not log.exists():
        return []
    words = [line.split() for line in log.read_text().splitlines()]
    return [int(number) for number, _ in words if number != "begun"]
