"""Quadratic cells on a planar mesh, and the layers drawn on them."""

import numpy as np
import pytest
from hexagon import hexagon_mesh
from made_results import small_specimen

from bilayer import InputError, LinearElastic, generate_mesh
from bilayer.calculix.drawn_layer import draw_layer
from bilayer.calculix.quadratic_mesh import ELEMENTS, quadratic_mesh
from bilayer.specimen.two_layers import BARE, KIRIGAMI

EDGES = {
    15: [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    20: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4),
         (0, 4), (1, 5), (2, 6), (3, 7)],
}  # fmt: skip
"""Ends of the edges whose midpoints follow the corners, as the manuals number them."""


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(small_specimen())


def areas(points, cells):
    corners = points[cells[:, : cells.shape[1] // 2]]
    after = np.roll(corners, -1, axis=1)
    return (corners[..., 0] * after[..., 1] - corners[..., 1] * after[..., 0]).sum(axis=1) / 2


@pytest.mark.parametrize("element", ELEMENTS)
def test_cells_cover_each_region_once(mesh, element):
    quadratic = quadratic_mesh(mesh, element)
    assert np.array_equal(quadratic.points[: quadratic.vertices], mesh.points)
    for region in (BARE, KIRIGAMI):
        found = np.concatenate(
            [areas(quadratic.points, cells) for cells in quadratic.cells[region]]
        )
        assert found.min() > 0
        assert found.sum() == pytest.approx(mesh.areas[mesh.region == region].sum())


def test_most_triangles_find_a_partner(mesh):
    cells = quadratic_mesh(mesh, "hexahedron").cells
    triangles, quadrilaterals = (sum(len(cells[r][k]) for r in (BARE, KIRIGAMI)) for k in (0, 1))
    assert triangles + 2 * quadrilaterals == len(mesh.triangles)
    assert triangles < len(mesh.triangles) / 4


def test_neighbouring_cells_share_the_node_on_their_edge(mesh):
    quadratic = quadratic_mesh(mesh, "hexahedron")
    assert len(np.unique(quadratic.points.round(12), axis=0)) == len(quadratic.points)


def test_an_unknown_element_is_named():
    with pytest.raises(InputError, match="element = 'tetrahedron'"):
        quadratic_mesh(hexagon_mesh(), "tetrahedron")


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("name", ["substrate", "kirigami"])
def test_elements_are_numbered_as_abaqus_does(mesh, element, name):
    stretch = (1.2, 1.1)
    bonded = small_specimen().bonded_layer(name, stretch)
    scale = bonded.layer.material.natural_scale(bonded.axial_stretch)
    drawn = draw_layer(quadratic_mesh(mesh, element), bonded, scale)
    for elements in (drawn.wedges, drawn.hexahedra):
        corners = {15: 6, 20: 8}[elements.shape[1]]
        x = drawn.points[elements]
        for k, (a, b) in enumerate(EDGES[elements.shape[1]], start=corners):
            assert x[:, k] == pytest.approx((x[:, a] + x[:, b]) / 2, abs=1e-15)
        sides = x[:, [1, corners // 2 - 1, corners // 2]] - x[:, :1]
        assert (np.linalg.det(sides) > 0).all()


def test_a_hyperelastic_layer_keeps_its_volume():
    material = small_specimen().layer("substrate").material
    assert np.prod(material.natural_scale((1.2, 1.1))) == pytest.approx(1)


def test_the_first_nodes_are_the_interface_over_the_planar_nodes(mesh):
    specimen, stretch = small_specimen(), (1.2, 1.1)
    bonded = specimen.bonded_layer("substrate", stretch)
    scale = bonded.layer.material.natural_scale(stretch)
    drawn = draw_layer(quadratic_mesh(mesh), bonded, scale)
    first = drawn.points[: len(mesh.points)]
    assert first == pytest.approx(np.column_stack([mesh.points / stretch, 0 * mesh.points[:, 0]]))
    natural = specimen.layer("substrate").thickness
    assert np.ptp(drawn.points[:, 2]) == pytest.approx(natural)


def test_the_linear_law_is_free_of_stress_where_it_is_drawn():
    nu, stretch = 0.4, (1.2, 1.1)
    scale = np.array(LinearElastic(1e5, nu).natural_scale(stretch))
    initial = np.array([0.2, 0.1, -nu / (1 - nu) * 0.3])
    assert (scale**2 - 1) / 2 + initial == pytest.approx(0, abs=1e-14)


def test_a_linear_law_stretched_too_far_has_no_natural_state():
    with pytest.raises(InputError, match=r"prestretch.milestones = 1.5.*expected less than 1.5"):
        LinearElastic(1e5, 0.4).natural_scale((1.5, 1.0))
