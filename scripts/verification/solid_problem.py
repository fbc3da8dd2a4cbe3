"""Solids of any layers on any planar mesh, built from the core of the model alone. SI units."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from ufl.algorithms.analysis import extract_constants

from bilayer.solvers.path import follow_path
from fenics_model.branches.branch_search import BranchSearch, SearchRule
from fenics_model.branches.gradient_flow import FlowRule, GradientFlow
from fenics_model.branches.stability import unstable_modes
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.mesh.volume_mesh import Slab, extrude
from fenics_model.path.continuation import Continuation, LoadPoint, Tolerances
from fenics_model.path.step_control import StepControl
from fenics_model.solid.solid import Solid, SolidLayer
from fenics_model.solid.strain_energy import energy_constants
from fenics_model.solve.newton import Newton
from verification import meshes

FIRST_VISCOSITY = 1e9  # Pa/m2, suits bodies of millimetres


def rectangle(length, width, along, across):
    """Triangulated rectangle, its lower left corner at the origin."""
    return meshes.rectangle(np.linspace(0, length, along + 1), np.linspace(0, width, across + 1))


def stacked(mesh, thicknesses, elements=1):
    """The planar mesh extruded into whole layers."""
    return extrude(mesh, [Slab(thickness, elements, mesh.triangles) for thickness in thicknesses])


def solid_of(volume, materials, comm=MPI.COMM_WORLD, body_force=0.0):
    """The solid of a volume mesh, one material a layer; natural states start at 1."""
    mesh = LayeredMesh(volume, comm)

    def constant(value):
        return fem.Constant(mesh.mesh, np.asarray(value, dtype=default_scalar_type))

    layers = []
    for material in materials:
        kind, values = energy_constants(material)
        energy = kind(**{name: constant(value) for name, value in values.items()})
        force = ufl.as_vector((0, 0, constant(body_force)))
        layers.append(SolidLayer(energy, constant((1.0, 0.0, 1.0, 1.0)), force))
    return Solid(mesh, layers, pressure_scale=materials[0].shear_modulus / 1e-3)


def push(solid, force):
    """Set the dead force along z, N/m3, of every layer."""
    for layer in solid.layers:
        (constant,) = extract_constants(layer.body_force)
        constant.value = force


def held_where(solid, axis, where, value=0.0):
    """Hold a displacement component at every dof that lies where `where(x)` is true."""
    space = solid.component(axis)
    flat_space, _ = space.collapse()
    dofs = fem.locate_dofs_geometrical((space, flat_space), where)[0]
    return fem.dirichletbc(default_scalar_type(value), np.sort(dofs), space)


def newton_of(solid, held, **options):
    """Newton's method on a solid, some dofs held besides the pressures outside their layers."""
    return Newton(solid, [*solid.absent_pressures(), *held], **options)


def count_modes(newton, state):
    """The unstable modes of an equilibrium, by one factorisation."""
    with newton.factorise(state) as factors:
        return unstable_modes(factors, newton.solid.number_of_pressures)


def search_of(newton, lift=None, first_distance=1e-4, step_limit=100, rule=None):
    """A search for branches; `lift(x)` is the height that tells the sides of a mode apart."""
    solid = newton.solid
    side = solid.undeformed
    if lift is not None:
        side = solid.interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], lift(x)]))
    flow = GradientFlow(
        newton,
        first_viscosity=FIRST_VISCOSITY,
        escape=first_distance,
        rule=FlowRule(step_limit=step_limit),
    )
    rule = SearchRule() if rule is None else rule
    return BranchSearch(newton, flow, first_distance=first_distance, side=side.values, rule=rule)


def load_path(newton, load: Callable[[float], None], first_step: float, tolerance: float = 1e-10):
    """The path of a solid under a load that `load` sets for a parameter."""
    control = StepControl(first_step, first_step / 100, 20 * first_step, 6)
    return Continuation(newton, search_of(newton), load, control, Tolerances(tolerance, 1e-4, 0.0))


def equilibria(path: Continuation, targets: Sequence[float]) -> Iterator[LoadPoint]:
    """The equilibria at the targets of a load path; ComputationError if one is not reached."""
    for step in follow_path(path, targets):
        if step.failure is not None:
            raise step.failure
        if step.is_at_target:
            yield step.point


def mean(solid, state, expression, layer=0):
    """Average of an expression over the mesh of a layer, in a state."""
    comm = solid.mesh.mesh.comm
    parts = [
        fem.form(integrand * solid.dx(layer)) for integrand in (expression, 1.0 + 0 * expression)
    ]
    with solid.at(state):
        total, volume = (comm.allreduce(fem.assemble_scalar(part)) for part in parts)
    return total / volume


def stress(solid, layer=0):
    """First Piola-Kirchhoff stress per area of the mesh, as a UFL tensor."""
    gradient = ufl.variable(solid.gradient)
    part = solid.layers[layer]
    energy = part.energy.density(
        gradient.T * gradient, ufl.det(gradient), part.natural, solid.pressures[layer]
    )
    return ufl.diff(energy, gradient)
