"""What the layers of a solid remember: dead stresses in the energy, histories beside it.

See `bilayer.mechanics.memory` for the theory, and `strain_energy.Remembered` for the stresses that
are remembered. They live at the quadrature points of the forms, so that what is remembered of a
state is exactly what its equilibrium had.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.memory import History
from bilayer.specimen.relaxation import PronySeries
from fenics_model.api.jit import compiled_expression
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import Remembered, stress_of_shape

Array = NDArray[np.float64]

PARTS = 7
"""Of what is remembered at a point: xx, yy, zz, xy, xz, yz of the stress, and the pressure."""
PRESSURE = 6
ROWS = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
"""Places of the stress's components among the parts."""


class DeadStresses:
    """The dead stresses of all layers at the quadrature points, made before the solid.

    Parameters
    ----------
    mesh : LayeredMesh
        Of the solid.
    quadrature_degree : int
        That of its forms.

    Attributes
    ----------
    points : (q, 3) array of float
        Quadrature points in the reference tetrahedron.
    """

    def __init__(self, mesh: LayeredMesh, quadrature_degree: int) -> None:
        element = basix.ufl.quadrature_element(
            "tetrahedron", value_shape=(PARTS,), degree=quadrature_degree
        )
        self.points: Array = element.custom_quadrature()[0]
        self._function = fem.Function(fem.functionspace(mesh.mesh, element))
        self._mesh = mesh.mesh

    def of_layer(self) -> Remembered:
        """Return what a layer remembers, at first nothing; its factor is its own."""
        part = self._function
        tensor = ufl.as_matrix([[part[i] for i in row] for row in ROWS])
        factor = fem.Constant(self._mesh, default_scalar_type(1.0))
        return Remembered(factor, tensor, part[PRESSURE])

    @property
    def at_vertices(self) -> Array:
        """Those at the vertices of this rank's cells, (cells, 4, PARTS), Pa.

        In each cell, of the linear function that is nearest to them.
        """
        shares = np.column_stack([1 - self.points.sum(axis=1), self.points])
        values = self._function.x.array.reshape(-1, PARTS)
        in_cells = values[self._function.function_space.dofmap.list]
        return np.einsum("vq,cqp->cvp", np.linalg.pinv(shares), in_cells)

    def act(self, cells: NDArray[np.int32], pull: Array) -> None:
        """Set the dead stresses in some cells of this rank, (PARTS, q, cells), Pa."""
        values = self._function.x.array.reshape(-1, PARTS)
        values[self._function.function_space.dofmap.list[cells]] = np.moveaxis(
            pull, 0, -1
        ).swapaxes(0, 1)


@dataclass(frozen=True, eq=False)
class _RelaxingLayer:
    """A layer that relaxes, on this rank."""

    number: int
    series: PronySeries
    cells: NDArray[np.int32]
    stresses: fem.Expression  # S0 and p, at the quadrature points


Held = Callable[[int], Array]
"""Returns the instantaneous stresses of a layer that is held flat, by its number, (PARTS, 1, 1)."""


