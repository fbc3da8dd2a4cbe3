"""From elements to the whole: energies, forces and one sparse Hessian of fixed pattern.

An energy is a set of like elements, each a few nodes. Where each entry of each element's Hessian
goes in the sparse matrix is found once; an assembly is then one `bincount` over all entries.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

Array = NDArray[np.float64]


class Energy(Protocol):
    """A sum of like element energies, each of the positions of its k nodes."""

    @property
    def name(self) -> str:
        """What the energy is called in a result."""

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Nodes of each element, shape (n, k)."""

    def energy(self, corners: Array) -> Array:
        """Return each element's energy, J, shape (n,), from positions of shape (n, k, 3) in m."""

    def gradient(self, corners: Array) -> Array:
        """Return its derivative by the positions, N, shape (n, k, 3)."""

    def hessian(self, corners: Array) -> Array:
        """Return its second derivative, N/m, shape (n, 3k, 3k)."""


class Assembly:
    """Where the elements of some energies go in the vectors and the matrix of the free dofs.

    The degrees of freedom are the coordinates of the nodes that are not held, node by node.

    Parameters
    ----------
    node_count : int
        Number of nodes.
    stencils : sequence of (n, k) arrays of int
        The nodes of the elements, one array per energy.
    held_nodes : array of int
        Nodes that do not move.
    """

    def __init__(
        self,
        node_count: int,
        stencils: Sequence[NDArray[np.int64]],
        held_nodes: Sequence[int] | NDArray[np.int64] = (),
    ) -> None:
        self.node_count = node_count
        self.free_nodes = np.setdiff1d(np.arange(node_count), held_nodes)
        stencil_dofs = [_dofs(nodes) for nodes in stencils]
        self._dofs = np.concatenate([dofs.reshape(-1) for dofs in stencil_dofs])
        size = 3 * len(self.free_nodes)
        number = np.full(3 * node_count, -1)
        number[_dofs(self.free_nodes[:, None]).reshape(-1)] = np.arange(size)
        entries = [_entries(number[dofs], size) for dofs in stencil_dofs]
        diagonal = np.arange(size) * (size + 1)
        # the entries of held nodes are numbered past the last: they end in a slot of their own
        pattern, slots = np.unique(np.concatenate([diagonal, *entries]), return_inverse=True)
        stored = int(np.searchsorted(pattern, size * size))
        self._diagonal_slots = slots[:size]
        self._slots = slots[size:]
        columns, self._rows = np.divmod(pattern[:stored], max(size, 1))
        self._column_starts = np.searchsorted(columns, np.arange(size + 1))

    def gradient(self, energies: Sequence[Energy], positions: Array) -> Array:
        """Return the derivative of the energies by all positions, N, shape (nodes, 3)."""
        parts = [term.gradient(positions[term.nodes]).reshape(-1) for term in energies]
        total = np.bincount(self._dofs, np.concatenate(parts), minlength=3 * self.node_count)
        return total.reshape(-1, 3).astype(np.float64, copy=False)

    def hessian(
        self, energies: Sequence[Energy], positions: Array, diagonal: Array | float = 0.0
    ) -> csc_matrix:
        """Return the second derivative by the free dofs, N/m, plus a diagonal.

        Parameters
        ----------
        energies : sequence of Energy
            On the stencils that the assembly was made for, in their order.
        positions : (nodes, 3) array of float
            m.
        diagonal : (free dofs,) array of float or float
            Added to the diagonal, N/m.
        """
        parts = [term.hessian(positions[term.nodes]).reshape(-1) for term in energies]
        stored = len(self._rows)
        total = np.bincount(self._slots, np.concatenate(parts), minlength=stored + 1)
        data = total[:stored].astype(np.float64, copy=False)
        data[self._diagonal_slots] += diagonal
        size = len(self._column_starts) - 1
        return csc_matrix((data, self._rows, self._column_starts), shape=(size, size))


def total_energies(energies: Sequence[Energy], positions: Array) -> dict[str, float]:
    """Return the total of each energy by its name, J, at positions of shape (nodes, 3)."""
    return {term.name: float(term.energy(positions[term.nodes]).sum()) for term in energies}


def _dofs(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Degrees of freedom of each element, shape (n, 3k), of all nodes."""
    return (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), 3 * nodes.shape[1])


def _entries(dofs: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Return the number of each entry, column by column; size * size for those of held nodes."""
    rows, columns = dofs[:, :, None], dofs[:, None, :]
    return np.where((rows < 0) | (columns < 0), size * size, columns * size + rows).reshape(-1)
