"""A run of several milestones that is killed: `python3 killed_run.py OUTPUT LOG`, on any ranks.

It goes on from the output if there is one. Every rank notes in a log of its own (LOG.RANK) its
process, and each milestone once it is kept.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

from bilayer import MeshSize, paper_specimen, solve

MILESTONES = [1.005, 1.01, 1.015, 1.01, 1.005, (1.015, 1.01), 1.02]
"""Up, down again, and up by another way."""

SPECIMEN = replace(paper_specimen(), mesh=MeshSize(0.016)).with_milestones(MILESTONES)


def compute(output: Path | None, log: Path | None):
    """Solve into a file, with the shell's shapes."""

    def note(step):
        if step.is_at_target and log is not None:
            with log.open("a") as lines:
                lines.write(f"{step.index}\n")

    resume = output if output is not None and output.exists() else None
    return solve(SPECIMEN, "fenics", observers=[note], output=output, resume=resume)


def run() -> None:
    from mpi4py import MPI

    log = Path(f"{sys.argv[2]}.{MPI.COMM_WORLD.rank}")
    log.write_text(f"{os.getpid()}\n")
    compute(Path(sys.argv[1]), log)


if __name__ == "__main__":
    run()
