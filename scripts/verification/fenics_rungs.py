"""The ladder of the finite-element model: every case with its reference and tolerance."""

from collections.abc import Iterator

import numpy as np

from bilayer import solve
from fenics_model.settings import SolidSettings
from verification import (
    clamped_plate,
    hinged_roof,
    inflated_membrane,
    lying_sheet,
    relaxing_solid,
    shell_roof,
    slow_sheets,
    solid_derivatives,
    solid_discs,
    solid_fields,
    solid_roof,
    solid_states,
    solid_strips,
    wall_strip_solid,
)
from verification.laws import LAW_CASES, STRETCHES, law_checks
from verification.rung import Check, Rung

DISC_SIZE = 0.008  # m, of the discs' meshes: quadratic displacements need no finer one
ROLLED_SIZE = 0.006
CRITICAL = 1.15075  # S at which the incompressible disc loses its symmetry


def homogeneous() -> Iterator[Check]:
    tape = solid_states.block(solid_states.TAPE)
    for stretch, nominal, cauchy in ((1.06, 6307.92, 14_037.14), (1.24, 19_530.72, 60_612.61)):
        found = solid_states.uniaxial_stress(tape, stretch)
        yield Check(f"uniaxial, {stretch:g}: nominal stress (Pa)", found, nominal, 1e-6)
        along_x, _ = solid_states.equibiaxial_stress(tape, stretch)
        yield Check(f"equibiaxial, {stretch:g}: Cauchy stress (Pa)", along_x, cauchy, 1e-6)


def patch() -> Iterator[Check]:
    found = solid_states.compressible_patch()
    yield Check("J", found.volume_ratio, 1.068152, 1e-8)
    yield Check("W (J/m3)", found.energy_density, 4912.431674, 1e-8)
    for (i, j), value in {(0, 0): 132341.4487, (0, 1): 4765.5975, (2, 2): 137236.8145}.items():
        yield Check(f"P{i + 1}{j + 1} (Pa)", found.stress[i, j], value, 1e-8)
    yield Check("rms of grad(x) less its mean", found.unevenness, 0.0, 1e-8, 1.0)


def patch_of_every_law() -> Iterator[Check]:
    d1 = solid_states.COMPRESSIBLE_TAPE.d1
    for name, case in LAW_CASES.items():
        found = solid_states.compressible_patch(case.compressible(d1))
        energy, stress = case.first_piola(solid_states.PATCH_GRADIENT, d1)
        yield Check(f"{name}: W (J/m3)", found.energy_density, energy, 1e-8)
        apart = float(np.abs(found.stress - stress).max())
        yield Check(f"{name}: P, largest error (Pa)", apart, 0.0, 1e-8, float(stress.max()))
        yield Check(f"{name}: rms of grad(x) less its mean", found.unevenness, 0.0, 1e-8, 1.0)


def every_law() -> Iterator[Check]:
    for name, case in LAW_CASES.items():
        solid = solid_states.block(case.law)
        for stretch in STRETCHES:
            along_x, _ = solid_states.equibiaxial_stress(solid, stretch)
            uniaxial = solid_states.uniaxial_stress(solid, stretch)
            planar = solid_states.planar_stress(solid, stretch)
            yield from law_checks(name, case, stretch, uniaxial, along_x, planar)


def locking() -> Iterator[Check]:
    cells = (5, 10, 20)
    for poisson_ratio in (0.48, 0.49, 0.499, 0.5):
        case = f"nu = {poisson_ratio:g}"
        found = [solid_strips.Cantilever(poisson_ratio, cells=n).energy_ratio() for n in cells]
        for n, ratio in zip(cells[:-1], found[:-1], strict=True):
            yield Check(f"{case}, elements of {80 / n:g} mm", ratio, 1.0)
        yield Check(f"{case}, elements of {80 / cells[-1]:g} mm", found[-1], 1.0, 0.02)


def timoshenko_strip() -> Iterator[Check]:
    for stretch, curvature, tolerance in ((1.01, 6.793, 0.01), (1.03, 19.985, None)):
        found = solid_strips.timoshenko_strip(stretch)
        yield Check(f"curvature at prestretch {stretch:g} (1/m)", found, curvature, tolerance)


