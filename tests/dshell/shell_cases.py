"""Plates, strips and discs with known answers, computed by the Morley shell's own pieces.

Each function returns numbers; the tests say what they must be. SI units.
"""

from dataclasses import dataclass

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
)
from bilayer.mesh_generation import generate_mesh
from dshell.assembly import Assembly, coordinates_of
from dshell.hinge_rest_state import specimen_sections
from dshell.linear_solver import best_linear_solver
from dshell.morley import MorleyFaces
from dshell.morley_model import specimen_layers
from dshell.newton import Body, EquilibriumSolver, NewtonLimits
from dshell.plane_stress import plane_stress_law
from dshell.rigid_motion import held_coordinates
from dshell.through_thickness import Laminate, LinearProfile, ShellLayer

SUBSTRATE = Layer(1e-3, MooneyRivlin(4839.1, 14_536.0))
KIRIGAMI = Layer(1e-3, MooneyRivlin(30_749.0, 30_749.0))


def ladder_disc(cut: CutPattern | None = None, size: float = 0.004) -> Specimen:
    """The verification ladder's specimen: incompressible layers of 1 mm, R = 40 mm."""
    return Specimen(0.04, SUBSTRATE, KIRIGAMI, Prestretch((1.01,)), cut, MeshSize(size))


@dataclass
class Problem:
    """A shell under loads, some of its degrees of freedom held."""

    faces: MorleyFaces
    flat: np.ndarray
    held: np.ndarray
    load: np.ndarray

    def solved(self, tolerance: float = 1e-9, longest_step: float = 1.0, start=None):
        """State in equilibrium under the load, from flat or from another state."""
        assembly = Assembly(len(self.flat), [self.faces.dofs], self.held)
        solver = EquilibriumSolver(assembly, best_linear_solver())
        elastic = np.linalg.norm(solver.residual(Body([self.faces], 0 * self.load), self.flat))
        scale = elastic + np.linalg.norm(self.load)
        outcome = solver.settle(
            [Body([self.faces], self.load)],
            self.flat if start is None else start,
            NewtonLimits(tolerance * scale, 60, longest_step),
        )
        assert outcome.converged, outcome.residual / scale
        return outcome.state


def plate(mesh: PlanarMesh, layers, profile=None) -> tuple[MorleyFaces, np.ndarray]:
    """Faces of some layers on a mesh, and their flat state."""
    laminate = Laminate(layers, LinearProfile() if profile is None else profile)
    faces = MorleyFaces(mesh.points, mesh.triangles, laminate)
    nodes = np.column_stack([mesh.points, np.zeros(len(mesh.points))]).reshape(-1)
    return faces, np.concatenate([nodes, np.zeros(faces.edge_count)])


def single_layer(young_modulus, poisson_ratio, thickness, prestretch=(1.0, 1.0)) -> ShellLayer:
    """A linear layer about its own mid-plane."""
    law = plane_stress_law(LinearElastic(young_modulus, poisson_ratio))
    return ShellLayer("plate", law, -thickness / 2, thickness / 2, np.diag(prestretch))


