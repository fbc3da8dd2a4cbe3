"""The shell's search for stable shapes: both sides, families, stiffness, deflation, files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import bilayer
from bilayer import ComputationError, InputError, MorleySettings, PaperSettings
from bilayer.errors import Interrupted
from bilayer.geometry.alignment import rms_distance
from bilayer.landscape.barrier import describe_barrier
from bilayer.landscape.catalogue import Catalogue
from bilayer.landscape.report import describe_search, states_table
from bilayer.landscape.search import shapes_on
from bilayer.landscape.starts import Sheet
from bilayer.landscape.symmetry import Images, symmetry_of
from bilayer.mesh.planar import flat_surface
from bilayer.results.released_shapes import released_shapes
from bilayer.results.report import describe_lower_states
from bilayer.results.schema import result_mesh
from bilayer.solvers.rerun import rerun
from dshell.solve.deflation import ShapeDeflation
from dshell.solver import SOLVER

EXAMPLES = Path(__file__).parents[2] / "examples"
STRETCH = (1.15, 1.15)
FEW = 4


@pytest.fixture(scope="module")
def specimen():
    coarse = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.012))
    return coarse.with_milestones([1.15])


@pytest.fixture(scope="module")
def found(specimen, tmp_path_factory):
    """The states of a short search, and their file."""
    file = tmp_path_factory.mktemp("states") / "states.nc"
    return bilayer.states(specimen, starts=FEW, output=file), file


def finder_of(specimen, mesh=None):
    stretch = specimen.prestretch.milestones[-1]
    return SOLVER.open_finder(specimen, MorleySettings(), stretch, mesh=mesh)


def total(equilibrium):
    return sum(equilibrium.energy.values())


@pytest.fixture(scope="module")
def thin():
    """A trilayer of two mirror states."""
    sheet = bilayer.read_specimen(EXAMPLES / "trilayer_lotus.toml", ["mesh.size=4 mm"])
    for name in ("lower", "upper"):
        sheet = sheet.with_layer(name, thickness=0.25e-3)
    return sheet.with_milestones([1.2])


def test_a_trilayer_has_both_mirror_states_of_one_energy(thin):
    finder = finder_of(thin)
    dome = Sheet(finder.mesh, thin.characteristic_length).dome(1.2)
    (up,) = finder.settle(dome)
    (down,) = finder.settle(up.position * [1, 1, -1])
    assert total(down) == pytest.approx(total(up), rel=1e-9)
    images = Images(finder.mesh, symmetry_of(thin, (1.2, 1.2)))
    assert images.distance(up.position, down.position) > 0.05 * thin.characteristic_length
    assert images.plain_distance(up.position, down.position * [1, 1, -1]) < 1e-7


def test_rolled_shapes_of_an_uncut_disc_are_one_state(specimen):
    uncut = specimen.with_layer("kirigami", pattern=None)
    finder = finder_of(uncut)
    length = uncut.characteristic_length
    sheet = Sheet(finder.mesh, length)
    catalogue = Catalogue(Images(finder.mesh, symmetry_of(uncut, STRETCH)), length)
    shapes = [finder.settle(sheet.rolled(axis, -1.5))[0] for axis in (0.0, 0.4, 1.1)]
    first, *others = [(shape.position, total(shape)) for shape in shapes]
    assert max(catalogue.images.plain_distance(first[0], p) for p, _ in others) > 0.05 * length
    for position, energy in others:
        assert energy == pytest.approx(first[1], rel=1e-3)
        assert catalogue.images.distance(first[0], position) < catalogue.tolerance
    least, following = finder.stiffnesses(shapes[0], 2)
    assert 0 < least < 0.1 * following  # it turns almost freely


def test_stiffness_is_that_of_the_free_shape(specimen):
    """Against all eigenvalues of the free shape, its stiffness by differences of forces."""
    finder = finder_of(specimen)
    (stable,) = finder.settle(Sheet(finder.mesh, 0.04).dome(-1.2))
    least = finder.stiffnesses(stable, 3)
    moved = stable.position @ np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # held elsewhere
    (again,) = finder.settle(moved)
    assert finder.stiffnesses(again, 3) == pytest.approx(least, rel=1e-5)
    assert (np.diff(least) >= 0).all() and least[0] > 0


def test_deflation_is_the_step_of_the_deflated_residual():
    """Against Newton's step of m F, its matrix made in full, on forces of two points."""
    known = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.2]])
    weights = np.array([0.1, 0.2, 0.3, 0.4])
    deflation = ShapeDeflation([known, 1.3 * known], weights, scale=0.7)
    rng = np.random.default_rng(1)
    state = known.reshape(-1) + 0.1 * rng.normal(size=12)
    stiffness = np.diag(rng.uniform(1, 2, 12))
    forces = rng.normal(size=12)
    step = np.linalg.solve(stiffness, -forces)
    h = 1e-6
    slope = [
        (deflation.value(state + h * axis) - deflation.value(state - h * axis)) / (2 * h)
        for axis in np.eye(12)
    ]
    value = deflation.value(state)
    whole = value * stiffness + np.outer(forces, slope)
    expected = np.linalg.solve(whole, -value * forces)
    assert deflation.factor(state, step) * step == pytest.approx(expected, rel=1e-6)


