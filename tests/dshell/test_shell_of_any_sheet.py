"""Sheets of any outline, pattern and number of layers, by the accurate shell."""

from dataclasses import replace

import numpy as np
import pytest
from released_sheets import CORNER, CUT_SHEETS, SOFT, STIFF, R, pile_of, sheet_of
from scipy.optimize import minimize

from bilayer import InputError, LinearElastic, PlanarMesh, generate_mesh, solve
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.layer import Layer, Response
from bilayer.specimen.outline import Ellipse, Polygon, Rectangle
from bilayer.specimen.pattern import Polygons
from dshell import HingeSettings, MorleySettings, PaperSettings
from dshell.models.masses import lumped_masses
from dshell.models.reference_surface import reference_surface_over

EXACT = MorleySettings(tolerance=1e-10)
THIN = 0.05 * R


def released(specimen, mesh=None, settings=EXACT):
    """Return the shape at the first milestone, after a check that it is there and stable."""
    result = solve(specimen, "dshell", settings, mesh=mesh)
    assert result.converged.values.all(), result.attrs["stop_reason"]
    assert result.unstable_modes.values.tolist() == [0]
    return result.position.values[0]


def distance(first, second, mesh):
    """Return the rms distance of two shapes, over the characteristic length."""
    areas = flat_surface(mesh).node_areas
    return rms_distance(first, second, areas) / np.sqrt(areas.sum() / np.pi)


def in_plane(points):
    return np.pad(points, ((0, 0), (0, 1)))


@pytest.mark.parametrize("kind", ["bilayer", "trilayer"])
@pytest.mark.parametrize("name", CUT_SHEETS)
def test_cut_sheets_rise_and_are_stable(name, kind):
    outline, pattern = CUT_SHEETS[name]
    sheet = sheet_of(outline, pile_of(kind, THIN, pattern))
    shape = released(sheet, settings=MorleySettings())
    assert np.ptp(shape[:, 2]) > 0.1 * R


@pytest.mark.parametrize("stretch", [(1.06, 1.06), (1.06, 1.02)], ids=str)
@pytest.mark.parametrize("outline", [Rectangle(R, R), Ellipse(R, 2 * R), CORNER], ids=repr)
def test_a_symmetric_trilayer_without_cuts_stays_flat_and_shrinks(outline, stretch):
    sheet = sheet_of(outline, pile_of("trilayer", outline.characteristic_length / 20), [stretch])
    mesh = generate_mesh(sheet)
    shape = released(sheet, mesh)
    expected = in_plane(mesh.points * free_stretches(sheet, stretch))
    assert distance(shape, expected, mesh) < 1e-3 * 0.05
    assert np.ptp(shape[:, 2]) < 1e-9 * outline.characteristic_length


def free_stretches(sheet, stretch):
    """Return the stretches along x and y at which the sum of all layers' energies is least.

    Each layer in plane stress: of its energy per natural volume, which is that as bonded, the
    least over the stretch of its thickness.
    """
    parts = sheet.bonded_layers(stretch)

    def energy(unknowns):
        (x, y), thickness = unknowns[:2], unknowns[2:]
        return sum(
            part.thickness * mooney_rivlin(part.layer.material, x * along[0], y * along[1], through)
            for part, along, through in zip(
                parts, (part.axial_stretch for part in parts), thickness, strict=True
            )
        )

    start = [1.0, 1.0, *(1 / part.determinant for part in parts)]
    scale = energy(start)
    least = minimize(lambda unknowns: energy(unknowns) / scale, start, tol=1e-12)
    return least.x[:2]