def flexure() -> Iterator[Check]:
    exact_angle, exact_radius = solid_strips.flexure(1.06)
    yield Check("exact solution: d theta / dX (1/m)", exact_angle, 39.23298, 1e-5)
    exact_stretch, errors = exact_angle * exact_radius, []
    for cells in (20, 40):
        angle, stretch = solid_strips.flexed_strip(1.06, cells)
        case = f"elements of {40 / cells:g} mm"
        yield Check(f"{case}: d theta / dX (1/m)", angle, exact_angle, 0.005)
        yield Check(f"{case}: interface stretch", stretch, exact_stretch, 0.005)
        errors.append(abs(stretch - exact_stretch))
    yield Check("interface stretch, rate", np.log2(errors[0] / errors[1]), 2.0, 0.1)


def uniform_cap() -> Iterator[Check]:
    expected = {0.2: (0.19407, 0.19092), 0.5: (0.43398, 0.40071), 1.0: (0.71125, 0.57980)}
    caps = solid_discs.scaled_caps(list(expected), DISC_SIZE)
    for (mismatch, (sag, centre)), cap in zip(expected.items(), caps, strict=True):
        yield Check(f"S = {mismatch:g}: curvature by the sag", cap.sag, sag, 0.01)
        yield Check(f"S = {mismatch:g}: curvature at the centre", cap.centre, centre, 0.01)


def loss_of_symmetry() -> Iterator[Check]:
    found = solid_discs.loss_of_symmetry(CRITICAL * np.array([0.94, 0.96, 0.98]), DISC_SIZE)
    yield Check("S_c, nu = 1/2", found, CRITICAL, 0.02)
    result = solid_discs.two_fold(1.02 * CRITICAL, DISC_SIZE)
    ratios = [max(x, y) / min(x, y) for x, y, _ in result["span"].values]
    yield Check("ratio of the spans at 0.99 S_c", ratios[0], 1.0, 2e-3)
    yield Check("the same at 1.02 S_c: no longer round", ratios[1], 1.0)
    modes = result["branch_unstable_modes"].values[1]
    yield Check("unstable modes of the cap at 1.02 S_c", modes[0], 2, 0.0)
    yield Check("of the shape taken there", float(result["unstable_modes"][1]), 0, 0.0, 1.0)
    left, *found_energies = result["branch_energy"].values[1]
    yield Check("its energy over the cap's", min(found_energies) / left, 1.0)


def rolled_disc() -> Iterator[Check]:
    found = solid_discs.rolled_curvature(5.0, ROLLED_SIZE)
    yield Check("larger curvature over k0 at S = 5", found, 1.5, 0.10)


def heavy_strip() -> Iterator[Check]:
    expected = {1.0: 0.123471, 5.0: 0.495905, 10.0: 0.700200}
    strip = solid_strips.Cantilever(0.5, thickness=0.5e-3)
    for (weight, drop), found in zip(expected.items(), strip.weighed(list(expected)), strict=True):
        yield Check(f"q L^3 / D = {weight:g}: drop / L", found, drop, 0.01)


def sheet_on_a_table() -> Iterator[Check]:
    yield from lying_sheet.lying_sheet("fenics", SolidSettings(contact="barrier"), 1e-8)


def energies() -> Iterator[Check]:
    for name, pair in solid_derivatives.PAIRS.items():
        strained = solid_derivatives.strained_solid(pair)
        residual, tangent = solid_derivatives.derivative_errors(*strained)
        yield Check(f"{name}: residual", residual, 0.0, 1e-7, 1.0)
        yield Check(f"{name}: tangent", tangent, 0.0, 1e-7, 1.0)
        moved = solid_derivatives.rigid_motion_error(*strained)
        yield Check(f"{name}: rigid motion", moved, 0.0, 1e-9, 1.0)
    apart = solid_derivatives.ranks_difference()
    yield Check("paper's specimen, 12 mm mesh, 1.03: two ranks and one (m)", apart, 0.0, 1e-9, 1.0)