def test_a_known_state_is_not_found_by_deflation(specimen):
    finder = finder_of(specimen)
    sheet = Sheet(finder.mesh, 0.04)
    (known,) = finder.settle(sheet.dome(-1.2))
    near = known.position + 1e-4 * np.random.default_rng(0).normal(size=known.position.shape)
    images = Images(finder.mesh, symmetry_of(specimen, STRETCH))
    for other in finder.settle_elsewhere(near, [known.position]):
        assert images.plain_distance(other.position, known.position) > 1e-4


def test_states_are_a_result_that_everything_reads(found, tmp_path):
    states, file = found
    stored = bilayer.open_result(file)
    assert stored.equals(states)
    energy = states["energy"].sum("term").values
    assert (np.diff(energy) >= 0).all()
    assert states["times_found"].sum() >= (states["start_state"] >= 0).sum()
    assert states.sizes["start"] == FEW and states.attrs["starts_asked"] == FEW
    assert (states["unstable_modes"] == 0).all() and (states["least_stiffness"] > 0).all()
    assert states["symmetry_turns"].values[0] in (1, 5)
    assert (states["residual"] < 1e-8).all()
    titles = [shape.title for shape in released_shapes(states, result_mesh(states))]
    assert titles[0] == f"0: {1e3 * energy[0]:.4f} mJ"
    table = states_table(states)
    assert len(table.splitlines()) == 2 + len(energy)
    assert f"{len(energy)} state" in describe_search(states)
    bilayer.save_figure(bilayer.draw_shapes(states), tmp_path / "states.png")


def test_the_shell_stays_in_a_state_that_starts_it(found):
    states, _ = found
    specimen = bilayer.result_specimen(states).with_milestones([1.15])
    last = states.isel(prestretch=[-1])
    again = bilayer.solve(specimen, "dshell", mesh=result_mesh(states), start=last)
    energies = [result["energy"].sum("term").values[0] for result in (last, again)]
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)


def test_an_interrupted_search_goes_on(specimen, found, tmp_path):
    whole, _ = found
    file = tmp_path / "states.nc"

    def interrupt(share, text):
        if share >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        bilayer.states(specimen, starts=FEW, output=file, progress=interrupt)
    part = bilayer.open_result(file)
    assert part.attrs["stop_reason"] == "interrupted" and part.sizes["start"] == 2
    resumed = bilayer.states(specimen, starts=FEW, output=file, resume=file)
    assert resumed["start_name"].values.tolist() == whole["start_name"].values.tolist()
    assert resumed["times_found"].values.tolist() == whole["times_found"].values.tolist()
    assert np.allclose(resumed["position"], whole["position"], atol=1e-9)
    with pytest.raises(InputError, match="was begun with the milestones"):
        bilayer.states(specimen.with_milestones([1.2]), starts=FEW, resume=file)


def test_what_has_no_search_is_refused(specimen):
    with pytest.raises(InputError, match="no search for stable shapes"):
        bilayer.states(specimen, PaperSettings(), starts=1)
    with pytest.raises(InputError, match="starts = 0"):
        bilayer.states(specimen, starts=0)


def test_a_search_without_a_find_is_an_error(specimen):
    with pytest.raises(ComputationError, match="none of 1 starts"):
        bilayer.states(specimen, MorleySettings(max_iterations=1), starts=1)


def test_the_command_prints_its_states(bilayer_command, tmp_path, specimen):
    (tmp_path / "s.toml").write_text(bilayer.specimen_to_toml(specimen))
    done = bilayer_command("states", "s.toml", "--starts", 1, "-o", "s.nc", "--prestretch", 1.1)
    assert done.returncode == 0, done.stderr
    assert "1 state from 1 start, none of which led nowhere." in done.stdout
    bad = bilayer_command(
        "solve", "s.toml", "--solver", "dshell", "--start", "s.nc", "--start-state", 3, "-o", "t.nc"
    )
    assert bad.returncode == 2
    assert "--start-state 3: expected a number from 0 to 0" in bad.stderr