class SolidMemory:
    """The histories of all layers that relax, and the step of time that is being taken.

    Parameters
    ----------
    solid : Solid
        Its layers that relax have the dead stresses.
    dead : DeadStresses
        Those.
    relaxing : mapping of int to PronySeries
        Of the layers that relax, by their numbers.
    hold : float
        Time for which the stretched layers were held before they were bonded, s.

    Attributes
    ----------
    time : float
        Of the last equilibrium that is remembered, s after the release.
    """

    def __init__(
        self, solid: Solid, dead: DeadStresses, relaxing: Mapping[int, PronySeries], hold: float
    ) -> None:
        self.time, self._step, self._hold = 0.0, 0.0, hold
        self._solid, self._dead = solid, dead
        self._layers = [self._layer(number, series) for number, series in relaxing.items()]
        self._histories: dict[int, History] = {}

    def _layer(self, number: int, series: PronySeries) -> _RelaxingLayer:
        solid, layer = self._solid, self._solid.layers[number]
        stress = stress_of_shape(layer.energy, solid.gradient, layer.natural)
        parts = [stress[i, i] for i in range(3)] + [stress[0, 1], stress[0, 2], stress[1, 2]]
        both = ufl.as_vector([*parts, solid.pressures[number]])
        cells = solid.mesh.layer_tags.find(number)
        return _RelaxingLayer(number, series, cells, compiled_expression(both, self._dead.points))

    def aim_at(self, time: float, held: Held) -> None:
        """Take a step from the last equilibrium to a time; before the first one there is none."""
        self._step = time - self.time
        for layer in self._layers:
            memory = self._history(layer, held).memory(self._step)
            self._solid.layers[layer.number].memory.factor.value = memory.factor
            shape = (PARTS, len(self._dead.points), len(layer.cells))
            self._dead.act(layer.cells, np.broadcast_to(memory.pull, shape))

    def arrive(self, state: State, held: Held) -> None:
        """Keep what the layers remember in the equilibrium at the end of the step."""
        self._histories = {
            layer.number: self._after(layer, self._history(layer, held), state)
            for layer in self._layers
        }
        self.time += self._step
        self._step = 0.0

    def _history(self, layer: _RelaxingLayer, held: Held) -> History:
        known = self._histories.get(layer.number)
        return (
            History.held(layer.series, held(layer.number), self._hold) if known is None else known
        )

    def _after(self, layer: _RelaxingLayer, before: History, state: State) -> History:
        """Return the history at the end of a step, told of the instantaneous stresses there."""
        now, memory = self._evaluate(layer, state), before.memory(self._step)
        now[PRESSURE] = (now[PRESSURE] - memory.pull[PRESSURE]) / memory.factor
        return before.after(self._step, now)

    def _evaluate(self, layer: _RelaxingLayer, state: State) -> Array:
        """Return S0 and the pressure at the quadrature points, (PARTS, q, cells), Pa."""
        solid = self._solid
        with solid.at(state):
            found = layer.stresses.eval(solid.mesh.mesh, layer.cells)
        shaped = np.asarray(found).reshape(len(layer.cells), len(self._dead.points), PARTS)
        return np.array(np.moveaxis(shaped, (2, 1, 0), (0, 1, 2)))

    def dead_stress_at_vertices(self) -> Array:
        """Return P of the change of shape at the vertices of this rank's cells, (cells, 4, 3, 3).

        With the mesh as reference, Pa; 0 where nothing is remembered.
        """
        return self._dead.at_vertices[..., ROWS]

    def uniform_stress(self, number: int, state: State) -> Array:
        """Return S0 and the pressure of a layer in a uniform state, (PARTS, 1, 1), Pa.

        It is the same on every rank.
        """
        layer = next(layer for layer in self._layers if layer.number == number)
        own = self._evaluate(layer, state)[:, :1, :1]
        return next(found for found in self._solid.mesh.mesh.comm.allgather(own) if found.size)

    def save(self) -> dict[str, Array]:
        """Return it as arrays by name, the same on every rank and for any number of them."""
        saved = {"time": np.array([self.time])}
        for number, history in self._histories.items():
            saved[f"stress.{number}"] = self._gather(number, history.stress)
            saved[f"inner.{number}"] = self._gather(number, history.inner)
        return saved

    def restore(self, saved: Mapping[str, Array]) -> None:
        """Be as it was saved; InputError if something is missing."""
        try:
            self._histories = {
                layer.number: History(
                    layer.series,
                    self._spread(layer, saved[f"stress.{layer.number}"]),
                    self._spread(layer, saved[f"inner.{layer.number}"]),
                )
                for layer in self._layers
            }
            self.time, self._step = float(saved["time"][0]), 0.0
        except KeyError as error:
            raise InputError(
                f"resume: {error} is missing, expected what layers remember"
            ) from error

    def _gather(self, number: int, values: Array) -> Array:
        """Return values (..., cells) of this rank's cells for all cells of a layer."""
        mesh = self._solid.mesh
        cells = mesh.layer_tags.find(number)
        owned = cells < mesh.mesh.topology.index_map(3).size_local
        numbers = mesh.mesh.topology.original_cell_index[cells[owned]]
        whole = np.zeros((*values.shape[:-1], len(mesh.volume.cells)))
        for places, part in mesh.mesh.comm.allgather((numbers, values[..., owned])):
            whole[..., places] = part
        return whole[..., mesh.volume.layer == number]

    def _spread(self, layer: _RelaxingLayer, values: Array) -> Array:
        """Return values of all cells of a layer for this rank's; the way back of `_gather`."""
        mesh = self._solid.mesh
        place = np.cumsum(mesh.volume.layer == layer.number) - 1
        return np.asarray(values[..., place[mesh.mesh.topology.original_cell_index[layer.cells]]])
