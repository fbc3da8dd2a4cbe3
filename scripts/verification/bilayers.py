"""Bilayers of the ladder: discs, cut discs and strips released by a prestretch. SI units.

Scaled as in the von Karman solution of the uncut disc: curvature k R^2 / 4h and mismatch
S = k0 R^2 / 4h, with h = sqrt(12 (1 - nu^2) D / A) and laminate theory's k0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bilayer import (
    CutPattern,
    Layer,
    LinearElastic,
    MeshSize,
    MooneyRivlin,
    PlanarMesh,
    Prestretch,
    Specimen,
    disc_bilayer,
    solve,
)
from bilayer.errors import ComputationError
from bilayer.mesh.generation import generate_mesh
from dshell import HingeSettings, MorleySettings
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.through_thickness import PROFILES
from dshell.models.hinge_rest_state import specimen_sections
from dshell.models.morley import specimen_layers
from dshell.release.rigid_motion import choose_far_nodes, held_coordinates
from verification.meshes import outline_of, rectangle
from verification.shell_problem import Problem, nodes_of, plate

SUBSTRATE = Layer("substrate", 1e-3, MooneyRivlin(4839.1, 14_536.0))
KIRIGAMI = Layer("kirigami", 1e-3, MooneyRivlin(30_749.0, 30_749.0))
RADIUS = 0.04
CENTRE = 0.006  # radius within which curvature counts as the centre's


def ladder_disc(cut: CutPattern | None = None, size: float = 0.004) -> Specimen:
    """The verification ladder's specimen: incompressible layers of 1 mm, R = 40 mm."""
    return disc_bilayer(RADIUS, SUBSTRATE, KIRIGAMI, Prestretch((1.01,)), cut, MeshSize(size))


def thin_disc(size: float = 0.004) -> Specimen:
    """The ladder's uncut disc with layers of 0.25 mm: 16 times less strain at the same S."""
    disc = ladder_disc(size=size)
    layers = tuple(replace(layer, thickness=layer.thickness / 4) for layer in disc.layers)
    return replace(disc, layers=layers)


def linear_disc(poisson_ratio: float, size: float = 0.003) -> Specimen:
    """The ladder's uncut disc of linear layers with one Poisson's ratio."""
    layers = (
        replace(layer, material=LinearElastic(layer.material.young_modulus, poisson_ratio))
        for layer in (SUBSTRATE, KIRIGAMI)
    )
    return disc_bilayer(RADIUS, *layers, Prestretch((1.01,)), None, MeshSize(size))


def bilayer_faces(specimen: Specimen, mesh: PlanarMesh, stretch, profile="linear"):
    """Faces of a specimen's layers and their flat state."""
    return plate(mesh, specimen_layers(specimen, mesh, stretch), profile)


def small_mismatch_curvature(mesh: PlanarMesh, stretch: float = 1.00003) -> np.ndarray:
    """Curvature of each face of a uniform bilayer, xx and yy, over laminate theory's."""
    specimen = ladder_disc()
    faces, flat = bilayer_faces(specimen, mesh, (stretch, stretch))
    held = held_coordinates(choose_far_nodes(mesh))
    state = Problem(faces, flat, held, np.zeros(len(flat))).solved(1e-8)
    expected = specimen_sections(specimen, (stretch, stretch))[1].curvature[0]
    return faces.at(state).strains[3:5] / expected


@dataclass
class Cap:
    """A released uncut disc in the scaled curvatures of the von Karman solution."""

    sag: float
    centre: float


def scaled_cap(mismatch: float, size: float = 0.004) -> Cap:
    """A thin uncut disc at a mismatch S below the loss of its symmetry.

    Thin, because the von Karman solution is that of vanishing strain.
    """
    disc = thin_disc(size)
    mesh = generate_mesh(disc)
    faces, state = _released(disc, mesh, mismatch)
    nodes = nodes_of(state, mesh)
    nodes = nodes - nodes[mesh.centre_node]
    normal = _rim_normal(nodes, mesh)
    sag = np.abs((nodes @ normal)[mesh.rim_nodes]).mean()
    curvature = _centre_curvatures(faces, state, mesh).mean()
    return Cap(2 * sag / RADIUS**2 * _scale(disc), curvature * _scale(disc))