def test_the_command_takes_the_lowest_state(bilayer_command, tmp_path, specimen):
    coarse = replace(specimen, mesh=bilayer.MeshSize(0.016)).with_milestones([1.03])
    (tmp_path / "s.toml").write_text(bilayer.specimen_to_toml(coarse))
    done = bilayer_command("solve", "s.toml", "--lowest", 1)
    assert done.returncode == 0, done.stderr
    assert "branch: path" in done.stderr
    assert bilayer.open_result(tmp_path / "s.nc")["lower_state"].values.tolist() == [0.0]
    bad = bilayer_command("solve", "s.toml", "--lowest", 1, "--solver", "both", "-o", "t.nc")
    assert bad.returncode == 2
    assert "--lowest 1: expected with --solver dshell alone" in bad.stderr


@pytest.fixture(scope="module")
def way(thin):
    """The way from one mirror state to the other, both in one dataset."""
    both = bilayer.states(thin, starts=1)
    turned = both.assign(position=both["position"] * xr.DataArray([1.0, 1.0, -1.0], dims="xyz"))
    pair = xr.concat([both, turned], "prestretch", data_vars="minimal", join="override")
    stretched = thin.with_milestones([1.2, 1.2])
    pair = pair.assign_attrs(specimen=bilayer.specimen_to_toml(stretched))
    return bilayer.barrier(pair, 0, 1, images=9, rounds=8)


def test_between_mirror_states_there_is_a_pass_as_high_from_both(way):
    up, back = way.attrs["barrier"], way.attrs["barrier_back"]
    assert up == pytest.approx(back, rel=1e-5) and up > 0
    assert way.attrs["saddle_modes"] == 1
    assert sorted(way.attrs["saddle_leads_to"].tolist()) == [0, 1]
    energy = way["energy"].sum("term").values
    assert energy.max() == pytest.approx(energy[0] + up)  # the saddle is in its place
    assert (np.diff(way["way_length"]) > 0).all()
    assert way["unstable_modes"].values.max() == 1


def test_the_barrier_is_told(way, thin):
    text = describe_barrier(way, 0, 1)
    assert "over a saddle with 1 unstable mode, down to state" in text
    none = way.assign_attrs(saddle_modes=-1)
    assert "NO SADDLE" in describe_barrier(none, 0, 1)
    with pytest.raises(InputError, match="second = 99: expected a state from 0 to"):
        bilayer.barrier(way, 0, 99)


def test_states_of_a_search_are_not_computed_again(found):
    with pytest.raises(InputError, match="has the states of a search"):
        rerun(found[0])


def test_a_result_knows_of_a_lower_state(found):
    """States of one file, the higher one as a result of its own."""
    states, _ = found
    higher = states.isel(prestretch=[-1]).drop_dims("start")
    known = bilayer.look_below(higher, starts=FEW + 1)
    energy = states["energy"].sum("term").values
    assert known["lower_state"].values == pytest.approx([energy[0] / energy[-1] - 1], abs=1e-9)
    lower = known.assign(lower_state=("prestretch", [-0.025]))
    assert describe_lower_states(lower) == ["A LOWER STATE is known at 1.15 (2.50% below)."]
    assert describe_lower_states(known.drop_vars("lower_state")) == []


def test_the_lowest_state_takes_the_place_of_a_higher_one(specimen):
    cut = replace(specimen.layer("kirigami").pattern, strips=6)
    six = replace(specimen.with_layer("kirigami", pattern=cut), mesh=bilayer.MeshSize(0.016))
    path = bilayer.solve(six, "dshell")
    lowest = bilayer.take_lowest(path, starts=7)
    energy, before = (result["energy"].sum("term").values for result in (lowest, path))
    assert energy < 0.999 * before
    assert lowest["lower_state"].values.tolist() == [0.0]
    assert lowest["converged"].values.all() and not lowest["unstable_modes"].values.any()
    assert lowest.attrs["branch"] == "lowest of a search at 1.15"
    assert set(path.data_vars) <= set(lowest.data_vars)
    again = bilayer.take_lowest(lowest, starts=1)
    assert again.attrs["branch"] == "path"
    np.testing.assert_array_equal(again["position"], lowest["position"])
    with pytest.raises(InputError, match="solver = 'fenics': expected a result of dshell"):
        bilayer.take_lowest(lowest.assign_attrs(solver="fenics"))


def test_states_start_from_those_of_another_mesh(specimen, found):
    states, _ = found
    finer = replace(specimen, mesh=bilayer.MeshSize(0.009))
    (first, *_) = shapes_on(bilayer.generate_mesh(finer), states)
    again = bilayer.states(finer, starts=1, start=states)
    assert again["start_name"].values.tolist() == ["given shape 0"]
    weights = flat_surface(result_mesh(again)).node_areas
    apart = rms_distance(again["position"].values[0], first, weights)
    assert apart < 0.1 * 0.04  # the same state, on a mesh of another size
