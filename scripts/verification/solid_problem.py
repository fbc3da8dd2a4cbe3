"""Solids of any layers on any planar mesh, built from the core of the model alone. SI units."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from ufl.algorithms.analysis import extract_constants

from fenics_model.branches.branch_search import BranchSearch
from fenics_model.branches.gradient_flow import GradientFlow
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.mesh.volume_mesh import Slab, extrude
from fenics_model.path.continuation import Equilibrium, Tolerances, follow
from fenics_model.path.guide import Guide
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
    """The solid of a volume mesh, one material a layer; natural states start at (1, 1, 1)."""
    mesh = LayeredMesh(volume, comm)

    def constant(value):
        return fem.Constant(mesh.mesh, np.asarray(value, dtype=default_scalar_type))

    layers = []
    for material in materials:
        kind, values = energy_constants(material)
        energy = kind(**{name: constant(value) for name, value in values.items()})
        force = ufl.as_vector((0, 0, constant(body_force)))
        layers.append(SolidLayer(energy, constant((1.0, 1.0, 1.0)), force))
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
    return Newton(
        solid.residual, solid.tangent, solid.state, [*solid.absent_pressures(), *held], **options
    )


def flow_of(solid, newton, step_limit=100):
    return GradientFlow(newton, solid, first_viscosity=FIRST_VISCOSITY, step_limit=step_limit)


def search_of(solid, newton, lift=None, first_distance=1e-4, step_limit=100, choice="lowest"):
    """A search for branches; `lift(x)` is the height that tells the sides of a mode apart."""
    side = fem.Function(solid.space)
    if lift is not None:
        side.sub(0).interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], lift(x)]))
    flow = flow_of(solid, newton, step_limit)
    return BranchSearch(
        newton, flow, solid, first_distance=first_distance, side=side.x.array, choice=choice
    )


def unguided(solid, newton):
    """A guide without shapes: load steps alone."""
    return Guide(newton, solid, extrusion=None, settle=None, shapes={})


def followed(
    solid, newton, load: Callable[[float], None], milestones: Sequence[float], first_step: float,
    tolerance: float = 1e-10,
) -> Iterator[Equilibrium]:  # fmt: skip
    """The equilibria at the milestones of a load path, each while the solid is in its state."""
    control = StepControl(first_step, first_step / 100, 20 * first_step, 6)
    search, guide = search_of(solid, newton), unguided(solid, newton)
    tolerances = Tolerances(tolerance, 1e-4, 0.0)
    for equilibrium in follow(newton, search, load, milestones, control, tolerances, guide):
        if equilibrium.milestone is not None:
            yield equilibrium


def mean(solid, expression, layer=0):
    """Average of an expression over the mesh of a layer."""
    comm = solid.mesh.mesh.comm
    parts = [
        fem.form(integrand * solid.dx(layer)) for integrand in (expression, 1.0 + 0 * expression)
    ]
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
