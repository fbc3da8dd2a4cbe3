"""The deformation of a solid's layers: uniform states, the element's rate, energies, ranks."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from dataclasses import astuple

from verification.solid_fields import bent_stress_rate, energy_error, uniform_errors


@pytest.mark.mpi
@pytest.mark.parametrize("elements", [1, 2, 3])
def test_a_uniform_state(elements):
    assert max(astuple(uniform_errors(elements))) < 1e-8


@pytest.mark.mpi
def test_stresses_converge_at_the_elements_rate():
    assert bent_stress_rate() > 1.8


@pytest.mark.mpi
def test_energies_add_up():
    assert energy_error() < 1e-10


def test_fields_of_a_released_solid(paper_6mm, paper_6mm_solid):
    """Computed from the result; the shell's are near: stress of the kirigami to a quarter."""
    import bilayer

    fields = bilayer.fields(paper_6mm_solid.isel(prestretch=[0]))
    assert float(fields["found_again"].max()) < 1e-6
    held = (fields["energy_density"] * fields["natural_volume"]).sum("face").values
    energies = paper_6mm_solid["energy"].values[:1]
    assert held == pytest.approx(energies, rel=1e-6)
    assert held.sum() == pytest.approx(energies.sum(), rel=1e-10)
    mesh = bilayer.result_mesh(paper_6mm_solid)
    shell = bilayer.fields(bilayer.solve(paper_6mm.with_milestones([1.03]), "dshell", mesh=mesh))
    assert list(shell.data_vars) == list(fields.data_vars)
    own, other = (
        f["cauchy_stress"].sel(sheet_layer="kirigami", level="middle").values
        for f in (fields, shell)
    )
    apart = np.sqrt(np.nanmean((own - other) ** 2))
    assert apart < 0.25 * np.sqrt(np.nanmean(own**2))
