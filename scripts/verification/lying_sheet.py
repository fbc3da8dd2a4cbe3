"""A sheet that lies on a table under its weight: examples/on_a_table.toml on a coarse mesh."""

import math
from collections.abc import Iterator
from pathlib import Path

from bilayer import generate_mesh, read_specimen, solve
from verification.rung import Check

EXAMPLE = Path(__file__).parents[2] / "examples" / "on_a_table.toml"
STRETCH = 1.02


def lying_sheet(solver: str, settings: object, balance: float) -> Iterator[Check]:
    """Checks of the force of the table, and of what the sheet stands on."""
    sheet = read_specimen(EXAMPLE, ["mesh.size='8 mm'", f"prestretch.milestones=[{STRETCH}]"])
    mesh = generate_mesh(sheet)
    result = solve(sheet, solver, settings, mesh=mesh)
    stretched, other = sheet.layers  # of what is stretched there is less on the same area
    masses = stretched.density * stretched.thickness / STRETCH**2 + other.density * other.thickness
    weight = sheet.gravity * mesh.areas.sum() * masses
    apart = abs(float(result["contact_force"].values[0]) / weight - 1)
    yield Check("table's force less weight / weight", apart, 0.0, balance, 1.0)
    yield Check("unstable modes", float(result["unstable_modes"].values[0]), 0.0, 0.0, 1.0)
    crosses = float(result["contact_crosses"].values[0])
    yield Check("places inside the table", crosses, 0.0, 0.0, 1.0)
    yield Check("smallest gap / range", float(result["contact_gap"].values[0]) / 1e-4, math.nan)
