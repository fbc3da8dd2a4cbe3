"""The change of the paper's shapes with the split C01 / C10 of the layers' constants.

The moduli stay those of the template; only the ratios change: as assumed there, of the kirigami
layer as in the same lab's bistable sheets, of both layers as there, and without C01.

    scripts/env python3 scripts/kirigami_split.py

It takes half a minute and prints the table of docs/materials.md.
"""

from dataclasses import dataclass, replace

import bilayer

STRETCHES = (1.06, 1.15, 1.24)
ASSUMED, SUBSTRATE_OF_SHEETS, KIRIGAMI_OF_SHEETS = 3.004, 1.656 / 22.06, 84.45 / 17.88


@dataclass(frozen=True)
class Case:
    """Ratios C01 / C10 of the two layers."""

    substrate: float
    kirigami: float


CASES = (
    Case(ASSUMED, ASSUMED),
    Case(ASSUMED, KIRIGAMI_OF_SHEETS),
    Case(SUBSTRATE_OF_SHEETS, KIRIGAMI_OF_SHEETS),
    Case(ASSUMED, 0.0),
)
"""The first is the template."""


def shapes(case: Case, mesh_size: float) -> list[tuple[float, float]]:
    """Return height and radius of the best sphere at each stretch, m, by the accurate shell."""
    specimen = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(mesh_size))
    specimen = specimen.with_milestones(STRETCHES)
    for name, ratio in vars(case).items():
        law = specimen.layer(name).material
        split = bilayer.MooneyRivlin.from_moduli(law.young_modulus, law.poisson_ratio, ratio)
        specimen = specimen.with_layer(name, material=split)
    result = bilayer.solve(specimen, "dshell")
    if not result["converged"].values.all() or result["unstable_modes"].values.any():
        raise bilayer.ComputationError(f"{case}: not every shape is stable")
    height, radius = result["height"].values, result["sphere_radius"].values
    return list(zip(height.tolist(), radius.tolist(), strict=True))


def main(mesh_size: float = 0.003) -> None:
    """Print the table, of meshes of some size, m."""
    found = [shapes(case, mesh_size) for case in CASES]
    columns = [f"{name} at {s:g}" for s in STRETCHES for name in ("height", "radius")]
    print("| C01/C10 substrate | kirigami |", " | ".join(columns), "|")
    print("|---" * (2 + len(columns)) + "|")
    for case, numbers in zip(CASES, found, strict=True):
        cells = [f"{case.substrate:.4g}", f"{case.kirigami:.4g}"]
        for now, template in zip(numbers, found[0], strict=True):
            for value, reference in zip(now, template, strict=True):
                moved = "" if now is template else f" ({100 * (value / reference - 1):+.1f} %)"
                cells.append(f"{1e3 * value:.2f}{moved}")
        print("|", " | ".join(cells), "|")


if __name__ == "__main__":
    main()