def clamped_plate_under_pressure() -> Iterator[Check]:
    result = solve(clamped_plate.plate_specimen(2.5e-3), "fenics")
    yield from clamped_plate.checks(result, "2.5 mm", 0.01)


def hinged_roofs() -> Iterator[Check]:
    curves = solid_roof.solid_curves(10)
    yield from hinged_roof.against_the_paper(curves, "10 cells a side of a quarter", 0.02)
    shell = shell_roof.shell_curves(40)
    yield from hinged_roof.beyond(curves, shell, "10 cells, the shell's", 0.04)


def membrane() -> Iterator[Check]:
    shell = solve(inflated_membrane.membrane_specimen(1e-3), "dshell")
    for size, tolerance in ((4e-3, None), (2e-3, 0.01)):
        result = solve(inflated_membrane.membrane_specimen(size), "fenics")
        case = f"{1e3 * size:g} mm"
        yield from inflated_membrane.checks(result, case, tolerance)
        rises = zip(*map(inflated_membrane.rises, (result, shell)), strict=True)
        for pressure, pair in zip(inflated_membrane.PRESSURES, rises, strict=True):
            judged = tolerance if pressure > 100 else None
            yield Check(f"{case}, {pressure:g} Pa: rise, the shell's (m)", *pair, judged)


def relaxation() -> Iterator[Check]:
    two, one = relaxing_solid.TWO_TERMS, relaxing_solid.ONE_TERM
    steps = (0.1, 0.5, 7.0, 30.0, 300.0)
    block = relaxing_solid.RelaxingBlock(solid_states.COMPRESSIBLE_TAPE, two)
    stress = np.array(block.held(1.2, steps))
    left = two.stress_left(np.cumsum([0.0, *steps]))
    apart = float(np.abs(stress / stress[0] / left - 1).max())
    yield Check("stretched to 1.2 and held: stress over g(t)", apart, 0.0, 1e-6, 1.0)
    coarse, fine = (
        relaxing_solid.RelaxingBlock(solid_states.TAPE, one).creep(40.0, n) for n in (40, 80)
    )
    exact = relaxing_solid.exact_creep(np.linspace(0.0, 40.0, 41), one)
    apart = float(np.abs((4 * fine[::2] - coarse) / 3 / exact - 1).max())
    yield Check("creep under its weight, steps extrapolated: sag", apart, 0.0, 1e-6, 1.0)
    errors = [np.abs(found / exact - 1).max() for found in (coarse, fine[::2])]
    yield Check("creep, power of the step", float(np.log2(errors[0] / errors[1])), 2.0, 0.1)
    yield from slow_sheets.limits("fenics", 0.006)
    yield from slow_sheets.solvers_apart()


def fields() -> Iterator[Check]:
    for elements in (1, 2, 3):
        found, case = solid_fields.uniform_errors(elements), f"uniform state, {elements} through"
        for name, error in vars(found).items():
            yield Check(f"{case}: {name}", float(error), 0.0, 1e-8, 1.0)
    missing = max(0.0, 2.0 - solid_fields.bent_stress_rate())
    case = "sheet bent to a cylinder, stress: power of the edge, less than 2 by"
    yield Check(case, missing, 0.0, 0.1, 1.0)
    yield Check("uneven state, energies", solid_fields.energy_error(), 0.0, 1e-10, 1.0)


def walls() -> Iterator[Check]:
    yield from wall_strip_solid.checks()


SOLID = "fenics solid"

