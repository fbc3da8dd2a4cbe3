"""Rung 5: a bilayer strip, prestretched along its length, its width held, bends to a circle.

The exact solution is Rivlin's flexure: incompressible, each fibre an arc, plane strain across the
width. Its two numbers, the angle per bonded length and the interface's radius, minimise the energy.
"""

import numpy as np
import pytest
from scipy.optimize import minimize

from bilayer import MooneyRivlin

SUBSTRATE, KIRIGAMI = MooneyRivlin(4839.1, 14536.0), MooneyRivlin(30749.0, 30749.0)
THICKNESS, STRETCH = 1e-3, 1.06


def flexure(stretch):
    """Angle per bonded length, 1/m, and the interface's radius, m, of the exact solution."""
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


def test_the_exact_solution_is_the_published_one():
    angle, radius = flexure(STRETCH)
    assert angle == pytest.approx(39.23298, rel=1e-5)
    assert radius * angle == pytest.approx(0.976057, rel=1e-5)
    inner = np.sqrt(radius**2 - 2 * THICKNESS / (angle * STRETCH))
    assert inner == pytest.approx(23.8924e-3, rel=1e-5)


def test_a_strip_bends_as_the_exact_solution():
    pytest.importorskip("dolfinx")
    from solids import flow_of, held_where, newton_of, rectangle, solid_of, stacked

    from fenics_model.bilayer_solid import natural_state
    from fenics_model.continuation import Tolerances, follow
    from fenics_model.release_path import ReleasePath
    from fenics_model.step_control import StepControl

    length, across = 40e-3, 1
    mesh = rectangle(length, 1e-3, 40, across)
    volume = stacked(mesh, [THICKNESS, THICKNESS])
    solid = solid_of(volume, [SUBSTRATE, KIRIGAMI])
    first, last = volume.interface[0], volume.interface[40]
    newton = newton_of(
        solid,
        [held_where(solid, 1, lambda x: np.full(x.shape[1], True)),
         *solid.held_points([(first, 0), (first, 2), (last, 2)])],
    )  # fmt: skip
    path = ReleasePath([(STRETCH, 1.0)])

    def load(parameter):
        solid.layers[0].natural.value = natural_state(path.stretch(parameter), "natural")

    control = StepControl(0.002, 1e-4, 0.02, 6)
    tolerances = Tolerances(1e-10, 1e-4, 0.0)
    flow = flow_of(solid, newton)
    for _ in follow(newton, flow, load, path.milestones, control, tolerances):
        pass
    newton.destroy()
    centre_line = (volume.points + solid.vertex_displacements())[volume.interface[:41]][:, [0, 2]]
    middle = centre_line[13:28]
    chords = np.diff(middle, axis=0)
    angles = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
    angle = abs(angles[-1] - angles[0]) / (len(angles) - 1) / (length / 40)
    exact_angle, exact_radius = flexure(STRETCH)
    assert angle == pytest.approx(exact_angle, rel=0.005)
    interface_stretch = np.linalg.norm(chords, axis=1).mean() / (length / 40)
    assert interface_stretch == pytest.approx(exact_angle * exact_radius, rel=0.002)