def loss_of_symmetry(mismatches: Sequence[float], specimen: Specimen | None = None) -> float:
    """The mismatch S at which an uncut disc's cap becomes unstable; the ladder's if left out.

    The least stiffness of the cap falls to 0 there: a parabola through it at mismatches before.
    (At S_c the shell resists nothing, and beyond it can roll up about any axis.)
    """
    disc = ladder_disc() if specimen is None else specimen
    mesh = generate_mesh(disc)
    stiffness = [_least_stiffness(disc, mesh, mismatch) for mismatch in mismatches]
    zeros = np.roots(np.polyfit(mismatches, stiffness, 2))
    beyond = [zero.real for zero in zeros if np.isreal(zero) and zero.real > max(mismatches)]
    if not beyond:
        raise ComputationError("the least stiffness of the cap does not fall to 0")
    return float(min(beyond))


def span_ratio(mismatch: float, settings: MorleySettings | HingeSettings | None = None) -> float:
    """The larger over the smaller horizontal span of the uncut disc's stable shape at S."""
    specimen = ladder_disc().with_milestones([stretch_of(mismatch)])
    result = solve(specimen, "dshell", MorleySettings() if settings is None else settings)
    if not result.converged.values.all() or result.unstable_modes.values.any():
        raise ComputationError(f"no stable shape at S = {mismatch:.4f}")
    x, y, _ = result.span.values[0]
    return float(max(x, y) / min(x, y))


def rolled_curvature(mismatch: float, size: float = 0.004) -> float:
    """The larger principal curvature at the centre of the uncut disc at S, over k0."""
    disc = ladder_disc(size=size)
    mesh = generate_mesh(disc)
    state = None
    for on_the_way in mismatch * np.array([0.3, 0.5, 0.7, 1.0]):
        faces, state = _released(disc, mesh, float(on_the_way), state)
    return float(_centre_curvatures(faces, state, mesh).max() * _scale(disc) / mismatch)


def stretch_of(mismatch: float, specimen: Specimen | None = None) -> float:
    """The prestretch at which an uncut disc, the ladder's if none, has S = mismatch."""
    disc = ladder_disc() if specimen is None else specimen
    low, high = 1.0, 1.2
    scale = _scale(disc)
    for _ in range(60):  # bisection
        middle = (low + high) / 2
        curvature = specimen_sections(disc, (middle, middle))[1].curvature[0]
        low, high = (middle, high) if scale * curvature < mismatch else (low, middle)
    return low


def _scale(specimen: Specimen) -> float:
    """R^2 / 4h, m, for two layers of one Poisson's ratio."""
    section = specimen_sections(specimen, (1.0, 1.0))[1]
    plane = 1 - specimen.layer("substrate").material.poisson_ratio ** 2
    return float(RADIUS**2 / 4 / np.sqrt(12 * plane * section.bending / section.stretching))


def _uncut(disc: Specimen, mesh: PlanarMesh, mismatch: float) -> Problem:
    stretch = stretch_of(mismatch, disc)
    faces, flat = bilayer_faces(disc, mesh, (stretch, stretch))
    return Problem(faces, flat, held_coordinates(choose_far_nodes(mesh)), np.zeros(len(flat)))


def _released(
    disc: Specimen, mesh: PlanarMesh, mismatch: float, start: np.ndarray | None = None
) -> tuple[MorleyFaces, np.ndarray]:
    """Faces and stable state of an uncut disc at S, from flat or from another state."""
    problem = _uncut(disc, mesh, mismatch)
    # a round disc rolls up about any axis alike, so this can take many iterations
    state = problem.solved(longest_step=RADIUS / 4, iterations=200, start=start)
    if problem.unstable_modes(state):
        raise ComputationError(f"the shape at S = {mismatch:.4f} is not stable")
    return problem.faces, state


def _least_stiffness(disc: Specimen, mesh: PlanarMesh, mismatch: float) -> float:
    """Eigenvalue nearest to 0 of the Hessian of an uncut disc at S, N/m."""
    problem = _uncut(disc, mesh, mismatch)
    return problem.least_stiffness(problem.solved(longest_step=RADIUS / 4))