FENICS_RUNGS = (
    Rung(
        1, SOLID, "Homogeneous Mooney-Rivlin",
        "An incompressible block of the substrate's tape; uniaxial nominal stress "
        "2 (l - l^-2)(C10 + C01 / l), equibiaxial Cauchy stress 2 (l^2 - l^-4)(C10 + C01 l^2).",
        homogeneous,
    ),
    Rung(
        2, SOLID, "Compressible patch test",
        "A distorted mesh under a uniform deformation of its boundary; closed form.",
        patch,
    ),
    Rung(
        2, SOLID, "Compressible patch test, every law",
        "The same deformation; closed form in principal stretches. The error of P is over its "
        "largest entry.",
        patch_of_every_law,
    ),
    Rung(
        3, SOLID, "Thickness locking",
        "A homogeneous cantilever of 80 x 1 mm, one element thick, its width held, under its "
        "weight: strain energy over that of the plate in plane strain, q^2 L^5 / 40 D.",
        locking,
    ),
    Rung(
        4, SOLID, "Timoshenko strip",
        "80 x 6 mm, prestretched along its length, curvature in the middle third; Timoshenko "
        "(1925), for small mismatch.",
        timoshenko_strip,
    ),
    Rung(
        5, SOLID, "Bilayer bending at finite strain",
        "A strip of 40 mm prestretched along its length by 1.06, its width held; Rivlin's flexure.",
        flexure,
    ),
    Rung(
        6, SOLID, "Cap of a uniform disc",
        "Scaled curvatures k R^2 / 4h at the mismatch S = k0 R^2 / 4h; von Karman's equations.",
        uniform_cap,
    ),
    Rung(
        7, SOLID, "Uniform disc loses its symmetry",
        "Where the least stiffness of the cap, at 0.94 to 0.98 S_c, extrapolates to 0; von "
        "Karman's equations. Beyond, without an imperfection, the search along the unstable mode "
        "finds the two-fold shape.",
        loss_of_symmetry,
    ),
    Rung(
        8, SOLID, "Uniform disc far beyond: a cylinder",
        "Its curvature at the centre tends to (1 + nu) k0. The mismatch along y is 2 % less, so "
        "that the disc knows about which axis to roll; the shell's shape is the first guess.",
        rolled_disc,
    ),
    Rung(
        11, SOLID, "Heavy cantilever",
        "80 x 0.5 mm, its width held, incompressible, D = E h^3 / 12 (1 - nu^2); the elastica "
        "under its weight q per area.",
        heavy_strip,
    ),
    Rung(
        14, SOLID, "Derivatives and rigid motion of every energy, two ranks",
        "Relative differences from central differences of fourth order, in a state of finite "
        "strain; relative changes by a rigid motion; largest distance of two shapes.",
        energies,
    ),
    Rung(
        17, SOLID, "Clamped circular plate under a follower pressure",
        clamped_plate.WORDS,
        clamped_plate_under_pressure,
    ),
    Rung(
        17, SOLID, "Hinged cylindrical roof",
        hinged_roof.WORDS + " Beyond the first limit point against the shell.",
        hinged_roofs,
    ),
    Rung(
        19, SOLID, "Inflated circular membrane",
        inflated_membrane.WORDS + " Its rise against that of the shell on a mesh of 1 mm.",
        membrane,
    ),
    Rung(
        20, SOLID, "Heavy sheet on a table",
        "examples/on_a_table.toml at 1.02, a mesh of 8 mm: it stands on its rim, and the table "
        "bears its weight.",
        sheet_on_a_table,
    ),
    Rung(
        22, SOLID, "Layers that relax",
        "A block that is stretched at once and held, g(t); one of 0.6 exp(-t / 10 s) that creeps "
        "under its weight, closed form; the paper's specimen at 1.06, its substrate relaxing to "
        "30 %: on a mesh of 6 mm the limits, on one of 4 mm the shell beside it.",
        relaxation,
    ),
    Rung(
        25, SOLID, "Fields",
        "A sheet that is stretched, sheared and turned, closed form, largest errors; one bent to a "
        "cylinder; energy density times volume against the energies.",
        fields,
    ),
    Rung(
        24, SOLID, "Homogeneous states of every law",
        "An incompressible block; closed forms in principal stretches. Planar: nominal stresses "
        "along and across, the width held.",
        every_law,
    ),
    Rung(
        26, SOLID, "Layers that are relieved at walls",
        "A bar of kirigami on a wide substrate of the published bistable sheets, small mismatch, "
        "its length held. By laminate theory the two sides of the strip lie at an angle of the "
        "bar's natural curvature times its width. Told is the width that each wall takes from the "
        "bar, over its thickness; negative: it adds to it. The reference is the shell with "
        "walls = 'relieved'; that of the shell without is 0.",
        walls,
    ),
)  # fmt: skip
