"""The solid of a specimen: each layer's own mass and energy, and a saddle load in balance."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from dolfinx import fem
from mpi4py import MPI

from bilayer import MeshSize, generate_mesh, paper_specimen, solve
from bilayer.specimen.outline import Polygon, Rectangle
from bilayer.specimen.pattern import CutPattern, Polygons
from fenics_model import SolidSettings
from fenics_model.path.load_schedule import LoadPlace
from fenics_model.release.specimen_solid import make_solid

COARSE = replace(paper_specimen(), mesh=MeshSize(0.016))
TRIANGLE = Polygon(((-0.05, -0.05), (0.05, -0.04), (-0.03, 0.06)))


def made_solid(specimen, settings):
    return make_solid(specimen, generate_mesh(specimen), settings, MPI.COMM_SELF)


def nodal_forces(body):
    """Return the nodes of the displacement, (n, 3), and the residual's forces on them, (n, 3)."""
    residual = fem.assemble_vector(body.solid.residual).array
    spaces = [body.solid.component(axis).collapse() for axis in range(3)]
    nodes = spaces[0][0].tabulate_dof_coordinates()
    return nodes, np.stack([residual[np.asarray(dofs)] for _, dofs in spaces], axis=1)


def test_each_layer_has_the_weight_of_its_own_density():
    heavy = (
        replace(COARSE, gravity=9.81)
        .with_layer("substrate", density=700.0)
        .with_layer("kirigami", density=1900.0)
        .with_milestones([1.2])
    )
    body = made_solid(heavy, SolidSettings(imperfection=0.0))
    body.load(LoadPlace((1.2, 1.2), weight=1.0, imperfection=0.0))
    mesh = generate_mesh(heavy)
    covered = mesh.areas[mesh.region == 1].sum()
    mass = 1e-3 * (700.0 * mesh.areas.sum() / 1.2**2 + 1900.0 * covered)
    _, forces = nodal_forces(body)
    assert forces.sum(axis=0) == pytest.approx([0, 0, mass * 9.81], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("outline", "pattern"),
    [
        (COARSE.outline, None),
        (COARSE.outline, CutPattern(1, 0.008, 5.0)),
        (COARSE.outline, CutPattern(2, 0.01, 0.6)),
        (COARSE.outline, CutPattern(3, 0.008, 1.0)),
        (Rectangle(0.09, 0.04), None),
        (TRIANGLE, None),
        (TRIANGLE, Polygons((((-0.03, -0.03), (0.0, -0.03), (-0.02, 0.0)),), "cut")),
    ],
    ids=str,
)
def test_the_saddle_load_has_no_resultant_and_no_moment(outline, pattern):
    """However the layers lie; their own forces, at a prestretch, have none either."""
    whole = replace(COARSE.with_layer("kirigami", pattern=None), outline=outline)
    specimen = whole.with_layer("kirigami", pattern=pattern, density=2500.0)
    body = made_solid(specimen, SolidSettings(imperfection=50.0))
    loads = []
    for part in (0.0, 0.7):
        body.load(LoadPlace((1.2, 1.1), weight=0.0, imperfection=part))
        nodes, forces = nodal_forces(body)
        loads.append(forces)
    without, with_saddle = loads
    saddle = (with_saddle - without)[:, 2]
    assert np.abs(saddle).sum() > 1e-2
    for forces in loads:
        torque = np.cross(nodes, forces)
        assert np.abs(forces.sum(axis=0)).max() < 1e-11 * np.abs(forces).sum()
        assert np.abs(torque.sum(axis=0)).max() < 1e-11 * np.abs(torque).sum()


def test_each_layer_stores_the_energy_that_laminate_theory_gives_it():
    """An uncut disc at a small prestretch bends to a sphere: strain e0 + k z - e of the layer.

    But along the free edge, where the thickness of 2 mm counts against the radius of 40 mm.
    """
    stretch = 1.0003
    disc = COARSE.with_layer("kirigami", pattern=None).with_milestones([stretch])
    result = solve(disc, "fenics")
    layers = disc.bonded_layers((stretch, stretch))
    modulus = np.array([part.layer.material.young_modulus for part in layers]) / (1 - 0.5)
    bottom, top = np.array([(part.bottom, part.top) for part in layers]).T
    natural = np.array([1 / part.axial_stretch[0] - 1 for part in layers])
    moments = [modulus * (top**n - bottom**n) / n for n in (1, 2, 3)]
    a, b, d = (moment.sum() for moment in moments)
    e0, k = np.linalg.solve([[a, b], [b, d]], [moments[0] @ natural, moments[1] @ natural])
    off = e0 - natural
    density = moments[0] * off**2 + 2 * moments[1] * off * k + moments[2] * k**2
    area = generate_mesh(disc).areas.sum()
    for part, expected in zip(layers, area * density, strict=True):
        stored = float(result["energy"].sel(term=part.name)[0])
        assert stored == pytest.approx(expected, rel=0.05), part.name