def _centre_curvatures(faces, state, mesh: PlanarMesh) -> np.ndarray:
    """The two principal curvatures at the centre, ascending, 1/m."""
    near = np.linalg.norm(mesh.points[mesh.triangles].mean(axis=1), axis=1) < CENTRE
    xx, yy, twice_xy = faces.at(state).strains[3:, near].mean(axis=1)
    return np.linalg.eigvalsh([[xx, twice_xy / 2], [twice_xy / 2, yy]])


def _rim_normal(nodes, mesh):
    rim = nodes[mesh.rim_nodes]
    return np.linalg.svd(rim - rim.mean(axis=0))[2][2]


def timoshenko_strip(stretch: float, cells: int = 80) -> float:
    """Curvature of a strip of 80 x 6 mm in its middle third, prestretched along its length, 1/m."""
    mesh = rectangle(np.linspace(-0.04, 0.04, cells + 1), np.linspace(-0.003, 0.003, 7))
    faces, flat = bilayer_faces(ladder_disc(), mesh, (stretch, 1.0))
    state = Problem(
        faces, flat, held_coordinates(choose_far_nodes(mesh)), np.zeros(len(flat))
    ).solved()
    middle = np.abs(mesh.points[mesh.triangles].mean(axis=1)[:, 0]) < 0.04 / 3
    areas = mesh.areas[middle]
    return float(faces.at(state).strains[3, middle] @ areas / areas.sum())


def flexure(stretch: float, profile="linear", cells: int = 40) -> tuple[float, float]:
    """Angle per length, 1/m, and stretch of the bond of a bilayer that is bent with its width held.

    The width is held by the nodes' y, the prestretch is along x only; in the middle third.
    """
    mesh = rectangle(np.linspace(-0.02, 0.02, cells + 1), np.linspace(-0.001, 0.001, 3))
    width = 3 * np.arange(len(mesh.points)) + 1
    centre, far, _ = choose_far_nodes(mesh)
    held = np.concatenate([width, [3 * centre, 3 * centre + 2, 3 * far + 2]])
    faces, flat = bilayer_faces(ladder_disc(), mesh, (stretch, 1.0), profile)
    problem = Problem(faces, flat, held, np.zeros(len(flat)))
    state = problem.solved(longest_step=mesh.points.max() / 4)
    if problem.unstable_modes(state):
        raise ComputationError("the bent strip is not stable")
    middle = np.abs(mesh.points[mesh.triangles].mean(axis=1)[:, 0]) < 0.02 / 3
    strain, _, _, curvature, _, _ = faces.at(state).strains[:, middle].mean(axis=1)
    height = faces.laminate.layers[0].top  # of the bond over the surface
    at_bond = strain + height * curvature + PROFILES[profile] * (height * curvature) ** 2 / 2
    return float(curvature), float(np.sqrt(1 + 2 * at_bond))


def hinge_curvature(mesh: PlanarMesh, stretch: float = 1.0005) -> float:
    """Curvature of a uniform bilayer of hinges, by a paraboloid, over laminate theory's."""
    sheet = replace(ladder_disc(), outline=outline_of(mesh))
    specimen = sheet.with_milestones([stretch])
    shape = solve(specimen, "dshell", HingeSettings(), mesh=mesh).position.values[0]
    x, y, z = shape.T
    terms = np.column_stack([np.ones_like(x), x, y, x**2 + y**2])
    fitted = -2 * np.linalg.lstsq(terms, z, rcond=None)[0][3]
    return float(fitted / specimen_sections(specimen, (stretch, stretch))[1].curvature[0])


def petal_radii(specimen: Specimen, mesh: PlanarMesh, shape) -> np.ndarray:
    """Distance of the rim from the axis in the middle of each strip, m."""
    angle = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
    strips = specimen.layer("kirigami").pattern.strips
    rim = mesh.rim_nodes
    radii = np.linalg.norm(shape[:, :2] - shape[mesh.centre_node, :2], axis=1)
    places = []
    for k in range(strips):
        off = np.angle(np.exp(1j * (angle[rim] - 2 * np.pi * k / strips)))
        order = np.argsort(off)
        places.append(np.interp(0.0, off[order], radii[rim][order]))
    return np.array(places)
