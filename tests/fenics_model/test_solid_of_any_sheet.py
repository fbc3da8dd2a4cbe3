"""The solid of any sheet: one, two and three layers, patterns and stretches along any axes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

pytest.importorskip("dolfinx")

from bilayer import (
    InputError,
    Layer,
    MeshSize,
    MooneyRivlin,
    PlanarMesh,
    Polygon,
    Polygons,
    Prestretch,
    Rectangle,
    Response,
    Specimen,
    generate_mesh,
    paper_specimen,
    solve,
)
from bilayer.geometry.alignment import align
from bilayer.specimen.pattern import turned
from bilayer.specimen.settings import settings_to_toml
from fenics_model import SolidSettings
from fenics_model.release.specimen_solid import elements_through

TAPE, PAPER = MooneyRivlin(4839.1, 14536.0), MooneyRivlin(30749.0, 30749.0)
PATH = Response("path")
ACCURATE = SolidSettings(tolerance=1e-12)
SIDE = 0.04
SQUARE = Rectangle(SIDE, SIDE)
COARSE = MeshSize(0.01)


def released(specimen, mesh=None, settings=None, **options):
    return solve(specimen, "fenics", settings, mesh=mesh, start="flat", **options)


def apart(found, expected, length=SIDE):
    """Return the largest distance after alignment, over a length."""
    at_rest = align(found, expected, np.ones(len(expected)))
    return np.linalg.norm(at_rest - expected, axis=1).max() / length


def symmetric(stretch, thickness=5e-4, mesh=COARSE):
    """A stretched layer between two alike."""
    layers = [
        Layer("lower", thickness, PAPER),
        Layer("core", 2 * thickness, TAPE, response=PATH),
        Layer("upper", thickness, PAPER),
    ]
    return Specimen(SQUARE, layers, Prestretch([stretch]), mesh)


def laminate_stretch(specimen, stretch):
    """Return the in-plane stretch at which the layers, all stretched alike, are in balance."""

    def force(common):
        total = 0.0
        for part in specimen.bonded_layers((stretch, stretch)):
            own = common * part.stretch[0][0]
            law, natural = part.layer.material, part.layer.thickness / part.determinant
            # W = C10 (2 e^2 + e^-4 - 3) + C01 (e^4 + 2 e^-2 - 3) per natural volume
            slope = law.c10 * (4 * own - 4 * own**-5) + law.c01 * (4 * own**3 - 4 * own**-3)
            total += natural * slope * part.stretch[0][0]
        return total

    return brentq(force, 0.5, 1.0)


def test_a_symmetric_trilayer_stays_flat_and_shrinks_as_laminate_theory_says():
    specimen = symmetric(1.06, thickness=1.25e-4)
    mesh = generate_mesh(specimen)
    result = released(specimen, mesh)
    assert result["unstable_modes"].values.tolist() == [0]
    position = result["position"].values[0]
    assert np.ptp(position[:, 2]) < 1e-9 * SIDE
    inside = np.abs(mesh.points).max(axis=1) < 0.3 * SIDE  # away from the free edge
    flat = mesh.points[inside] - mesh.points[inside].mean(axis=0)
    moved = position[inside, :2] - position[inside, :2].mean(axis=0)
    stretches = np.linalg.svd(np.linalg.lstsq(flat, moved)[0])[1]
    expected = laminate_stretch(specimen, 1.06)
    assert expected < 0.99
    assert stretches == pytest.approx(expected, abs=1e-3 * (1 - expected))


def test_energies_and_volume_have_the_names_of_the_layers():
    result = released(symmetric(1.01))
    assert result["term"].values.tolist() == ["lower", "core", "upper"]
    lower, core, upper = result["energy"].values[0]
    assert lower == pytest.approx(upper, rel=1e-6)
    assert core > 0
    assert result["layer"].attrs["flag_meanings"] == "lower core upper"
    heights = result["volume_reference_position"].values[result["volume_cells"].values][:, :, 2]
    bounds = [(-1e-3, -5e-4), (-5e-4, 5e-4), (5e-4, 1e-3)]
    for number, (bottom, top) in enumerate(bounds):
        own = heights[result["layer"].values == number]
        assert (own.min(), own.max()) == pytest.approx((bottom, top))


@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_a_single_layer_shrinks_by_its_stretch(angle):
    """Without stress, along its own axes."""
    response = Response("path", angle=angle)
    layer = Layer("film", 1e-3, TAPE, response=response)
    specimen = Specimen(SQUARE, [layer], Prestretch([(1.2, 1.1)]), COARSE)
    result = released(specimen, settings=ACCURATE)
    shrunk = result["reference_position"].values.copy()
    shrunk[:, :2] = shrunk[:, :2] @ np.linalg.inv(response.tensor((1.2, 1.1)))
    assert apart(result["position"].values[0], shrunk) < 1e-9
    assert abs(float(result["energy"].sum())) < 1e-15


CORNERS = SIDE * np.array([(-0.5, -0.4), (0.4, -0.45), (0.55, 0.1), (0.1, 0.5), (-0.45, 0.3)])
"""Of a sheet without any symmetry."""
PATCH = SIDE * np.array([(-0.3, -0.25), (0.3, -0.25), (0.35, 0.1), (-0.1, 0.15)])


def uneven(transform=lambda points: points, sign=1, angle=0.0):
    """Three unlike layers stretched along three pairs of axes, all turned or mirrored."""
    lower, core, upper = (
        Response("fixed", (1.02, 1.0), angle=0.3 * sign + angle),
        Response("path", angle=0.9 * sign + angle),
        Response("path", factor=0.2, angle=angle),
    )
    patch = Polygons([transform(PATCH)])
    layers = [
        Layer("lower", 5e-4, PAPER, response=lower),
        Layer("core", 1e-3, TAPE, response=core),
        Layer("upper", 7e-4, PAPER, pattern=patch, response=upper),
    ]
    return Specimen(Polygon(transform(CORNERS)), layers, Prestretch([(1.05, 1.02)]), COARSE)


@pytest.fixture(scope="module")
def uneven_mesh():
    return generate_mesh(uneven())


@pytest.fixture(scope="module")
def uneven_shape(uneven_mesh):
    """Bent by more than its thickness."""
    shape = released(uneven(), uneven_mesh, ACCURATE)["position"].values[0]
    assert np.ptp(shape[:, 2]) > 2.2e-3
    return shape


def test_a_turned_sheet_takes_the_turned_shape(uneven_mesh, uneven_shape):
    def turn(points):
        return turned(points, 0.7)

    mesh = uneven_mesh.with_points(turn(uneven_mesh.points))
    found = released(uneven(turn, angle=0.7), mesh, ACCURATE)["position"].values[0]
    expected = np.column_stack([turn(uneven_shape[:, :2]), uneven_shape[:, 2]])
    assert apart(found, expected) < 1e-9


def test_a_mirrored_sheet_takes_the_mirrored_shape(uneven_mesh, uneven_shape):
    def mirror(points):
        return points * [1, -1]

    mesh = PlanarMesh(
        mirror(uneven_mesh.points),
        uneven_mesh.triangles[:, ::-1],
        uneven_mesh.region,
        uneven_mesh.layer_sets,
    )
    found = released(uneven(mirror, sign=-1), mesh, ACCURATE)["position"].values[0]
    assert apart(found, uneven_shape * [1, -1, 1]) < 1e-9


def test_the_shapes_of_the_other_start_lead_to_the_same(uneven_mesh, uneven_shape):
    """A result's own shapes, extruded through all layers, are nearly in balance."""
    first = released(uneven(), uneven_mesh, ACCURATE)
    again = solve(uneven(), "fenics", ACCURATE, mesh=uneven_mesh, start=first)
    assert again["guided_steps"].values.tolist() == [1]
    assert int(again["iterations"][0]) < int(first["iterations"][0])
    assert apart(again["position"].values[0], uneven_shape) < 1e-9