def mooney_rivlin(law, x, y, z):
    """Return the energy per natural volume at principal stretches, Pa."""
    squares, volume = np.square([x, y, z]), x * y * z
    first = volume ** (-2 / 3) * squares.sum()
    second = volume ** (2 / 3) * (1 / squares).sum()
    return law.c10 * (first - 3) + law.c01 * (second - 3) + (volume - 1) ** 2 / law.d1


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_a_single_layer_takes_back_its_stretch(angle):
    stretch, outline = (1.06, 1.02), Ellipse(R, 0.7 * R)
    layer = Layer("sheet", THIN, SOFT, response=Response("path", angle=angle))
    sheet = sheet_of(outline, (layer,), [stretch])
    mesh = generate_mesh(sheet)
    natural = mesh.points @ np.linalg.inv(layer.response.tensor(stretch))
    assert distance(released(sheet, mesh), in_plane(natural), mesh) < 1e-9


def test_a_layer_cut_in_two_through_its_thickness_is_the_same_layer():
    """Of the linear law, whose energy the Gauss points integrate exactly through the thickness."""
    laws = [LinearElastic(law.young_modulus, 0.45) for law in (SOFT, STIFF)]
    substrate, kirigami = (
        replace(layer, material=law)
        for layer, law in zip(pile_of("bilayer", THIN), laws, strict=True)
    )
    halves = [
        replace(kirigami, name=name, thickness=share * kirigami.thickness)
        for name, share in (("first", 0.3), ("second", 0.7))
    ]
    two = sheet_of(Rectangle(R, R), (substrate, kirigami), [(1.05, 1.02)])
    three = replace(two, layers=(substrate, *halves))
    mesh = generate_mesh(two)
    bond, middle = released(two, mesh), released(three, generate_mesh(three))
    height = two.bonded_layer("substrate", (1.05, 1.02)).thickness / 2
    top = reference_surface_over(middle, mesh.triangles, mesh.areas, height)
    assert np.ptp(bond[:, 2]) > 0.1 * R
    assert distance(top, bond, mesh) < 1e-9


@pytest.fixture(scope="module")
def lopsided():
    """Return a sheet without symmetry, its mesh and its shape."""
    sheet, _ = turned_sheet(0.0)
    mesh = generate_mesh(sheet)
    return sheet, mesh, released(sheet, mesh)


def turned_sheet(angle, mirrored=False):
    """Return a trilayer without symmetry, mirrored at the x axis and turned by an angle."""
    sign = -1 if mirrored else 1
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    corners = np.array(CORNER.points) * R * [1, sign] @ turn
    patch = np.array([(0.1, 0.2), (1.6, 0.3), (0.5, 1.7)]) * R * [1, sign] @ turn
    layers = (
        Layer("below", 0.2 * THIN, STIFF, pattern=Polygons((tuple(map(tuple, patch)),), "cut")),
        Layer("substrate", 0.4 * THIN, SOFT, response=Response("path", angle=sign * 0.3 + angle)),
        Layer(
            "above", 0.4 * THIN, STIFF,
            response=Response("fixed", stretch=(1.0, 0.99), angle=sign * 0.9 + angle),
        ),
    )  # fmt: skip
    return sheet_of(Polygon(tuple(map(tuple, corners))), layers, [(1.05, 1.02)]), turn


@pytest.mark.parametrize(("angle", "mirrored"), [(0.7, False), (0.0, True), (2.5, True)])
def test_a_turned_and_mirrored_sheet_takes_the_turned_and_mirrored_shape(lopsided, angle, mirrored):
    _, mesh, shape = lopsided
    moved, turn = turned_sheet(angle, mirrored)
    flip = [1, -1] if mirrored else [1, 1]
    order = [0, 2, 1] if mirrored else [0, 1, 2]
    moved_mesh = PlanarMesh(
        mesh.points * flip @ turn, mesh.triangles[:, order], mesh.region, mesh.layer_sets
    )
    moved_shape = released(moved, moved_mesh)
    assert np.ptp(shape[:, 2]) > 0.1 * R
    assert distance(moved_shape, shape * [*flip, 1], mesh) < 1e-9
    assert distance(moved_shape * [1, 1, -1], shape * [*flip, 1], mesh) > 0.01


