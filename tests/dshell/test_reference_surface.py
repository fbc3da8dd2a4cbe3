import numpy as np
import pytest

from dshell.models.reference_surface import reference_surface_over


def test_flat_midplane_lies_half_a_thickness_below_the_bond(coarse_mesh):
    flat = np.column_stack([coarse_mesh.points, np.full(len(coarse_mesh.points), -0.5e-3)])
    bond = reference_surface_over(flat, coarse_mesh.triangles, coarse_mesh.areas, 0.5e-3)
    assert bond[:, :2] == pytest.approx(coarse_mesh.points)
    assert bond[:, 2] == pytest.approx(0.0, abs=1e-15)


def test_a_shrunk_sheet_is_thicker_by_its_area(coarse_mesh):
    shrunk = 0.8 * np.column_stack([coarse_mesh.points, np.zeros(len(coarse_mesh.points))])
    bond = reference_surface_over(shrunk, coarse_mesh.triangles, coarse_mesh.areas, 0.5e-3)
    assert bond[:, 2] == pytest.approx(0.5e-3 / 0.64)


def test_the_bond_lies_outside_a_dome(coarse_mesh):
    x, y = coarse_mesh.points.T
    radius = 1.0
    dome = np.column_stack([x, y, np.sqrt(radius**2 - x**2 - y**2)])
    bond = reference_surface_over(dome, coarse_mesh.triangles, coarse_mesh.areas, 0.5e-3)
    assert np.linalg.norm(bond, axis=1) == pytest.approx(radius + 0.5e-3, abs=2e-6)
