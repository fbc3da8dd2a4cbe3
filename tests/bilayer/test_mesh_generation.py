"""Meshes by gmsh: the cuts are in them, sizes are kept, every pattern works."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bilayer import CutPattern, InputError, MeshSize, generate_mesh, paper_specimen
from bilayer.mesh.generation import estimated_triangles, mesh_within_memory

PATTERNS = [
    None,
    CutPattern(1, 0.008, 5.0),
    CutPattern(2, 0.01, 0.2),
    CutPattern(3, 0.008, 2.0),
    CutPattern(5, 0.008, 0.3),
    CutPattern(7, 0.02, 0.1),
    CutPattern(12, 0.03, 0.5),
]


def specimen_with(cut, size=0.004, corner_size=None):
    specimen = replace(paper_specimen(), mesh=MeshSize(size, corner_size))
    return specimen.with_layer("kirigami", pattern=cut)


@pytest.mark.parametrize("cut", PATTERNS, ids=str)
def test_regions_have_the_drawn_areas(cut):
    """Polygons inside circles: areas are short by the arcs' sagittae only."""
    mesh = generate_mesh(specimen_with(cut, 0.002))
    disc = math.pi * 0.04**2
    bare = (
        0.0 if cut is None else cut.strips * cut.cutout_angle / 2 * (0.04**2 - cut.inner_radius**2)
    )
    assert mesh.areas.sum() == pytest.approx(disc, rel=1e-3)
    assert mesh.areas[mesh.region == 0].sum() == pytest.approx(bare, rel=4e-3, abs=1e-12)


@pytest.mark.parametrize("cut", PATTERNS[1:], ids=str)
def test_no_triangle_crosses_a_cut(cut):
    """Each triangle lies wholly on its side: its centroid's polar angle tells the region."""
    mesh = generate_mesh(specimen_with(cut))
    corners = mesh.points[mesh.triangles]
    angle = np.arctan2(*np.moveaxis(corners, -1, 0)[::-1]) % (2 * math.pi)
    offset = np.abs((angle[..., None] - cut.cutout_centres + math.pi) % (2 * math.pi) - math.pi)
    in_sector = (offset <= cut.cutout_angle / 2 + 1e-9).any(axis=-1)
    # chords of the inner arc lie a sagitta inside the inner radius
    outside = np.linalg.norm(corners, axis=-1) >= cut.inner_radius * (1 - 1e-9)
    assert (in_sector & outside)[mesh.region == 0].all()


def test_the_centre_is_a_node_and_the_rim_a_circle():
    for cut in PATTERNS:
        mesh = generate_mesh(specimen_with(cut))
        assert np.linalg.norm(mesh.points[mesh.centre_node]) < 1e-12
        assert np.allclose(np.linalg.norm(mesh.points[mesh.rim_nodes], axis=1), 0.04, rtol=1e-9)


def test_the_same_specimen_gives_the_same_mesh():
    assert generate_mesh(paper_specimen()).same_as(generate_mesh(paper_specimen()))


def test_sizes_are_kept():
    cut = CutPattern(5, 0.008, 0.3)
    coarse = generate_mesh(specimen_with(cut, 0.004))
    fine = generate_mesh(specimen_with(cut, 0.002))
    corners = generate_mesh(specimen_with(cut, 0.004, 0.0005))

    def shortest_near_corner(mesh):
        ends = mesh.points[mesh.edges]
        near = np.abs(np.linalg.norm(ends.mean(axis=1), axis=1) - cut.inner_radius) < 5e-4
        return np.linalg.norm(ends[near, 1] - ends[near, 0], axis=1).min()

    assert 3.0 < len(fine.triangles) / len(coarse.triangles) < 5.0
    assert shortest_near_corner(corners) < 0.0006 < shortest_near_corner(coarse)
    assert len(corners.triangles) > 1.5 * len(coarse.triangles)


@pytest.mark.parametrize("size", [0.003, 0.0015])
def test_the_estimate_is_good_enough_for_memory(size):
    specimen = specimen_with(CutPattern(5, 0.008, 0.3), size)
    assert len(generate_mesh(specimen).triangles) == pytest.approx(
        estimated_triangles(specimen), rel=0.15
    )


@pytest.mark.parametrize("angle", [0.001, 0.01])
@pytest.mark.parametrize("corner_size", [None, 0.0005])
def test_many_narrow_sectors_are_counted(angle, corner_size):
    """Strips and cutouts narrower than the mesh size take triangles all the same."""
    specimen = specimen_with(CutPattern(500, 0.008, angle), 0.004, corner_size)
    count = len(generate_mesh(specimen).triangles)
    assert count > 16_000
    assert count == pytest.approx(estimated_triangles(specimen), rel=0.15)


def test_a_given_mesh_beyond_the_memory_is_refused_with_its_triangles():
    specimen = specimen_with(None, 0.01)
    mesh = generate_mesh(specimen)
    assert mesh_within_memory(specimen, mesh, 1.0, "the solver") is mesh
    message = rf"mesh: its {len(mesh.triangles)} triangles would take .* GiB for the solver"
    with pytest.raises(InputError, match=message):
        mesh_within_memory(specimen, mesh, 1e13, "the solver")


def test_a_mesh_beyond_the_memory_is_refused_with_its_size():
    with pytest.raises(InputError, match=r"mesh.size = 1e-07 m: about .* GiB for the mesh"):
        generate_mesh(specimen_with(None, 1e-7))