def test_two_layers_alike_are_one_of_their_thickness():
    """Through as many elements. Pressures of their own and one level's diagonals are new."""
    whole = [Layer("substrate", 1e-3, TAPE, response=PATH), Layer("upper", 1e-3, PAPER)]
    half = replace(whole[0], thickness=5e-4)
    halves = [half, replace(half, name="middle"), whole[1]]
    shapes = [
        released(Specimen(SQUARE, layers, Prestretch([1.03]), COARSE), settings=settings)
        for layers, settings in (
            (whole, SolidSettings(substrate_elements=4, elements=2)),
            (halves, SolidSettings(substrate_elements=2, elements=2)),
        )
    ]
    one, two = (shape["volume_position"].values[0] for shape in shapes)
    assert np.ptp(one[:, 2]) > 4e-3
    assert apart(two, one) < 5e-4
    energy = [shape["energy"].values[0].sum() for shape in shapes]
    assert energy[1] == pytest.approx(energy[0], rel=2e-4)


def test_a_layer_that_is_cut_away_between_two_is_refused():
    middle = Layer("middle", 5e-4, TAPE, pattern=Polygons([PATCH]))
    layers = [Layer("lower", 5e-4, PAPER), middle, Layer("upper", 5e-4, PAPER, response=PATH)]
    specimen = Specimen(SQUARE, layers, Prestretch([1.03]), COARSE)
    with pytest.raises(
        InputError, match=r"middle\.pattern: it is cut away between lower and upper"
    ):
        released(specimen)


@pytest.mark.mpi
def test_two_ranks_give_of_three_layers_what_one_gives():
    from mpi4py import MPI

    if MPI.COMM_WORLD.size == 1:
        pytest.skip("one rank: run under mpirun -n 2")
    shared = released(uneven())
    alone = released(uneven(), comm=MPI.COMM_SELF)
    for name in ("position", "volume_position"):
        assert shared[name].values == pytest.approx(alone[name].values, abs=1e-9)
    assert shared["iterations"].values == alone["iterations"].values


def test_elements_through_each_layer():
    """A level of the mesh is the reference surface: the core's middle, two layers' bond."""
    three = Specimen(SQUARE, symmetric(1.03).layers, Prestretch([1.03]), COARSE)
    asked = SolidSettings(elements=3)
    assert [elements_through(name, three, asked) for name in three.layer_names] == [3, 4, 3]
    default = SolidSettings()
    assert [elements_through(name, three, default) for name in three.layer_names] == [1, 2, 1]
    two, odd = (
        paper_specimen(),
        SolidSettings(substrate_elements=3, kirigami_elements=2, elements=5),
    )
    assert [elements_through(name, two, odd) for name in two.layer_names] == [3, 2]
    with pytest.raises(InputError, match=r"solver\.elements = 0"):
        SolidSettings(elements=0)


def test_settings_that_do_not_ask_for_other_layers_are_the_text_of_before():
    """Studies know their cases by it."""
    names = [line.split(" = ")[0] for line in settings_to_toml(SolidSettings()).splitlines()]
    assert "substrate_elements" in names
    assert "elements" not in names
