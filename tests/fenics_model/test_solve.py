"""The model from a specimen to the dataset, on coarse meshes."""

import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from verification.symmetry import asymmetry

from bilayer import (
    ComputationError,
    InputError,
    LinearElastic,
    MeshSize,
    generate_mesh,
    open_result,
    paper_specimen,
    write_result,
)
from bilayer import solve as bilayer_solve
from bilayer.results.comparison import compare
from dshell import MorleySettings
from fenics_model import SOLVER, SolidSettings

COARSE = replace(paper_specimen(), mesh=MeshSize(0.012))


def solve(specimen, settings=None, start="flat", **options):
    """Load steps from flat, if no start is given."""
    return bilayer_solve(specimen, "fenics", settings, start=start, **options)


needs_dolfinx = pytest.mark.skipif(find_spec("dolfinx") is None, reason="dolfinx is not there")


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(COARSE)


@pytest.fixture(scope="module")
def released(mesh):
    """The coarse paper's specimen at two milestones."""
    return solve(COARSE.with_milestones([1.02, 1.04]), mesh=mesh)


def test_without_dolfinx_the_package_imports_and_solve_says_what_is_missing():
    script = (
        "import sys; sys.modules['dolfinx'] = None\n"
        "import fenics_model, fenics_model.settings, bilayer\n"
        "try: bilayer.solve(bilayer.paper_specimen(), 'fenics', start='flat')\n"
        "except bilayer.ComputationError as error: print(error)"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert len(run.stdout.splitlines()) == 1
    assert "dolfinx" in run.stdout
    assert "scripts/bilayer" in run.stdout


def test_settings_name_what_is_wrong():
    with pytest.raises(InputError, match=r"solver\.substrate_elements = 0"):
        SolidSettings(substrate_elements=0)
    with pytest.raises(InputError, match=r"solver\.tolerance = -1"):
        SolidSettings(tolerance=-1.0)
    with pytest.raises(InputError, match=r"solver\.path_tolerance = 1\.0: .* less than 1"):
        SolidSettings(path_tolerance=1.0)
    with pytest.raises(InputError, match=r"solver\.branch = 'low'.*mean 'lowest'"):
        SolidSettings(branch="low")
    with pytest.raises(InputError, match=r"solver\.smallest_step = 0\.002.*solver\.first_step"):
        SolidSettings(smallest_step=0.002)
    with pytest.raises(InputError, match=r"solver\.first_step = 0\.1.*solver\.largest_step"):
        SolidSettings(first_step=0.1)


@needs_dolfinx
def test_settings_of_another_solver_are_refused(mesh):
    with pytest.raises(InputError, match=r"settings = MorleySettings.*: expected one of"):
        solve(COARSE, MorleySettings(), mesh=mesh)


@needs_dolfinx
@pytest.mark.parametrize("option", ["ksp_type", "pc_factor_mat_solver_type"])
def test_an_option_that_petsc_does_not_know_is_an_error_in_one_line(mesh, option):
    settings = SolidSettings(petsc_options=f"-bilayer_{option} nosuch")
    with pytest.raises(InputError, match=rf"solver\.petsc_options = .*{option}") as raised:
        solve(COARSE.with_milestones([1.01]), settings, mesh=mesh)
    assert len(str(raised.value).splitlines()) == 1


@needs_dolfinx
def test_the_dataset_is_whole(released, mesh, tmp_path):
    write_result(released, tmp_path / "released.nc")
    result = open_result(tmp_path / "released.nc")
    assert result.attrs["solver"] == "fenics"
    assert result.attrs["model"] in SOLVER.models
    assert result.attrs["stop_reason"] == ""
    assert "dolfinx" in result.attrs["versions"]
    assert result["converged"].values.tolist() == [1, 1]
    assert result["unstable_modes"].values.tolist() == [0, 0]
    for name in ("stabilised_steps", "dissipated_energy", "escapes"):
        assert result[name].values.tolist() == [0, 0]  # nothing snaps here
    assert result["branch_taken"].values.tolist() == [-1, -1]
    assert np.all(result["residual"] < 1e-10)
    assert np.all(
        result["energy"].sel(term=b"substrate" if result["term"].dtype.kind == "S" else "substrate")
        > 0
    )
    assert np.all(np.diff(result["height"]) > 0)
    bond = result["volume_reference_position"].values[:, 2] == 0
    assert result["volume_position"].values[:, bond] == pytest.approx(result["position"].values)
    assert result["volume_cells"].shape[0] == 3 * (len(mesh.triangles) + mesh.region.sum())


@needs_dolfinx
def test_it_bends_toward_the_substrate(released):
    """The stretched side shrinks, so the rim goes down, where the substrate is."""
    shape = released["position"].values[-1]
    rim = np.linalg.norm(released["reference_position"].values, axis=1) > 0.0399
    assert shape[rim, 2].mean() < shape[~rim, 2].mean()


@needs_dolfinx
@pytest.mark.parametrize(("turn", "mirrored"), [(1, False), (2, False), (0, True)])
def test_the_shape_has_the_symmetries_of_the_specimen(released, mesh, turn, mirrored):
    """To the accuracy of a coarse mesh that has none of them."""
    shape = released["position"].values[-1]
    apart = asymmetry(mesh, shape, 2 * np.pi * turn / 5, mirrored=mirrored)
    assert 0 < apart < 0.02 * float(released["height"][-1])
    assert asymmetry(mesh, shape, np.pi / 5) > 3 * apart  # a petal onto a cutout


@needs_dolfinx
def test_milestones_do_not_depend_on_path_or_imperfection(released, mesh):
    other = solve(
        COARSE.with_milestones([1.04]),
        SolidSettings(imperfection=0.02, first_step=0.0007, petsc_options="-bilayer_pc_type lu"),
        mesh=mesh,
    )
    assert other["position"].values[0] == pytest.approx(released["position"].values[1], abs=1e-9)
    assert other["unstable_modes"].values[0] == -1  # LU does not tell


@needs_dolfinx
def test_the_two_ways_to_draw_the_substrate_agree(released, mesh):
    """A mesh of the bonded thickness of one prestretch has that prestretch's solution."""
    bonded = COARSE.layer("substrate").thickness / 1.04**2
    constant = COARSE.with_milestones([1.04]).with_layer("substrate", thickness=bonded)
    constant = replace(constant, prestretch=replace(constant.prestretch, thickness="constant"))
    drawn_bonded = solve(constant, mesh=mesh)
    assert drawn_bonded["position"].values[0] == pytest.approx(
        released["position"].values[1], abs=1e-9
    )


@needs_dolfinx
def test_a_failed_load_step_leaves_the_last_state(mesh):
    settings = SolidSettings(
        first_step=0.06, smallest_step=0.06, largest_step=0.5, flow_steps=0, iteration_limit=6
    )
    result = solve(COARSE.with_milestones([1.0005, 1.6, 1.7]), settings, mesh=mesh)
    assert result["converged"].values.tolist() == [1, 0, 0]
    assert "no convergence" in result.attrs["stop_reason"]
    assert np.isnan(result["position"].values[1:]).all()
    assert result["last_prestretch"].values[1] == pytest.approx(1.0005)
    last, first = result["last_position"].values[1], result["position"].values[0]
    assert last == pytest.approx(first, abs=1e-15)  # not what the failed attempt left
    assert result["load_steps"].values[1:].tolist() == [0, 0]


@needs_dolfinx
def test_starting_from_its_own_result_takes_few_iterations(released, mesh):
    again = solve(COARSE.with_milestones([1.04]), mesh=mesh, start=released)
    assert again["position"].values[0] == pytest.approx(released["position"].values[1], abs=1e-9)
    assert again["load_steps"].values[0] == 1
    assert again["iterations"].values[0] <= 8


@needs_dolfinx
def test_a_start_that_leads_nowhere_changes_no_result(released, mesh):
    crumpled = released.copy(deep=True)
    rng = np.random.default_rng(2)
    crumpled["position"] += rng.normal(scale=4e-3, size=crumpled["position"].shape)
    again = solve(COARSE.with_milestones([1.02]), mesh=mesh, start=crumpled)
    assert again["stabilised_steps"].values[0] > 0  # a flow from the flat state
    assert again["position"].values[0] == pytest.approx(released["position"].values[0], abs=1e-9)


@needs_dolfinx
def test_a_start_on_another_mesh_is_an_error(released):
    with pytest.raises(InputError, match="start: "):
        other = generate_mesh(replace(COARSE, mesh=MeshSize(0.02)))
        solve(COARSE.with_milestones([1.02]), mesh=other, start=released)


@needs_dolfinx
def test_linear_law_and_uncut_disc(mesh):
    """At a small prestretch the linear law bends as the hyperelastic ones."""

    def radius(law):
        specimen = COARSE.with_milestones([1.005]).with_layer("kirigami", pattern=None)
        for name, modulus in (("substrate", 116250.0), ("kirigami", 368988.0)):
            specimen = specimen.with_layer(name, material=law(modulus))
        return float(
            solve(specimen, mesh=replace(mesh, region=np.ones_like(mesh.region)))["sphere_radius"][
                0
            ]
        )

    from bilayer import NeoHookean

    linear = radius(lambda young: LinearElastic(young, 0.5))
    assert linear == pytest.approx(radius(lambda young: NeoHookean(young / 6)), rel=0.03)


@needs_dolfinx
@pytest.mark.parametrize("thickness", ["natural", "constant"])
def test_the_held_points_carry_the_weight(mesh, thickness):
    """The reaction along z is the natural mass times g, however the substrate is drawn.

    A natural disc of the substrate is lx ly times smaller than the bonded one, and stays as thick
    as stated by one rule; by the other the bonded one is as thick as stated.
    """
    from dolfinx import fem
    from mpi4py import MPI

    from fenics_model.path.load_schedule import LoadPlace
    from fenics_model.release.specimen_solid import make_solid

    prestretch = replace(COARSE.prestretch, thickness=thickness)
    heavy = replace(COARSE, gravity=9.81, prestretch=prestretch).with_milestones([1.2])
    body = make_solid(heavy, mesh, SolidSettings(imperfection=0.0), MPI.COMM_SELF)
    body.load(LoadPlace((1.2, 1.2), weight=1.0, imperfection=0.0))
    upward = body.solid.component(2).collapse()[1]
    with body.solid.at(body.solid.undeformed):
        residual = fem.assemble_vector(body.solid.residual).array
    substrate, kirigami = mesh.areas.sum(), mesh.areas[mesh.region == 1].sum()
    natural = substrate / 1.2**2 if thickness == "natural" else substrate
    mass = 960.0 * 1e-3 * (natural + kirigami)
    assert residual[upward].sum() == pytest.approx(mass * 9.81, rel=1e-9)


@needs_dolfinx
def test_the_weight_alone_bends_the_disc_down_onto_a_stable_shape(mesh):
    """At g q R^3 / D is about 10: the disc hangs from its centre."""
    hanging = solve(
        replace(COARSE, gravity=9.81).with_milestones([1.0]),
        SolidSettings(tolerance=1e-8),
        mesh=mesh,
    )
    assert hanging["converged"].values.tolist() == [1]
    assert hanging["unstable_modes"].values.tolist() == [0]
    assert hanging["position"].values[0, :, 2].mean() < -5e-3


@needs_dolfinx
def test_a_weighted_dome_is_the_one_that_the_shell_finds():
    """Both hold it at its centre, and q R^3 / D is about 1."""
    heavy = replace(paper_specimen(), mesh=MeshSize(0.008), gravity=1.0).with_milestones([1.06])
    mesh = generate_mesh(heavy)
    shell, solid = (bilayer_solve(heavy, solver, mesh=mesh) for solver in ("dshell", "fenics"))
    assert solid["converged"].values.tolist() == shell["converged"].values.tolist() == [1]
    assert compare(solid, shell)["rms_distance_over_radius"].values[0] < 0.01


@needs_dolfinx
def test_a_load_step_too_long_for_newton_is_taken_by_the_flow_and_says_so(released, mesh):
    """Inverted elements (not a number) are failed attempts, and the shape is the same."""
    at_once = SolidSettings(first_step=0.04, smallest_step=0.04, largest_step=0.05)
    specimen = COARSE.with_milestones([1.04])
    stopped = solve(specimen, replace(at_once, flow_steps=0), mesh=mesh)
    assert stopped["converged"].values.tolist() == [0]
    assert "no convergence" in stopped.attrs["stop_reason"]
    flowed = solve(specimen, at_once, mesh=mesh)
    assert flowed["converged"].values.tolist() == [1]
    assert flowed["unstable_modes"].values.tolist() == [0]
    assert flowed["stabilised_steps"].values[0] > 0
    assert flowed["dissipated_energy"].values[0] > 0
    assert flowed["position"].values[0] == pytest.approx(released["position"].values[1], abs=1e-9)


@needs_dolfinx
@pytest.mark.mpi
def test_two_ranks_give_what_one_gives():
    from mpi4py import MPI

    if MPI.COMM_WORLD.size == 1:
        pytest.skip("one rank: run under mpirun -n 2")
    specimen = replace(paper_specimen(), mesh=MeshSize(0.008)).with_milestones([1.03])
    shared = solve(specimen)
    alone = solve(specimen, comm=MPI.COMM_SELF)
    for name in ("position", "volume_position"):
        assert shared[name].values == pytest.approx(alone[name].values, abs=1e-9)
    assert shared["iterations"].values == alone["iterations"].values
    everywhere = MPI.COMM_WORLD.allgather(shared)
    assert everywhere[0].identical(everywhere[1])


@needs_dolfinx
@pytest.mark.mpi
def test_an_error_on_the_first_rank_is_raised_on_all():
    with pytest.raises((InputError, ComputationError), match=r"mesh\.size"):
        solve(replace(paper_specimen(), mesh=MeshSize(1e-6)))


@needs_dolfinx
def test_without_prestretch_it_is_flat(mesh):
    """Between a disc bent down and one bent up."""
    result = solve(COARSE.with_milestones([0.99, 1.0, 1.01]), mesh=mesh)
    assert result["converged"].values.tolist() == [1, 1, 1]
    flat = result.sel(prestretch=1.0)
    assert flat["position"].values == pytest.approx(flat["reference_position"].values, abs=1e-9)
    assert float(flat["energy"].sum()) < 1e-12


@needs_dolfinx
@pytest.mark.slow
def test_the_mesh_does_not_matter_to_the_radius(paper_6mm, paper_6mm_solid):
    """The best sphere at 1.06, within 1 % from mesh to mesh."""
    finer = solve(replace(paper_6mm, mesh=MeshSize(0.004)).with_milestones([1.06]))
    coarse = paper_6mm_solid["sphere_radius"].sel(prestretch=1.06)
    assert float(coarse) == pytest.approx(float(finer["sphere_radius"][0]), rel=0.01)
