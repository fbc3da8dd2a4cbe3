"""What designs reach by the finite-element model, a row of a table each.

A design that is finished is read from its folder; one that is not goes on.
"""

import argparse

import numpy as np

import bilayer
from bilayer.designing.height_image import similarity
from bilayer.designing.run import DesignOutcome
from bilayer.mesh.planar import flat_surface

HEADS = (
    "target", "shapes by shell, FE", "mean (% of diagonal)", "largest (%)",
    "SSIM, of a cap, flat", "HD", "quality", "gap (mm)", "unstable modes", "triangles",
)  # fmt: skip


def row(outcome: DesignOutcome) -> str:
    """Return the row of a design; its last check's numbers."""
    task = outcome.task
    solves = f"{outcome.solves}, {outcome.solves_by_elements}"
    if not outcome.checks:
        return f"| {task.target.words} | {solves} | {outcome.check_failure or 'not checked'} |"
    last = outcome.checks[-1]
    seen = similarity(task.target.surface, last.surface, flat_surface(outcome.mesh))
    shares = [100 * length / task.target.diagonal for length in
              (last.distance.mean, last.distance.largest)]  # fmt: skip
    cells = (
        task.target.words,
        solves,
        f"{shares[0]:.2f}",
        f"{shares[1]:.1f}",
        f"{seen.shape:.2f}, {seen.plain_cap:.2f}, {seen.flat:.2f}",
        f"{last.hemisphere_distance:.3f}",
        f"{last.quality:.3f}",
        "far" if np.isinf(last.gap) else f"{1e3 * last.gap:.2g}",
        f"{last.unstable_modes}",
        f"{len(last.mesh.triangles)}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pairs", nargs="+", metavar="FILE.toml FOLDER", help="designs")
    given = parser.parse_args().pairs
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    for file, folder in zip(given[::2], given[1::2], strict=True):
        print(row(bilayer.design(file, folder)), flush=True)


if __name__ == "__main__":
    main()
