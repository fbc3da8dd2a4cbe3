"""Strips of the finite-element model that bend in one plane: bilayers, plates under load. SI units.

A strip runs along x. Its width is one element where it is held (plane strain).
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bilayer import MooneyRivlin
from bilayer.specimen.support import choose_nodes_inside
from fenics_model.release.specimen_solid import held_points, natural_state
from fenics_model.solid.state import State
from fenics_model.solve.newton import Newton
from verification.solid_problem import (
    equilibria,
    held_where,
    load_path,
    newton_of,
    push,
    rectangle,
    solid_of,
    stacked,
)

Array = NDArray[np.float64]
SUBSTRATE, KIRIGAMI = MooneyRivlin(4839.1, 14536.0), MooneyRivlin(30749.0, 30749.0)
THICKNESS = 1e-3  # of each layer of the bilayers
ROUND_OFF = 1e-7  # of the residual of a light plate, over its weight


def flexure(stretch: float) -> tuple[float, float]:
    """Angle per bonded length, 1/m, and the interface's radius, m, of Rivlin's flexure.

    Incompressible, each fibre an arc, plane strain across the width: the two numbers minimise the
    energy of a bilayer prestretched along x.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    depth = THICKNESS * (nodes + 1) / 2  # from the interface outward, natural

    def energy(unknowns):
        angle, radius = unknowns[0] * 40, unknowns[1] / 40
        total = 0.0
        for law, prestretch, sign in ((SUBSTRATE, stretch, -1), (KIRIGAMI, 1.0, 1)):
            # volume kept: r dr = dZ / (angle prestretch), Z the natural thickness
            r = np.sqrt(radius**2 + sign * 2 * depth / (angle * prestretch))
            hoop = r * angle * prestretch
            density = (law.c10 + law.c01) * (hoop**2 + hoop**-2 - 2)
            total += (weights @ density) * THICKNESS / 2 / prestretch
        return total

    found = minimize(energy, [1.0, 1.0], method="Nelder-Mead",
                     options={"xatol": 1e-10, "fatol": 1e-16, "maxiter": 4000})  # fmt: skip
    return found.x[0] * 40, found.x[1] / 40


def flexed_strip(stretch: float, cells: int = 40, length: float = 40e-3) -> tuple[float, float]:
    """Angle per bonded length, 1/m, and stretch of the interface, of a strip with its width held.

    Measured in the middle third, a chord an element.
    """
    mesh = rectangle(length, 1e-3, cells, 1)
    volume = stacked(mesh, [THICKNESS, THICKNESS])
    solid = solid_of(volume, [SUBSTRATE, KIRIGAMI])
    edge = np.flatnonzero(mesh.points[:, 1] == 0)
    first, last = volume.reference_surface[edge[[0, -1]]]
    held = [
        held_where(solid, 1, lambda x: np.full(x.shape[1], True)),
        *solid.held_points([(first, 0), (first, 2), (last, 2)]),
    ]
    with newton_of(solid, held) as newton:
        released = _release_along_x(newton, stretch, first_step=0.002)
    line = solid.vertex_positions(released)[volume.reference_surface[edge]][:, [0, 2]]
    middle = line[cells // 3 : cells - cells // 3 + 1]
    chords = np.diff(middle, axis=0)
    angles = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
    turn = abs(angles[-1] - angles[0]) / (len(angles) - 1) / (length / cells)
    return float(turn), float(np.linalg.norm(chords, axis=1).mean() / (length / cells))


def timoshenko_strip(stretch: float, cells: int = 40) -> float:
    """Curvature of a free strip of 80 x 6 mm in its middle third, prestretched along it, 1/m."""
    length, width = 80e-3, 6e-3
    mesh = rectangle(length, width, cells, 4)
    volume = stacked(mesh, [THICKNESS, THICKNESS])
    solid = solid_of(volume, [SUBSTRATE, KIRIGAMI])
    held = solid.held_points(held_points(choose_nodes_inside(mesh.points), volume))
    with newton_of(solid, held) as newton:
        released = _release_along_x(newton, stretch, first_step=0.001)
    moved = solid.vertex_positions(released)[volume.reference_surface]
    along, across = mesh.points.T
    middle = (np.abs(across - width / 2) < 1e-9) & (np.abs(along - length / 2) < length / 6)
    return _circle_curvature(moved[middle][:, [0, 2]])


def _release_along_x(newton: Newton, stretch: float, first_step: float) -> State:
    """The equilibrium with the lower layer prestretched along x."""

    def load(parameter):
        newton.solid.layers[0].natural.value = natural_state(
            ((1 + parameter, 0.0), (0.0, 1.0)), "natural"
        )

    (released,) = equilibria(load_path(newton, load, first_step), [stretch - 1])
    return released.state


def _circle_curvature(points: Array) -> float:
    """One over the radius of the circle through points in a plane, by least squares (Kasa)."""
    centred = points - points.mean(axis=0)
    columns = np.column_stack([2 * centred, np.ones(len(centred))])
    (x, y, rest), *_ = np.linalg.lstsq(columns, (centred**2).sum(axis=1), rcond=None)
    return float(1 / np.sqrt(rest + x**2 + y**2))


class Cantilever:
    """A homogeneous plate, one element thick, clamped at x = 0, bent in the x-z plane.

    Its width is held, so its bending stiffness is D = E h^3 / 12 (1 - nu^2) per width. The clamp
    leaves it free to become thicker.

    Parameters
    ----------
    poisson_ratio : float
        1/2 is incompressible.
    thickness : float
        m.
    cells : int
        Elements along it.
    """

    length, width, young = 80e-3, 4e-3, 1e5

    def __init__(self, poisson_ratio: float, thickness: float = 1e-3, cells: int = 20) -> None:
        self.thickness = thickness
        material = MooneyRivlin.from_moduli(self.young, poisson_ratio)
        mesh = rectangle(self.length, self.width, cells, 1)
        self._volume = stacked(mesh, [thickness])
        self.solid = solid_of(self._volume, [material])
        self.stiffness = self.young * thickness**3 / 12 / (1 - poisson_ratio**2)
        self._tip = np.isclose(self._volume.points[:, 0], self.length)
        self._held = [
            held_where(self.solid, 1, lambda x: np.full(x.shape[1], True)),
            held_where(self.solid, 0, lambda x: np.isclose(x[0], 0)),
            held_where(
                self.solid, 2, lambda x: np.isclose(x[0], 0) & np.isclose(x[2], -thickness / 2)
            ),
        ]

    def weighed(self, weights: Sequence[float]) -> Iterator[float]:
        """Hang it: for ascending weights b = q L^3 / D, the drop of the tip over the length."""
        for state in self._hang(weights):
            yield -self.solid.vertex_displacements(state)[self._tip, 2].mean() / self.length

    def _hang(self, weights: Sequence[float]) -> Iterator[State]:
        """The equilibria under ascending weights b = q L^3 / D."""
        unit = self.stiffness / self.length**3 / self.thickness

        def load(parameter):
            push(self.solid, -parameter * unit)

        with newton_of(self.solid, self._held) as newton:
            for point in equilibria(load_path(newton, load, 0.25, ROUND_OFF), weights):
                yield point.state

    def energy_ratio(self, weight: float = 0.05) -> float:
        """Strain energy under a small weight over that of the plate in plane strain."""
        (state,) = self._hang([weight])
        load_per_length = weight * self.stiffness / self.length**3
        exact = load_per_length**2 * self.length**5 * self.width / (40 * self.stiffness)
        return self.solid.layer_energy(0, state) / exact