def rectangle(x, y, jitter=0.0) -> PlanarMesh:
    """Right triangles on a grid, diagonals alternating; inner nodes moved by a share of a cell."""
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=2)
    rng = np.random.default_rng(3)
    cell = np.array([x[1] - x[0], y[1] - y[0]])
    grid[1:-1, 1:-1] += jitter * cell * rng.uniform(-1, 1, grid[1:-1, 1:-1].shape)
    number = np.arange(grid[..., 0].size).reshape(len(x), len(y))
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    even = (np.add.outer(np.arange(len(x) - 1), np.arange(len(y) - 1)) % 2 == 0).ravel()
    first = np.where(even[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    triangles = np.concatenate([first, second])
    return PlanarMesh(grid.reshape(-1, 2), triangles, np.ones(len(triangles)))


def bilayer_faces(specimen: Specimen, mesh: PlanarMesh, stretch, profile=None):
    """Faces of a specimen's layers and their flat state."""
    return plate(mesh, specimen_layers(specimen, mesh, stretch), profile)


def small_mismatch_curvature(mesh: PlanarMesh, stretch: float = 1.00003) -> np.ndarray:
    """Curvature of each face of a uniform bilayer, xx and yy, over laminate theory's."""
    specimen = ladder_disc()
    faces, flat = bilayer_faces(specimen, mesh, (stretch, stretch))
    state = Problem(faces, flat, held_coordinates(mesh), np.zeros(len(flat))).solved(1e-8)
    expected = specimen_sections(specimen, (stretch, stretch))[1].curvature[0]
    return faces.strains(state[faces.dofs])[3:5] / expected


@dataclass
class Cap:
    """A released uncut disc in the scaled curvatures of the von Karman solution."""

    sag: float
    centre: float


def scaled_cap(mismatch: float, size: float = 0.004) -> Cap:
    """The ladder's uncut disc at S = k0 R^2 / 4h = mismatch, h = sqrt(12 (1 - nu^2) D / A)."""
    specimen = ladder_disc(size=size)
    stretch = stretch_of(mismatch)
    mesh = generate_mesh(specimen)
    faces, flat = bilayer_faces(specimen, mesh, (stretch, stretch))
    state = Problem(faces, flat, held_coordinates(mesh), np.zeros(len(flat))).solved()
    nodes = state[: 3 * len(mesh.points)].reshape(-1, 3)
    scale = 0.04**2 / 4 / _equivalent_thickness()
    nodes = nodes - nodes[mesh.centre_node]
    normal = _rim_normal(nodes, mesh)
    sag = np.abs((nodes @ normal)[mesh.rim_nodes]).mean()
    near = np.linalg.norm(mesh.points[mesh.triangles].mean(axis=1), axis=1) < 0.006
    curvature = faces.strains(state[faces.dofs])[3:5, near].mean()
    return Cap(2 * sag / 0.04**2 * scale, curvature * scale)


def stretch_of(mismatch: float) -> float:
    """The prestretch at which the ladder's uncut disc has S = mismatch, by bisection."""
    low, high = 1.0, 1.2
    scale = 0.04**2 / 4 / _equivalent_thickness()
    for _ in range(60):
        middle = (low + high) / 2
        curvature = specimen_sections(ladder_disc(), (middle, middle))[1].curvature[0]
        low, high = (middle, high) if scale * curvature < mismatch else (low, middle)
    return low


def _equivalent_thickness() -> float:
    section = specimen_sections(ladder_disc(), (1.0, 1.0))[1]
    return float(np.sqrt(12 * 0.75 * section.bending / section.stretching))


def _rim_normal(nodes, mesh):
    rim = nodes[mesh.rim_nodes]
    return np.linalg.svd(rim - rim.mean(axis=0))[2][2]


def supported_plate(cells: int, poisson_ratio: float = 0.5) -> float:
    """Centre deflection of a simply supported square plate under pressure, times D / (q a^4)."""
    side, thickness, young, pressure = 1.0, 0.03, 1e6, 0.09  # deflection / thickness = 0.004
    mesh = rectangle(*[np.linspace(0, side, cells + 1)] * 2)
    faces, flat = plate(mesh, [single_layer(young, poisson_ratio, thickness)])
    load = np.zeros(len(flat))
    np.add.at(load, 3 * mesh.triangles + 2, pressure * mesh.areas[:, None] / 3)
    corner = coordinates_of(np.array([0, cells * (cells + 1)]))
    held = np.concatenate([3 * mesh.rim_nodes + 2, corner[0, :2], corner[1, 1:2]])
    state = Problem(faces, flat, held, load).solved(1e-6)
    bending = young * thickness**3 / 12 / (1 - poisson_ratio**2)
    middle = np.argmin(np.linalg.norm(mesh.points - side / 2, axis=1))
    return float(state[3 * middle + 2] * bending / pressure / side**4)


def cantilever(length, width, thickness, young, load_per_area=0.0, mismatches=(0.0,), cells=40):
    """A clamped strip, nu = 0, heavy, of two like layers, the lower one stretched more and more.

    The clamp is a column of rigid faces that are held.
    Returns the mid-line's points from clamp to tip, (cells + 1, 3).
    """
    step = length / cells
    mesh = rectangle(np.arange(-1, cells + 1) * step, np.linspace(-width / 2, width / 2, 3))
    law = plane_stress_law(LinearElastic(young, 0.0))
    upper = ShellLayer("upper", law, 0.0, thickness / 2, np.eye(2))
    clamped = np.flatnonzero(mesh.points[:, 0] < step / 2)
    rigid = plane_stress_law(LinearElastic(1e3 * young, 0.0))
    before = np.flatnonzero(np.isin(mesh.triangles, clamped).all(axis=1))
    clamp = ShellLayer("clamp", rigid, -thickness / 2, thickness / 2, np.eye(2), before)
    held = coordinates_of(clamped).reshape(-1)
    state = None
    for mismatch in mismatches:
        lower = ShellLayer("lower", law, -thickness / 2, 0.0, np.diag([1 + mismatch, 1.0]))
        faces, flat = plate(mesh, [lower, upper, clamp])
        load = np.zeros(len(flat))
        np.add.at(load, 3 * mesh.triangles + 2, -load_per_area * mesh.areas[:, None] / 3)
        state = Problem(faces, flat, held, load).solved(1e-7, length / 4, state)
    nodes = state[: 3 * len(mesh.points)].reshape(-1, 3)
    return nodes[np.abs(mesh.points[:, 1]) < width / 8][1:]


def timoshenko_strip(stretch: float, cells: int = 80) -> float:
    """Curvature of a strip of 80 x 6 mm in its middle third, prestretched along its length, 1/m."""
    mesh = rectangle(np.linspace(-0.04, 0.04, cells + 1), np.linspace(-0.003, 0.003, 7))
    faces, flat = bilayer_faces(ladder_disc(), mesh, (stretch, 1.0))
    state = Problem(faces, flat, held_coordinates(mesh), np.zeros(len(flat))).solved()
    middle = np.abs(mesh.points[mesh.triangles].mean(axis=1)[:, 0]) < 0.04 / 3
    areas = mesh.areas[middle]
    return float(faces.strains(state[faces.dofs])[3, middle] @ areas / areas.sum())


def petal_radii(specimen: Specimen, mesh: PlanarMesh, shape) -> np.ndarray:
    """Distance of the rim from the axis in the middle of each strip, m."""
    angle = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
    strips = specimen.cut.strips
    rim = mesh.rim_nodes
    radii = np.linalg.norm(shape[:, :2] - shape[mesh.centre_node, :2], axis=1)
    places = []
    for k in range(strips):
        off = np.angle(np.exp(1j * (angle[rim] - 2 * np.pi * k / strips)))
        order = np.argsort(off)
        places.append(np.interp(0.0, off[order], radii[rim][order]))
    return np.array(places)