def test_a_sheet_turned_over_takes_the_shape_turned_over(lopsided):
    sheet, mesh, shape = lopsided
    over = released(replace(sheet, layers=sheet.layers[::-1]), mesh)
    assert distance(over * [1, 1, -1], shape, mesh) < 1e-9


def test_the_two_shapes_of_a_cut_trilayer_are_mirror_images():
    outline, pattern = CUT_SHEETS["cross"]
    sheet = sheet_of(outline, pile_of("trilayer", THIN, pattern))
    mesh = generate_mesh(sheet)
    low, other = (
        released(sheet, mesh, replace(EXACT, branch=branch)) for branch in ("lowest", "other")
    )
    assert distance(low * [1, 1, -1], other, mesh) < 1e-6
    assert distance(low, other, mesh) > 0.01


def strip_of(x0, x1):
    return Polygons((((x0, -R), (x1, -R), (x1, R), (x0, R)),))


def test_where_the_carrier_is_cut_away_the_other_layers_carry():
    """The sheet is lap-jointed; each end is a single layer, free of strain."""
    layers = (
        Layer("left", THIN, SOFT, pattern=strip_of(-R, 0.3 * R), response=Response("path")),
        Layer("right", THIN, STIFF, pattern=strip_of(-0.1 * R, R)),
    )
    sheet = sheet_of(Rectangle(2 * R, R), layers, [(1.03, 1.03)], size=R / 10)
    mesh = generate_mesh(sheet)
    assert sheet.carrier.name == "left"
    assert len(mesh.faces_of("left")) < len(mesh.triangles)
    shape = released(sheet, mesh)
    assert edge_stretches(mesh, shape, mesh.points[:, 0] > 0.7 * R) == pytest.approx(1, abs=5e-3)
    far_left = edge_stretches(mesh, shape, mesh.points[:, 0] < -0.7 * R)
    assert far_left == pytest.approx(1 / 1.03, abs=5e-3)


def edge_stretches(mesh, shape, nodes):
    """Return the lengths of the edges between some nodes over those in the flat state."""
    edges = mesh.edges[nodes[mesh.edges].all(axis=1)]
    before, after = (
        np.linalg.norm(at[edges[:, 0]] - at[edges[:, 1]], axis=1) for at in (mesh.points, shape)
    )
    return after / before


def test_a_gap_between_two_layers_is_refused():
    lower, middle, upper = pile_of("trilayer", THIN)
    layers = (lower, replace(middle, pattern=strip_of(-R, 0.0)), upper)
    sheet = sheet_of(Rectangle(R, R), layers)
    with pytest.raises(InputError, match=r"layers\.substrate\.pattern: it is cut away between lo"):
        solve(sheet, "dshell", MorleySettings())


@pytest.mark.parametrize("settings", [HingeSettings(), PaperSettings()], ids=["hinge", "paper"])
def test_models_of_two_layers_refuse_three_in_one_line(settings):
    sheet = sheet_of(Rectangle(R, R), pile_of("trilayer", THIN))
    message = "model = '(hinge|paper)': takes two layers named substrate and kirigami, this"
    with pytest.raises(InputError, match=message) as caught:
        solve(sheet, "dshell", settings)
    assert "\n" not in str(caught.value)


def test_each_layer_has_its_own_mass():
    _, pattern = CUT_SHEETS["square"]
    densities = {"lower": 900.0, "substrate": 1000.0, "upper": 1300.0}
    sheet = sheet_of(Rectangle(R, R), pile_of("trilayer", THIN, pattern))
    for name, density in densities.items():
        sheet = sheet.with_layer(name, density=density)
    mesh = generate_mesh(sheet)
    expected = sum(
        layer.density * layer.thickness * mesh.areas[mesh.faces_of(layer.name)].sum() / thinned
        for layer, thinned in zip(sheet.layers, (1.0, 1.1 * 1.05, 1.0), strict=True)
    )
    assert lumped_masses(sheet, mesh, (1.1, 1.05)).sum() == pytest.approx(expected, rel=1e-12)
