"""A fine mesh that starts from a coarse one's shape ends where it would from flat."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from released_sheets import CORNER, CUT_SHEETS, R, pile_of, sheet_of

from bilayer import InputError, MeshSize, generate_mesh, solve
from bilayer.errors import ComputationError
from bilayer.measures.milestone import measure
from bilayer.solvers import recording
from bilayer.solvers.run import solve_with
from bilayer.specimen.outline import Disc, Ellipse, Polygon, Rectangle
from dshell import SOLVER, HingeSettings, MorleySettings
from dshell.release.coarse_start import coarse_mesh, prolong_shape
from dshell.release.opening import CoarseStart, open_shell_path
from dshell.release.specimen_path import ShellPath

COARSE = 120
KINDS = pytest.mark.parametrize("kind", [MorleySettings, HingeSettings])


@pytest.fixture(scope="module")
def fine_specimen(coarse_specimen):
    return replace(coarse_specimen, mesh=MeshSize(0.0045)).with_milestones([1.06])


@pytest.fixture(scope="module")
def fine_mesh(fine_specimen):
    return generate_mesh(fine_specimen)


@pytest.fixture(scope="module")
def released(fine_specimen, fine_mesh):
    """Return the fine result of a model, from flat or from a coarse mesh, computed once."""

    @functools.cache
    def release(kind, coarse_triangles):
        settings = kind(coarse_triangles=coarse_triangles)
        return solve(fine_specimen, "dshell", settings, mesh=fine_mesh)

    return release


@KINDS
def test_it_ends_in_the_equilibrium_that_flat_leads_to(kind, released):
    from_flat, from_coarse = released(kind, 0), released(kind, COARSE)
    assert from_flat.attrs["start"] == "flat"
    assert from_coarse.attrs["start"].startswith("flat, on a coarse mesh first: dshell, model")
    assert from_coarse.iterations.values[0] < 0.7 * from_flat.iterations.values[0]
    assert from_coarse.load_steps.values.tolist() == [1]
    assert from_coarse.height.values == pytest.approx(from_flat.height.values, rel=1e-6)
    assert from_coarse.position.values == pytest.approx(from_flat.position.values, abs=1e-7)


def test_later_milestones_start_from_the_first(fine_specimen, fine_mesh, released):
    settings = MorleySettings(coarse_triangles=COARSE)
    both = fine_specimen.with_milestones([1.03, 1.06])
    result = solve(both, "dshell", settings, mesh=fine_mesh)
    single = released(MorleySettings, COARSE)
    assert result.position.values[1] == pytest.approx(single.position.values[0], abs=1e-7)


def test_a_start_that_leads_nowhere_is_left_for_flat(fine_specimen, fine_mesh, released):
    flat = released(MorleySettings, 0)
    noise = np.random.default_rng(0).normal(scale=0.02, size=(len(fine_mesh.points), 3))
    led_astray = CoarseStart(SOLVER, prolong=lambda shape, coarse, fine: noise)
    settings = MorleySettings(coarse_triangles=COARSE)

    def open_astray(specimen, settings, *, mesh, **others):
        return open_shell_path(specimen, settings, mesh, None, led_astray)

    astray = replace(SOLVER, open_path=open_astray)
    result = solve_with(astray, fine_specimen, settings, mesh=fine_mesh)
    assert result.converged.all()
    assert result.attrs["start"].startswith("flat, because what was to start it led nowhere: flat,")
    assert result.height.values == pytest.approx(flat.height.values, rel=1e-6)


def test_a_coarse_one_is_drawn_for_a_fine_one_alone(fine_specimen, fine_mesh):
    coarse = coarse_mesh(fine_specimen, fine_mesh, COARSE)
    assert 0.5 * COARSE < len(coarse.triangles) < 2 * COARSE
    assert coarse_mesh(fine_specimen, fine_mesh, 0) is None
    assert coarse_mesh(fine_specimen, fine_mesh, len(fine_mesh.triangles) // 3) is None

    def fails(specimen):
        raise ComputationError("no gmsh")

    assert coarse_mesh(fine_specimen, fine_mesh, COARSE, draw=fails) is None


def turned(mesh, angle):
    c, s = np.cos(angle), np.sin(angle)
    return replace(mesh, points=mesh.points @ np.array([[c, s], [-s, c]]))


@pytest.mark.parametrize("angle", [0.0, 2 * np.pi / 5])
def test_a_mesh_turned_into_itself_has_the_same_cut(fine_specimen, fine_mesh, angle):
    assert coarse_mesh(fine_specimen, turned(fine_mesh, angle), COARSE) is not None


def test_a_mesh_with_another_cut_starts_from_flat(fine_specimen, fine_mesh):
    """Its coarse mesh would have the specimen's cut, and so another shape."""
    uncut = fine_specimen.with_layer("kirigami", pattern=None)
    assert coarse_mesh(fine_specimen, turned(fine_mesh, np.pi / 5), COARSE) is None
    assert coarse_mesh(uncut, fine_mesh, COARSE) is None
    result = solve(uncut, "dshell", MorleySettings(coarse_triangles=COARSE), mesh=fine_mesh)
    assert result.attrs["start"] == "flat"


