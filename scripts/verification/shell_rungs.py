"""The ladder of the discrete shells: every case with its reference and tolerance."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bilayer import MeshSize, PlanarMesh, open_result, paper_specimen, solve
from bilayer.mesh.generation import generate_mesh
from bilayer.results.comparison import compare
from bilayer.results.schema import result_mesh, result_specimen
from dshell import HingeSettings, MorleySettings
from dshell.models.hinge import HingeModel
from dshell.models.morley import MorleyModel
from dshell.models.paper_rest_state import rest_state
from verification import (
    bilayers,
    buckled_strip,
    cantilevers,
    clamped_plate,
    contacts,
    curved_surfaces,
    derivatives,
    flowers,
    hinge_lattice,
    hinged_roof,
    inflated_membrane,
    plates,
    relaxing_layer,
    shell_fields,
    shell_roof,
    shell_states,
    slow_sheets,
    wall_strip,
)
from verification.laws import LAW_CASES, STRETCHES, law_checks
from verification.meshes import hexagon, rectangle
from verification.rung import Check, Rung

FINITE_ELEMENT_RESULT = Path(__file__).parents[2] / "results" / "paper" / "fenics.nc"


def timoshenko_strip() -> Iterator[Check]:
    for stretch, curvature in ((1.01, 6.793), (1.03, 19.985)):
        found = bilayers.timoshenko_strip(stretch)
        yield Check(f"curvature at prestretch {stretch:g} (1/m)", found, curvature, 0.01)


def uniform_cap() -> Iterator[Check]:
    for mismatch, sag, centre in (
        (0.2, 0.19407, 0.19092),
        (0.5, 0.43398, 0.40071),
        (1.0, 0.71125, 0.57980),
    ):
        cap = bilayers.scaled_cap(mismatch)
        yield Check(f"S = {mismatch:g}: curvature by the sag", cap.sag, sag, 0.01)
        yield Check(f"S = {mismatch:g}: curvature at the centre", cap.centre, centre, 0.01)


def loss_of_symmetry() -> Iterator[Check]:
    expected = 1.15075
    below = bilayers.span_ratio(0.98 * expected)
    yield Check("ratio of the spans at 0.98 S_c", below, 1.0, 2e-3)
    beyond = bilayers.span_ratio(1.02 * expected)
    yield Check("the same at 1.02 S_c: no longer round", beyond, 1.0, None)
    found = bilayers.loss_of_symmetry(expected * np.array([0.96, 0.975, 0.99]))
    yield Check("S_c, nu = 1/2", found, expected, 0.02)


def rolled_disc() -> Iterator[Check]:
    found = bilayers.rolled_curvature(5.0)
    yield Check("larger curvature over k0 at S = 5", found, 1.5, 0.10)


def other_losses_of_symmetry() -> Iterator[Check]:
    for name, nu, expected in (("1/3", 1 / 3, 1.35747), ("0.3", 0.3, 1.40480)):
        near = expected * np.array([0.93, 0.95, 0.97])
        found = bilayers.loss_of_symmetry(near, bilayers.linear_disc(nu))
        yield Check(f"S_c, nu = {name}", found, expected, 0.02)


def flexure() -> Iterator[Check]:
    for profile, tolerance in (("quadratic", 0.005), ("linear", None)):
        curvature, bond = bilayers.flexure(1.06, profile)
        yield Check(f"{profile}: d theta / dX (1/m)", curvature, 39.23298, tolerance)
        yield Check(f"{profile}: stretch of the bond", bond, 0.976057, 0.005 if tolerance else None)


def uniform_curvature() -> Iterator[Check]:
    for name, mesh in _meshes().items():
        ratios = bilayers.small_mismatch_curvature(mesh)
        worst = float(ratios[np.unravel_index(np.abs(ratios - 1).argmax(), ratios.shape)])
        yield Check(f"{name}: curvature of the worst face", worst, 1.0, 1e-3)


def hinges_on_meshes() -> Iterator[Check]:
    meshes_of = {"equilateral": hexagon(12, 0.002), **_meshes()}
    for name, mesh in meshes_of.items():
        tolerance = 0.02 if name in ("equilateral", "unstructured") else None
        yield Check(f"{name}: curvature", bilayers.hinge_curvature(mesh), 1.0, tolerance)


def lattice_ratios() -> Iterator[Check]:
    bending = hinge_lattice.bending_poisson_ratio()
    yield Check("Poisson's ratio in bending", bending, -1 / 3, 3e-3)
    stretching = hinge_lattice.stretching_poisson_ratio()
    yield Check("Poisson's ratio in stretching", stretching, 1 / 3, 0.02)
    for over in (2.5, 2.9, 3.3):
        spans = bilayers.span_ratio(over * 1.15075, HingeSettings())
        yield Check(f"uncut disc at {over:g} S_c: ratio of the spans", spans, 1.0)


def _meshes() -> dict[str, PlanarMesh]:
    grid = np.linspace(-0.02, 0.02, 13)  # m
    return {
        "right-angled": rectangle(grid, grid),
        "jittered": rectangle(grid, grid, jitter=0.25),
        "unstructured": generate_mesh(bilayers.ladder_disc()),
    }


def petals() -> Iterator[Check]:
    stretches = (1.03, 1.06, 1.15)
    specimen, mesh, result = flowers.flower(stretches, 0.003)
    for stretch, shape in zip(stretches, result.position.values, strict=True):
        spread = flowers.petal_spread(specimen, mesh, shape)
        yield Check(f"prestretch {stretch:g}: largest difference", spread, 0.0, 3e-3, 1.0)


def five_fold_branch() -> Iterator[Check]:
    stretches = (1.15, 1.24, 1.28, 1.32, 1.36, 1.38, 1.40)
    specimen, mesh, result = flowers.five_fold(stretches, 0.002)
    for row, stretch in enumerate(stretches):
        spread = flowers.petal_spread(specimen, mesh, result.position.values[row])
        yield Check(f"prestretch {stretch:g}: petals' radii", spread, 0.0, 3e-3, 1.0)
        for count in ("unstable_modes", "iterations"):
            number = float(result[count].values[row])
            yield Check(f"prestretch {stretch:g}: {count.replace('_', ' ')}", number, np.nan)
    touching = np.array(stretches)[result.self_contact_gap.values <= 0]
    first = float(touching.min()) if len(touching) else float("nan")
    yield Check("first of these with self-contact", first, 1.33)


def fine_meshes() -> Iterator[Check]:
    stretches = (1.03, 1.06, 1.15, 1.24)
    coarse, fine = (flowers.flower(stretches, size)[2] for size in (0.00165, 0.00082))
    for row, stretch in enumerate(stretches):
        for name in ("height", "sphere_radius"):
            found, expected = (float(result[name].values[row]) for result in (coarse, fine))
            quantity = f"prestretch {stretch:g}: {name.replace('_', ' ')} (m)"
            yield Check(quantity, found, expected, 5e-3)


def motion_against_statics() -> Iterator[Check]:
    specimen = replace(paper_specimen(), mesh=MeshSize(0.008)).with_milestones([1.03, 1.06, 1.15])
    mesh = generate_mesh(specimen)
    for name, kind in (("morley", MorleySettings), ("hinge", HingeSettings)):
        results, times = [], []
        for method in ("static", "dynamic"):
            begun = time.process_time()
            results.append(solve(specimen, "dshell", kind(method=method), mesh=mesh))
            times.append(time.process_time() - begun)
        distances = compare(*results)["rms_distance_over_radius"].values
        yield Check(f"{name}: largest rms distance / R", float(distances.max()), 0.0, 1e-6, 1.0)
        for result in results:
            total = float(result.iterations.values.sum())
            method = "dynamic" if result is results[1] else "static"
            yield Check(f"{name}, {method}: iterations", total, np.nan)
        yield Check(f"{name}: CPU of the motion over that of statics", times[1] / times[0], np.nan)


def lattice() -> Iterator[Check]:
    for bent, energy in (
        (hinge_lattice.cylinder, np.sqrt(3) / 4),
        (hinge_lattice.sphere, 1 / np.sqrt(3)),
        (hinge_lattice.saddle, 2 / np.sqrt(3)),
    ):
        found = hinge_lattice.lattice_energy(bent)
        yield Check(f"{bent.__name__}: energy per area over k k0^2", found, energy, 3e-3)


def rolled_strip() -> Iterator[Check]:
    for name, turn in (("quarter", np.pi / 2), ("full", 2 * np.pi)):
        x, _, fall = cantilevers.rolled_strip(turn)
        yield Check(f"{name} circle: u / L", x - 1, np.sin(turn) / turn - 1, 5e-3, 1.0)
        yield Check(f"{name} circle: w / L", fall, (1 - np.cos(turn)) / turn, 5e-3, 1.0)


def strip_with_end_moment() -> Iterator[Check]:
    for name, turn in (("quarter", np.pi / 2), ("full", 2 * np.pi)):
        x, _, fall = cantilevers.strip_with_end_moment(turn)
        yield Check(f"{name} circle: u / L", x - 1, np.sin(turn) / turn - 1, 5e-3, 1.0)
        yield Check(f"{name} circle: w / L", fall, (1 - np.cos(turn)) / turn, 5e-3, 1.0)


def heavy_strip() -> Iterator[Check]:
    for weight, drop in ((1, 0.123471), (5, 0.495905), (10, 0.700200)):
        found = cantilevers.heavy_strip(weight)
        yield Check(f"q L^3 / EI = {weight}: drop / L", found, drop, 0.01)


def sheared_strip() -> Iterator[Check]:
    cases = {"half load": (1.604, 4.933), "full load": (3.286, 6.698)}
    tips = cantilevers.sheared_strip((0.5, 1.0))
    for (name, (shortening, rise)), tip in zip(cases.items(), tips, strict=True):
        yield Check(f"strip, {name}: -u", -tip[0], shortening, 0.01)
        yield Check(f"strip, {name}: w", tip[2], rise, 0.01)


def lifted_ring() -> Iterator[Check]:
    meshes = (4, 8, 12)
    rises = np.array(list(cantilevers.lifted_rings(meshes)))
    for end, found, expected in zip("AB", rises.T, (13.891, 17.528), strict=True):
        for radial, rise in zip(meshes[:-1], found[:-1], strict=True):
            yield Check(f"w_{end}, {radial} x {10 * radial} cells", rise, expected)
        last = f"w_{end}, {meshes[-1]} x {10 * meshes[-1]} cells"
        yield Check(last, found[-1], expected, 0.02)


def square_plate() -> Iterator[Check]:
    cells = (10, 20, 50)
    found = [plates.supported_square(n) for n in cells]
    yield from refined("supported, nu = 1/2", cells, found, 0.00406235, 3e-3)


def circular_plates() -> Iterator[Check]:
    rings = (8, 16, 32)
    for nu in (0.3, 0.5):
        found = [plates.supported_disc(n, nu) for n in rings]
        yield from refined(f"supported, nu = {nu}", rings, found, (5 + nu) / (1 + nu), 0.01)
        found = [plates.clamped_disc(n, nu) for n in rings]
        yield from refined(f"clamped, nu = {nu}", rings, found, 1.0, 0.01)


def refined(
    case: str, sizes: Sequence[int], found: Sequence[float], expected: float, tolerance: float
) -> Iterator[Check]:
    """A number on finer and finer meshes, judged on the finest, and its rates of convergence."""
    for size, value in zip(sizes[:-1], found[:-1], strict=True):
        yield Check(f"{case}, 1/{size}", value, expected)
    yield Check(f"{case}, 1/{sizes[-1]}", found[-1], expected, tolerance)
    errors = np.abs(np.array(found) / expected - 1)
    rates = np.log(errors[:-1] / errors[1:]) / np.log(np.divide(sizes[1:], sizes[:-1]))
    for size, rate in zip(sizes[1:], rates, strict=True):
        yield Check(f"{case}, rate to 1/{size}", rate, 2.0, 0.1)


def energies() -> Iterator[Check]:
    specimen, stretch = paper_specimen(), (1.2, 1.1)
    mesh = generate_mesh(bilayers.ladder_disc(specimen.layer("kirigami").pattern, 0.01))
    linear, quadratic = (MorleySettings(profile=name) for name in ("linear", "quadratic"))
    relieved = MorleySettings(walls="relieved")
    models = {
        "morley, relieved walls": MorleyModel(specimen, mesh, relieved),
        "morley, linear": MorleyModel(specimen, mesh, linear),
        "morley, quadratic": MorleyModel(specimen, mesh, quadratic),
        "hinge": HingeModel(specimen, mesh),
    }
    terms = {name: model.energies(stretch) for name, model in models.items()}
    terms["paper"] = rest_state(specimen, mesh, stretch).at(1.0)
    for name, energies_of_model in terms.items():
        extra_dofs = models[name].extra_dofs if name in models else 0
        state = derivatives.rough_dome(mesh, extra_dofs)
        for term in energies_of_model:
            case = f"{name}, {term.name}"
            gradient = derivatives.gradient_error(term, state)
            hessian = derivatives.hessian_error(term, state)
            moved = derivatives.rigid_motion_error(term, state, len(mesh.points))
            yield Check(f"{case}: gradient", gradient, 0.0, 1e-7, 1.0)
            yield Check(f"{case}: Hessian", hessian, 0.0, 1e-7, 1.0)
            yield Check(f"{case}: rigid motion", moved, 0.0, 1e-9, 1.0)


def against_finite_elements() -> Iterator[Check]:
    reference = open_result(FINITE_ELEMENT_RESULT)
    specimen, mesh = result_specimen(reference), result_mesh(reference)
    for walls, tolerances in (
        ("strained", {1.03: 0.0035, 1.06: 0.01}),
        ("relieved", {1.03: 0.001, 1.06: 0.0015}),
    ):
        shell = solve(specimen, "dshell", MorleySettings(walls=walls), mesh=mesh)
        distances = compare(reference, shell)["rms_distance_over_radius"]
        case = "" if walls == "strained" else "walls relieved, "
        for stretch, distance in zip(distances["prestretch"].values, distances.values, strict=True):
            tolerance = tolerances.get(round(float(stretch), 6))
            quantity = f"{case}prestretch {stretch:g}: rms / R"
            yield Check(quantity, float(distance), 0.0, tolerance, 1.0)


def clamped_plate_under_pressure() -> Iterator[Check]:
    for size, tolerance in ((2e-3, None), (1e-3, 0.01)):
        result = solve(clamped_plate.plate_specimen(size), "dshell")
        yield from clamped_plate.checks(result, f"{1e3 * size:g} mm", tolerance)


def inflated_pole() -> Iterator[Check]:
    result = solve(inflated_membrane.membrane_specimen(1e-3), "dshell")
    yield from inflated_membrane.checks(result, "1 mm", 0.01)


def strip_pushed_through() -> Iterator[Check]:
    result = solve(buckled_strip.specimen(2e-3), "dshell")
    yield from buckled_strip.checks(result, "2 mm", 0.02)


def hinged_roofs() -> Iterator[Check]:
    curves = shell_roof.shell_curves(32)
    yield from hinged_roof.against_the_paper(curves, "32 cells a side", 0.02)


def folded_strip() -> Iterator[Check]:
    for cells, tolerance in ((60, 0.01), (120, 0.005)):
        fold = contacts.fold_between_planes(cells)
        case = f"{cells} cells along"
        yield Check(f"{case}: F h^2 / B", fold.force, contacts.FOLD_FORCE, tolerance)
        yield Check(f"{case}: difference of the planes' forces / F", fold.balance, 0, 1e-8, 1.0)
        yield Check(f"{case}: smallest gap / range", fold.gap, math.nan)


def strip_on_a_plane() -> Iterator[Check]:
    lifted = contacts.lifted_strip(60)
    yield Check("pull at the lifted end / (w l / 2)", lifted.pull, 1.0, 0.01)
    yield Check("weight less plane and end / weight", lifted.balance, 0.0, 1e-8, 1.0)
    yield Check("smallest gap / range", lifted.gap, math.nan)


def plates_on_a_plane() -> Iterator[Check]:
    stack = contacts.pressed_plates(8)
    yield Check("force between the plates / load", stack.between, 1.0, 1e-8)
    yield Check("force on the plane / load", stack.below, 1.0, 1e-8)
    yield Check("places that pass through each other", float(stack.crosses), 0.0, 0.0, 1.0)
    yield Check("smallest gap / range", stack.gap, math.nan)


def every_law() -> Iterator[Check]:
    for name, case in LAW_CASES.items():
        for stretch in STRETCHES:
            uniaxial = shell_states.uniaxial_stress(case.law, stretch)
            equibiaxial = shell_states.equibiaxial_stress(case.law, stretch)
            planar = shell_states.planar_stress(case.law, stretch)
            yield from law_checks(name, case, stretch, uniaxial, equibiaxial, planar)


def relaxation() -> Iterator[Check]:
    for name, law in relaxing_layer.LAWS.items():
        found = relaxing_layer.held_error(law)
        yield Check(f"{name}: a strain that is held, forces over g(t)", found, 0.0, 1e-6, 1.0)
    times, found, *given = relaxing_layer.creep(4000)
    apart = np.abs(found / relaxing_layer.exact_creep(times, *given) - 1).max()
    yield Check("creep of a film on a sheet, strain", float(apart), 0.0, 1e-6, 1.0)
    yield from slow_sheets.limits("dshell", 0.006)


def fields() -> Iterator[Check]:
    for name, law in shell_fields.LAWS.items():
        found = shell_fields.uniform_errors(law)
        yield Check(f"{name}: uniform state, stress", found.stress, 0.0, 1e-8, 1.0)
        yield Check(f"{name}: uniform state, energy density", found.energy, 0.0, 1e-10, 1.0)
    yield Check("uneven state, energies", shell_fields.energy_error(), 0.0, 1e-10, 1.0)
    meshes = curved_surfaces.disc_meshes()
    for name in curved_surfaces.SURFACES:
        (mean, gaussian), rates = curved_surfaces.errors_and_rates(name, meshes)
        yield Check(f"{name}, 3 mm: mean curvature, error times R", mean, 0.0, 1.2e-3, 1.0)
        yield Check(f"{name}, 3 mm: Gaussian, error times R^2", gaussian, 0.0, 1.2e-3, 1.0)
        least = 1.0 if name == "saddle" else 2.0
        for which, rate in zip(("mean", "Gaussian"), rates, strict=True):
            missing = max(0.0, least - float(rate))
            yield Check(f"{name}: rate of the {which} curvature, less than {least:g} by", missing,
                        0.0, 0.1, 1.0)  # fmt: skip


def walls() -> Iterator[Check]:
    yield from wall_strip.torsion_checks()
    yield from wall_strip.mesh_checks()


MORLEY, HINGE = "dshell morley", "dshell hinge"

TESTED_RUNGS = (
    Rung(
        4, MORLEY, "Timoshenko strip",
        "80 x 6 mm, prestretched along its length, curvature in the middle third; Timoshenko "
        "(1925), for small mismatch.",
        timoshenko_strip,
    ),
    Rung(
        5, MORLEY, "Bending at finite strain",
        "Rivlin's flexure of a bilayer with its width held, prestretch 1.06 along X. The shell "
        "takes heights as they are in the flat state, so errors of the order of its strains, some "
        "per cent, are expected.",
        flexure,
    ),
    Rung(
        6, MORLEY, "Uniform disc at small mismatch",
        "Curvature of every face over laminate theory's, on three meshes.",
        uniform_curvature,
    ),
    Rung(
        6, HINGE, "Uniform disc at small mismatch",
        "Curvature over laminate theory's. Skewed triangles are outside of what the natural angles "
        "were made for: reported.",
        hinges_on_meshes,
    ),
    Rung(
        6, MORLEY, "Cap of a uniform disc",
        "Scaled curvatures k R^2 / 4h at the mismatch S = k0 R^2 / 4h; von Karman's equations.",
        uniform_cap,
    ),
    Rung(
        7, MORLEY, "Uniform disc loses its symmetry",
        "Where the least stiffness of the cap, at 0.96 to 0.99 S_c, extrapolates to 0; von "
        "Karman's equations.",
        loss_of_symmetry,
    ),
    Rung(
        7, MORLEY, "Uniform disc loses its symmetry, other Poisson's ratios",
        "Layers of the linear law; as above.",
        other_losses_of_symmetry,
    ),
    Rung(
        8, MORLEY, "Uniform disc far beyond: a cylinder",
        "Its curvature at the centre tends to (1 + nu) k0.",
        rolled_disc,
    ),
    Rung(
        9, HINGE, "Lattice of hinges",
        "Equilateral triangles bent to a curvature k0, k the stiffness of a hinge; closed form.",
        lattice,
    ),
    Rung(
        9, HINGE, "What a lattice is instead of a plate",
        "Poisson's ratios of equilateral triangles, closed form; and how long the uncut disc stays "
        "round beyond the S_c = 1.15075 of an incompressible plate.",
        lattice_ratios,
    ),
    Rung(
        10, MORLEY, "Strip with an end moment",
        "The moment E I f / L has the potential -M phi of the end's angle phi. u / L = sin f / f - "
        "1, w / L = (1 - cos f) / f. Errors are over L.",
        strip_with_end_moment,
    ),
    Rung(
        10, MORLEY, "Strip rolled to a full circle",
        "The same by a natural curvature M / EI, which has the same solution.",
        rolled_strip,
    ),
    Rung(
        11, MORLEY, "Heavy cantilever",
        "The elastica under its weight q per length.",
        heavy_strip,
    ),
    Rung(
        12, MORLEY, "Cantilever with end shear",
        "L = 10, b = 1, h = 0.1, E = 1.2e6, nu = 0, P = 4; Sze, Liu and Lo (2004).",
        sheared_strip,
    ),
    Rung(
        12, MORLEY, "Slit annular plate",
        "Radii 6 and 10, h = 0.03, E = 21e6, nu = 0, 0.8 per length on one lip, the other clamped; "
        "Sze, Liu and Lo (2004).",
        lifted_ring,
    ),
    Rung(
        13, MORLEY, "Square plate under pressure",
        "Centre deflection times D / (q a^4), 1/n the size of a cell; Timoshenko and "
        "Woinowsky-Krieger, table 8.",
        square_plate,
    ),
    Rung(
        13, MORLEY, "Circular plates under pressure",
        "Centre deflection times 64 D / (q a^4), 1/n the width of a ring of triangles; Timoshenko "
        "and Woinowsky-Krieger, sections 16 and 17.",
        circular_plates,
    ),
    Rung(
        14, "dshell", "Derivatives and rigid motion of every energy",
        "Largest difference from central differences of fourth order, over the largest entry, on a "
        "rough dome; largest change by a rigid motion.",
        energies,
    ),
    Rung(
        15, MORLEY, "Against the finite-element model",
        "rms distance of the interfaces after rigid alignment, on the mesh of the finite-element "
        "result that `scripts/reproduce` keeps (results/paper/fenics.nc).",
        against_finite_elements,
    ),
    Rung(
        20, MORLEY, "Strip folded between two rigid planes",
        "Contact with planes, without friction; elastica (two-point bend of Matthewson, Kurkjian "
        "and Gulati 1986): F h^2 / B = 2 I^2 = 2.871, h the height of the mid-line, B and F for "
        "each width.",
        folded_strip,
    ),
    Rung(
        20, MORLEY, "Heavy strip on a rigid plane, one end lifted",
        "Beam theory: B d = w l^4 / 24 gives the lifted length l, and the pull is w l / 2.",
        strip_on_a_plane,
    ),
    Rung(
        20, MORLEY, "Two plates pressed onto each other and onto a rigid plane",
        "Contact of the skins of two plates of different meshes under a dead pressure: forces in "
        "balance.",
        plates_on_a_plane,
    ),
    Rung(
        24, MORLEY, "Homogeneous states of every law",
        "Incompressible, in plane stress; closed forms in principal stretches. Planar: nominal "
        "stresses along and across, the width held.",
        every_law,
    ),
)  # fmt: skip

LONG_RUNGS = (
    Rung(
        17, MORLEY, "Clamped circular plate under a follower pressure",
        clamped_plate.WORDS,
        clamped_plate_under_pressure,
    ),
    Rung(
        19, MORLEY, "Inflated circular membrane",
        inflated_membrane.WORDS,
        inflated_pole,
    ),
    Rung(
        17, MORLEY, "Buckled strip pushed through its limit points",
        buckled_strip.WORDS,
        strip_pushed_through,
    ),
    Rung(
        17, MORLEY, "Hinged cylindrical roof",
        hinged_roof.WORDS,
        hinged_roofs,
    ),
    Rung(
        15, MORLEY, "Petals are alike on an unsymmetric mesh",
        "The paper's cut, 3 mm: radii of the petals' tips against their mean.",
        petals,
    ),
    Rung(
        15, MORLEY, "Five-fold branch",
        "The template on a mesh of 2 mm, which comes out five-fold itself: the equilibria that go "
        "on from the stable dome (solver.branch = unstable), stable where they have no unstable "
        "mode. From self-contact on the shapes pass through themselves.",
        five_fold_branch,
    ),
    Rung(
        15, MORLEY, "Meshes of 5 and 20 thousand triangles",
        "The paper's cut: height and radius of the best sphere on the coarser against the finer.",
        fine_meshes,
    ),
    Rung(
        15, "dshell", "Motion against statics",
        "The template at 8 mm: where the damped motion ends against the static equilibrium, and "
        "what each costs.",
        motion_against_statics,
    ),
    Rung(
        22, MORLEY, "Layers that relax",
        "Forces of a strain that is held over the first ones, g(t); creep of a film of 0.6 "
        "exp(-t / 10 s) on an elastic one, closed form in 4000 steps; the paper's specimen at 1.06 "
        "on a mesh of 6 mm, its substrate relaxing to 30 %.",
        relaxation,
    ),
    Rung(
        25, MORLEY, "Fields",
        "Stress of a stretched and sheared sheet, from the law; energy density times volume "
        "against the energies; curvatures of a sphere, a cylinder and a saddle on discs of 40 mm, "
        "by the edge of the mesh.",
        fields,
    ),
    Rung(
        26, MORLEY, "Layers that are relieved at walls",
        "Torsion of a strip, G J over G w t^3 / 3; St. Venant's series. What each wall of a bar of "
        "kirigami on a wide substrate takes from the bar's width, over its thickness: the same on "
        "any mesh and of any width.",
        walls,
    ),
)  # fmt: skip
"""Not among the tests of `scripts/test`, which has their like on coarse meshes."""

SHELL_RUNGS = (*TESTED_RUNGS, *LONG_RUNGS)
