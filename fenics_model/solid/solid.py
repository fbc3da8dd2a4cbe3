"""A layered solid: its mixed energy, and the residual and tangent that follow from it.

Unknowns are the displacement (quadratic) and one pressure (linear) for each layer, because the
pressure jumps across the bond. Every pressure is a field on the whole mesh whose dofs outside its
layer are held at zero. The solid knows layers, natural states and dead loads, and no specimen.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import basix.ufl
import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from numpy.typing import NDArray

from fenics_model.api.jit import compiled_form
from fenics_model.mesh.layered_mesh import EDGES, LayeredMesh
from fenics_model.solid.nodal_terms import NodalTerms
from fenics_model.solid.skin_pressure import SkinPressure
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import (
    NOTHING,
    Remembered,
    StrainEnergy,
    natural_tensor,
    stress,
)
from fenics_model.solid.tangent import ExtrapolatedTangent
from fenics_model.solid.unknown import Unknown


@dataclass(frozen=True)
class SolidLayer:
    """One layer of the solid.

    Parameters
    ----------
    energy : StrainEnergy
        The law.
    natural : dolfinx Constant of shape (4,)
        See `strain_energy.natural_tensor`; its value may change along a load path.
    body_force : UFL vector
        Dead force per volume of the mesh, N/m3.
    memory : Remembered
        What it remembers in the present step of time.
    """

    energy: StrainEnergy
    natural: fem.Constant
    body_force: Any
    memory: Remembered = NOTHING

    def density(self, C: Any, J: Any, pressure: Any) -> Any:
        """Return the energy per volume of the mesh, J/m3, as a UFL expression."""
        return self.energy.density(C, J, self.natural, pressure, self.memory)

    def stored_density(self, C: Any, J: Any, pressure: Any) -> Any:
        """Return that of the instantaneous law alone."""
        own = self.memory.instantaneous_pressure(pressure)
        return self.energy.density(C, J, self.natural, own)

    def stress(self, gradient: Any, pressure: Any) -> Any:
        """Return the second Piola-Kirchhoff stress, Pa, as a UFL tensor."""
        return stress(self.energy, gradient, self.natural, pressure, self.memory)


class Solid:
    """Energy, residual and tangent of a layered solid.

    The forms are evaluated at `unknown`. Whoever evaluates one says at which state (`at`); nobody
    relies on what is in `unknown` otherwise.

    Parameters
    ----------
    mesh : LayeredMesh
        Layer i of the mesh is `layers[i]`.
    layers : sequence of SolidLayer
        Laws, natural states and loads.
    pressure_scale : float
        The unknown q of a layer's pressure is p = pressure_scale q. A modulus over a thickness,
        Pa/m, makes q a length, so that residuals and corrections of both unknowns compare.
    quadrature_degree : int
        Degree that the quadrature integrates exactly.
    skin_pressures : sequence of SkinPressure
        Pressures on parts of the skin, which follow it.

    Attributes
    ----------
    space : dolfinx.fem.FunctionSpace
        Of displacement and pressures.
    unknown : Unknown
        The state at which the forms are evaluated.
    residual : dolfinx.fem.Form
        First derivative of the potential energy.
    tangent : ExtrapolatedTangent
        Its second derivative.
    nodal : NodalTerms
        Forces and springs at single dofs, which are no part of the forms.
    displacement, gradient, pressures : UFL expressions
        u, grad(x) = I + grad(u), and p of each layer.
    dx : UFL measure
        `dx(i)` integrates over layer i.
    """

    def __init__(
        self,
        mesh: LayeredMesh,
        layers: Sequence[SolidLayer],
        *,
        pressure_scale: float,
        quadrature_degree: int = 4,
        skin_pressures: Sequence[SkinPressure] = (),
    ) -> None:
        self.mesh, self.layers = mesh, layers
        self._skin_pressures = list(skin_pressures)
        quadratic = basix.ufl.element("Lagrange", "tetrahedron", 2, shape=(3,))
        linear = basix.ufl.element("Lagrange", "tetrahedron", 1)
        self.space = fem.functionspace(
            mesh.mesh, basix.ufl.mixed_element([quadratic, *[linear] * len(layers)])
        )
        self.unknown = Unknown(self.space)
        self.dx = ufl.Measure(
            "dx", mesh.mesh, subdomain_data=mesh.layer_tags,
            metadata={"quadrature_degree": quadrature_degree},
        )  # fmt: skip
        self.pressure_scale = fem.Constant(mesh.mesh, default_scalar_type(pressure_scale))
        displacement, *unscaled = ufl.split(self.unknown)
        self.displacement = displacement
        self.pressures = [self.pressure_scale * q for q in unscaled]
        self.gradient = ufl.Identity(3) + ufl.grad(displacement)
        self._layer_energies = [self._form(density) for density in self._stored()]
        self.nodal = NodalTerms(self._owned, mesh.mesh.comm)
        test, trial = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        residual = ufl.derivative(self._potential(), self.unknown, test)
        exact = ufl.derivative(residual, self.unknown, trial)
        for pressure in self._skin_pressures:
            part = pressure.residual(self.gradient, ufl.split(test)[0])
            change = ufl.derivative(part, self.unknown, trial)
            residual += part
            exact += 0.5 * (change + ufl.adjoint(change))
        self.residual = self._form(residual)
        self.tangent = ExtrapolatedTangent(
            self.unknown,
            exact,
            [
                (layer.stress(self.gradient, pressure), self.dx(i))
                for i, (layer, pressure) in self._layers_with_pressure()
            ],
        )

    def _layers_with_pressure(self) -> list[tuple[int, tuple[SolidLayer, Any]]]:
        return list(enumerate(zip(self.layers, self.pressures, strict=True)))

    def _stored(self, weight: Any = 1) -> list[Any]:
        """Return the integral of the energy that each layer has by its law, times a weight."""
        C, J = self.gradient.T * self.gradient, ufl.det(self.gradient)
        return [
            layer.stored_density(C, J, pressure) * weight * self.dx(i)
            for i, (layer, pressure) in self._layers_with_pressure()
        ]

    def _potential(self) -> Any:
        C, J = self.gradient.T * self.gradient, ufl.det(self.gradient)
        stored = [
            layer.density(C, J, pressure) * self.dx(i)
            for i, (layer, pressure) in self._layers_with_pressure()
        ]
        loads = [
            ufl.dot(layer.body_force, self.displacement) * self.dx(i)
            for i, layer in enumerate(self.layers)
        ]
        return sum(stored) - sum(loads)

    @cached_property
    def coupling(self) -> fem.Form:
        """A form whose matrix has an entry, not zero, for all pairs of dofs that a tangent couples.

        In a cell these are the displacements and the pressure of its own layer. The product of two
        shape functions at the middle of a cell has the same sign in all cells that they share, so
        the sum does not vanish.
        """
        trial, test = ufl.TrialFunctions(self.space), ufl.TestFunctions(self.space)
        dx = self.dx(metadata={"quadrature_degree": 1})

        def summed(functions: Any, layer: int) -> Any:
            return functions[0][0] + functions[0][1] + functions[0][2] + functions[1 + layer]

        return self._form(
            sum(summed(trial, i) * summed(test, i) * dx(i) for i in range(len(self.layers)))
        )

    def mass(self) -> fem.Form:
        """Return the form of the displacements' mass matrix at unit density, m3."""
        u, v = (ufl.split(f(self.space))[0] for f in (ufl.TrialFunction, ufl.TestFunction))
        return self._form(ufl.inner(u, v) * self.dx)

    @staticmethod
    def _form(integral: Any) -> fem.Form:
        return compiled_form(integral)

    @property
    def undeformed(self) -> State:
        """The state without displacement and pressure."""
        return State(np.zeros_like(self.unknown.x.array))

    def interpolate(
        self,
        displacement: Callable[[NDArray[np.float64]], NDArray[np.float64]],
        *pressures: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    ) -> State:
        """Return the state of a displacement and pressures that are given by the place.

        Parameters
        ----------
        displacement : callable
            Takes coordinates (3, m), m; returns displacements (3, m), m.
        *pressures : callable
            Unscaled pressures q of the first layers, see `pressure_scale`; the others are 0.
        """
        function = fem.Function(self.space)
        function.sub(0).interpolate(displacement)
        for layer, pressure in enumerate(pressures):
            function.sub(1 + layer).interpolate(pressure)
        function.x.scatter_forward()
        return State(function.x.array)

    def function_of(self, state: State) -> fem.Function:
        """Return a state as a function of its own."""
        function = fem.Function(self.space)
        function.x.array[:] = state.values
        return function

    def move_to(self, state: State) -> None:
        """Evaluate the forms at a state from now on."""
        self.unknown.x.array[:] = state.values

    @contextmanager
    def at(self, state: State) -> Iterator[None]:
        """Evaluate the forms at a state meanwhile, then where they were evaluated before."""
        before = State(self.unknown.x.array)
        self.move_to(state)
        try:
            yield
        finally:
            self.move_to(before)

    def layer_energy(self, layer: int, state: State) -> float:
        """Return the strain energy of a layer, J, the same on every rank."""
        return self.total(self._layer_energies[layer], state)

    def cell_energies(self, layer: int, state: State) -> NDArray[np.float64]:
        """Return the strain energy of a layer in each cell of this rank, J; 0 in ghosts."""
        with self.at(state):
            found = fem.assemble_vector(self._cell_energy_forms[layer])
        return np.asarray(found.array[self._cell_space.dofmap.list[:, 0]])

    @cached_property
    def _cell_space(self) -> fem.FunctionSpace:
        return fem.functionspace(self.mesh.mesh, ("Discontinuous Lagrange", 0))

    @cached_property
    def _cell_energy_forms(self) -> list[fem.Form]:
        """Compiled when fields are first asked for."""
        cell = ufl.TestFunction(self._cell_space)
        return [self._form(integral) for integral in self._stored(cell)]

    def potential_energy(self, state: State) -> float:
        """Return the strain energy less the work of the loads, J, the same on every rank."""
        stored = self.total(self._potential_form, state) + self.nodal.energy(state.values)
        pressed = [
            float(pressure.value) * self.swept_volume(pressure, state)
            for pressure in self._skin_pressures
        ]
        return stored - sum(pressed)

    def swept_volume(self, pressure: SkinPressure, state: State) -> float:
        """Return the volume that the faces of a pressure have swept, m3, the same on every rank."""
        form = self._swept_forms[self._skin_pressures.index(pressure)]
        return self.total(form, state) - self.total(form, self.undeformed)

    @cached_property
    def _swept_forms(self) -> list[fem.Form]:
        return [
            self._form(pressure.swept(self.gradient, self.displacement))
            for pressure in self._skin_pressures
        ]

    def total(self, form: fem.Form, state: State) -> float:
        """Return the value of a form at a state, the same on every rank."""
        with self.at(state):
            local = fem.assemble_scalar(form)
        return float(self.mesh.mesh.comm.allreduce(local, op=MPI.SUM))

    def natural_integral(self, expression: Any) -> fem.Form:
        """Return the form of the integral of an expression over the natural volume."""
        return self._form(
            sum(
                expression / ufl.det(natural_tensor(layer.natural)) * self.dx(i)
                for i, layer in enumerate(self.layers)
            )
        )

    @cached_property
    def _potential_form(self) -> fem.Form:
        """Compiled when it is first needed, which is seldom."""
        return self._form(self._potential())

    @property
    def _owned(self) -> int:
        """Number of dofs that this rank owns."""
        dofs = self.space.dofmap
        return int(dofs.index_map.size_local * dofs.index_map_bs)

    @cached_property
    def _owned_displacements(self) -> NDArray[np.int32]:
        """Displacement dofs that this rank owns."""
        dofs = np.unique([self.component(axis).dofmap.list for axis in range(3)])
        return dofs[dofs < self._owned].astype(np.int32)

    def displacement_dofs(
        self, axis: int, pairs: NDArray[np.int64], *, owned: bool = False
    ) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """Return this rank's dofs of a displacement component at places, and which these are.

        Parameters
        ----------
        axis : {0, 1, 2}
            The component.
        pairs : (k, 2) array of int
            Original numbers of the two vertices between which each place is the middle; twice the
            same at a vertex.
        owned : bool
            Leave the ghosts out.
        """
        corners, count = self.mesh.cell_vertices, len(self.mesh.volume.points)
        ends = np.concatenate([np.stack([corners, corners], axis=2), corners[:, EDGES]], axis=1)
        ends = np.sort(ends, axis=2)
        keys, first = np.unique(ends[..., 0] * count + ends[..., 1], return_index=True)
        dofs = self.component(axis).dofmap.list.reshape(-1)[first]
        low, high = np.sort(pairs, axis=1).T
        place = np.minimum(np.searchsorted(keys, low * count + high), max(len(keys) - 1, 0))
        is_here = keys[place] == low * count + high if len(keys) else np.zeros(len(low), dtype=bool)
        if owned:
            is_here &= dofs[place] < self._owned
        which = np.flatnonzero(is_here)
        return dofs[place[which]].astype(np.int32), which

    def held_dofs(self, axis: int, pairs: NDArray[np.int64]) -> fem.DirichletBC:
        """Hold a displacement component at places; see `displacement_dofs`."""
        dofs, _ = self.displacement_dofs(axis, pairs)
        space = self.component(axis)
        return fem.dirichletbc(default_scalar_type(0), np.unique(dofs), space)

    def displacement_norm(self, change: NDArray[np.float64]) -> float:
        """Return the Euclidean norm of the displacement dofs of a change of state, m.

        It is the same on every rank.
        """
        local = float(np.sum(change[self._owned_displacements] ** 2))
        return float(self.mesh.mesh.comm.allreduce(local, op=MPI.SUM) ** 0.5)

    def component(self, axis: int) -> fem.FunctionSpace:
        """Return the subspace of one displacement component."""
        return self.space.sub(0).sub(axis)

    def pressure_space(self, layer: int) -> fem.FunctionSpace:
        """Return the subspace of one layer's pressure."""
        return self.space.sub(1 + layer)

    def absent_pressures(self) -> list[fem.DirichletBC]:
        """Hold each layer's pressure at zero outside its layer."""
        everywhere = np.arange(len(self.mesh.volume.points))
        return [
            self._held(
                self.pressure_space(layer),
                np.setdiff1d(everywhere, self.mesh.volume.vertices_of(layer)),
            )
            for layer in range(len(self.layers))
        ]

    def held_points(self, points: Sequence[tuple[int, int]]) -> list[fem.DirichletBC]:
        """Hold single displacement components at vertices.

        Parameters
        ----------
        points : sequence of (vertex, axis)
            Original vertex numbers and the components held there.
        """
        return [self._held(self.component(axis), np.array([vertex])) for vertex, axis in points]

    def _held(self, space: fem.FunctionSpace, vertices: NDArray[np.int64]) -> fem.DirichletBC:
        return fem.dirichletbc(default_scalar_type(0), self.mesh.dofs_at(space, vertices), space)

    @property
    def number_of_pressures(self) -> int:
        """Pressure unknowns that are not held, over all layers."""
        return sum(len(self.mesh.volume.vertices_of(layer)) for layer in range(len(self.layers)))

    def vertex_displacements(self, state: State) -> NDArray[np.float64]:
        """Return the displacement of all vertices in their original order, m, shape (v, 3)."""
        columns = [self.mesh.gather(self.component(axis), state.values) for axis in range(3)]
        return np.column_stack(columns)

    def vertex_positions(self, state: State) -> NDArray[np.float64]:
        """Return the deformed position of all vertices in their original order, m, shape (v, 3)."""
        return self.mesh.volume.points + self.vertex_displacements(state)
