"""A law that the packages do not know, one class, in a specimen file and in both solvers."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

pytest.importorskip("dolfinx")

from bilayer import (
    Hyperelastic,
    compare,
    generate_mesh,
    parse_specimen,
    register_law,
    solve,
    specimen_to_toml,
)
from bilayer.specimen.materials import LAWS
from bilayer.specimen.toml import template


@dataclass(frozen=True)
class Exponential(Hyperelastic):
    """Demiray (1972): w = mu / 2b (exp(b (I1 - 3)) - 1)."""

    mu: float
    b: float
    d1: float = 0.0
    name: ClassVar[str] = "exponential"
    units: ClassVar[dict[str, str]] = {"mu": "Pa", "b": "", "d1": "1/Pa"}

    def energy(self, I1, I2, functions):
        return self.mu / (2 * self.b) * (functions.exp(self.b * (I1 - 3)) - 1)


@pytest.fixture
def specimen():
    """The paper's with this law in both layers."""
    text = template()
    for layer, mu in {"substrate": "39 kPa", "kirigami": "123 kPa"}.items():
        before, after = text.split(f"[{layer}]")
        mine, *rest = after.split("\n\n")
        kept = [line for line in mine.splitlines() if line.startswith(("thickness", "side"))]
        law = f'law = "exponential"\nmu = "{mu}"\nb = 0.5\nd1 = "1e-6 1/Pa"'
        text = "\n\n".join(["\n".join([f"{before}[{layer}]", *kept, law]), *rest])
    try:
        register_law(Exponential)
        yield parse_specimen(text, ["mesh.size=0.005", "prestretch.milestones=[1.12]"])
    finally:
        del LAWS["exponential"]


def test_a_law_of_ones_own_is_solved_by_both_solvers(specimen):
    assert specimen.layer("kirigami").material == Exponential(123_000.0, 0.5, 1e-6)
    assert parse_specimen(specimen_to_toml(specimen)) == specimen
    mesh = generate_mesh(specimen)
    shell = solve(specimen, "dshell", mesh=mesh)
    solid = solve(specimen, "fenics", mesh=mesh, start=shell)
    assert (shell.unstable_modes.values == 0).all()
    assert (solid.unstable_modes.values == 0).all()
    assert float(compare(solid, shell)["rms_distance_over_radius"][0]) < 0.005