def test_a_coarse_mesh_without_an_equilibrium_is_told(fine_specimen, fine_mesh, monkeypatch):
    follow = ShellPath.approach

    def approach(path, target):
        if len(path.mesh.triangles) < len(fine_mesh.triangles):
            raise ComputationError("lost")
        yield from follow(path, target)

    monkeypatch.setattr(ShellPath, "approach", approach)
    settings = MorleySettings(coarse_triangles=COARSE)
    result = solve(fine_specimen, "dshell", settings, mesh=fine_mesh)
    assert result.converged.all()
    assert result.attrs["start"].startswith("flat, because on a coarse mesh it stopped at prestr")


def test_the_shape_that_only_leads_is_not_measured(fine_specimen, fine_mesh, monkeypatch):
    measured = []

    def watched(specimen, mesh, stretch, position):
        measured.append(len(mesh.triangles))
        return measure(specimen, mesh, stretch, position)

    monkeypatch.setattr(recording, "measure", watched)
    settings = MorleySettings(coarse_triangles=COARSE)
    result = solve(fine_specimen, "dshell", settings, mesh=fine_mesh)
    assert result.attrs["start"].startswith("flat, on a coarse mesh first")
    assert np.isfinite(result.sphere_radius.values).all()
    assert measured == [len(fine_mesh.triangles)]


def test_a_flat_disc_is_prolonged_exactly(coarse_mesh, fine_mesh):
    stretched = np.array([[1.1, 0.2, 0.3], [-0.1, 0.9, 0.4]])
    found = prolong_shape(coarse_mesh.points @ stretched, coarse_mesh, fine_mesh)
    expected = fine_mesh.points @ stretched
    assert found == pytest.approx(expected, abs=1e-8)  # its slopes are found by iteration


def test_a_sphere_stays_one(coarse_mesh, fine_mesh):
    x, y = coarse_mesh.points.T
    sphere = np.column_stack([x, y, np.sqrt(0.06**2 - x**2 - y**2)])
    radii = np.linalg.norm(prolong_shape(sphere, coarse_mesh, fine_mesh), axis=1)
    assert np.ptp(radii) < 0.01 * radii.mean()  # linear interpolation: 0.03
    assert radii.mean() == pytest.approx(0.06, rel=0.05)


C_SHAPE = Polygon(
    ((0, 0), (4, 0), (4, 1.4), (1, 1.4), (1, 1.5), (4, 1.5), (4, 3), (0, 3)),
    (((0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7)),),
)
"""With a slit narrower than its triangles, and a hole."""
OUTLINES = {
    "disc": Disc(R),
    "ellipse": Ellipse(4 * R, R),
    "rounded": Rectangle(2 * R, 3 * R, 0.5 * R),
    "corner": CORNER,
    "slit and hole": C_SHAPE,
}


@pytest.fixture(scope="module", params=OUTLINES.values(), ids=OUTLINES)
def two_meshes(request):
    """Return a coarse and a fine mesh of an outline."""
    length = request.param.characteristic_length
    sheets = (sheet_of(request.param, pile_of("bilayer", 0.1 * length), size=length / size)
              for size in (5, 18))  # fmt: skip
    return [generate_mesh(sheet) for sheet in sheets]


def test_a_sheet_moved_as_a_whole_is_prolonged_exactly(two_meshes):
    coarse, fine = two_meshes
    stretched = np.array([[1.1, 0.2, 0.3], [-0.1, 0.9, 0.4]])
    found = prolong_shape(coarse.points @ stretched, coarse, fine)
    expected = fine.points @ stretched
    assert found - found[0] == pytest.approx(expected - expected[0], abs=1e-6 * np.ptp(fine.points))


def test_the_sides_of_a_slit_do_not_see_each_other():
    """The two arms of the sheet bend to opposite sides, each on a cylinder."""
    coarse, fine = (
        generate_mesh(sheet_of(C_SHAPE, pile_of("bilayer", 0.1), size=size)) for size in (0.4, 0.12)
    )

    def bent(mesh):
        x, y = mesh.points.T
        return np.column_stack([x, y, np.where(x > 1, np.sign(y - 1.45) * (x - 1) ** 2 / 8, 0)])

    found, expected = prolong_shape(bent(coarse), coarse, fine), bent(fine)
    assert found - found[0] == pytest.approx(expected - expected[0], abs=0.02)


SHEETS = pytest.mark.parametrize(
    ("outline", "pattern"),
    [(Rectangle(2 * R, 2 * R), CUT_SHEETS["cross"][1]), (C_SHAPE, None)],
    ids=["square", "slit and hole"],
)


@SHEETS
@pytest.mark.parametrize("kind", ["bilayer", "trilayer"])
def test_any_sheet_ends_in_the_equilibrium_that_flat_leads_to(outline, pattern, kind):
    length = outline.characteristic_length
    layers = pile_of(kind, 0.15 * length, pattern)
    sheet = sheet_of(outline, layers, [1.06], size=length / 15)
    mesh = generate_mesh(sheet)
    from_flat, from_coarse = (
        solve(sheet, "dshell", MorleySettings(coarse_triangles=count, tolerance=1e-10), mesh=mesh)
        for count in (0, 200)
    )
    assert from_coarse.attrs["start"].startswith("flat, on a coarse mesh first: dshell, model")
    assert from_coarse.iterations.values[0] < from_flat.iterations.values[0]
    apart = from_coarse.position.values - from_flat.position.values
    assert np.abs(apart).max() < 1e-6 * length


def test_a_bad_number_is_named():
    with pytest.raises(InputError, match=r"solver\.coarse_triangles = -1: expected"):
        MorleySettings(coarse_triangles=-1)
