"""Small solids for the tests, built from the core alone."""

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from ufl.algorithms.analysis import extract_constants

from bilayer.planar_mesh import PlanarMesh
from fenics_model.gradient_flow import GradientFlow
from fenics_model.layered_mesh import LayeredMesh
from fenics_model.newton import Newton
from fenics_model.solid import Solid, SolidLayer
from fenics_model.strain_energy import energy_constants
from fenics_model.volume_mesh import Slab, extrude


def rectangle(length, width, along, across):
    """Triangulated rectangle, its lower left corner at the origin."""
    x, y = np.meshgrid(np.linspace(0, length, along + 1), np.linspace(0, width, across + 1))
    node = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        part.ravel() for part in (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1])
    )
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return PlanarMesh(np.column_stack([x.ravel(), y.ravel()]), triangles, np.ones(len(triangles)))


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


def flow_of(solid, newton, disturbance=None, step_limit=100):
    """A flow whose first viscosity suits bodies of millimetres."""
    if disturbance is None:
        disturbance = np.zeros_like(solid.state.x.array)
    return GradientFlow(
        newton, solid, first_viscosity=1e9, step_limit=step_limit, disturbance=disturbance
    )


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
