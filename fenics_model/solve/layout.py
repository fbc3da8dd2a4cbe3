"""The dofs of a function space as PETSc holds them: arrays in, arrays out, every vector freed.

An array has the dofs that this rank owns first, then its ghosts. PETSc frees an object on several
ranks only if all of them destroy it at the same place. A garbage collector does not do that, so
each object is destroyed where it is made.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from numpy.typing import NDArray
from petsc4py import PETSc

Array = NDArray[np.float64]


class Layout:
    """The distribution of the dofs over the ranks.

    Parameters
    ----------
    space : dolfinx.fem.FunctionSpace
        Whose dofs.

    Attributes
    ----------
    owned : int
        Number of dofs that this rank owns.
    comm : MPI.Comm
        The ranks.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        dofs = space.dofmap
        self._block, self._map = dofs.index_map_bs, dofs.index_map
        self.owned: int = self._map.size_local * self._block
        self.comm: Any = space.mesh.comm

    def create_vector(self) -> PETSc.Vec:
        """Return a new ghosted vector, which the caller destroys."""
        sizes = self.owned, self._map.size_global * self._block
        ghosts = self._map.ghosts.astype(PETSc.IntType)
        return PETSc.Vec().createGhost(ghosts, sizes, bsize=self._block, comm=self.comm)

    @contextmanager
    def vectors(self, *values: Array | None) -> Iterator[list[PETSc.Vec]]:
        """Hold arrays as vectors meanwhile; a vector for None has no values yet."""
        with ExitStack() as stack:
            made = []
            for array in values:
                made.append(self.create_vector())
                stack.callback(made[-1].destroy)
                if array is not None:
                    made[-1].array[:] = array[: self.owned]
            yield made

    def read(self, vector: PETSc.Vec) -> Array:
        """Return the values of a vector, ghosts included."""
        vector.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with vector.localForm() as local:
            return np.array(local.array_r)

    def dot(self, one: Array, other: Array) -> float:
        """Return the dot product over all ranks."""
        return float(self.comm.allreduce(float(one[: self.owned] @ other[: self.owned])))

    def norm(self, one: Array) -> float:
        """Return the Euclidean norm over all ranks."""
        return self.dot(one, one) ** 0.5

    def times(self, matrix: PETSc.Mat, change: Array) -> Array:
        """Return the product of a matrix with an array."""
        with self.vectors(change, None) as (factor, product):
            matrix.mult(factor, product)
            return self.read(product)


def create_tangent_matrix(coupling: fem.Form, held: Sequence[fem.DirichletBC]) -> PETSc.Mat:
    """Return a matrix, without values, for tangents; the caller destroys it.

    dolfinx leaves room for all dofs of a cell. A seventh of that is never used: pressures of other
    layers and held dofs. MUMPS does not know that these entries are zero.

    Parameters
    ----------
    coupling : dolfinx.fem.Form
        See `Solid.coupling`.
    held : sequence of dolfinx.fem.DirichletBC
        Constraints.
    """
    roomy = fem_petsc.create_matrix(coupling)
    roomy.setOption(PETSc.Mat.Option.IGNORE_ZERO_ENTRIES, True)
    fem_petsc.assemble_matrix(roomy, coupling, list(held))
    roomy.assemble()
    tight = roomy.duplicate()
    roomy.destroy()
    tight.setOption(PETSc.Mat.Option.IGNORE_ZERO_ENTRIES, True)
    tight.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    tight.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
    return tight


class AssembledMatrix:
    """A form as a matrix, the rows and columns of held dofs zero.

    Parameters
    ----------
    form : dolfinx.fem.Form
        Bilinear.
    held : sequence of dolfinx.fem.DirichletBC
        Constraints.
    layout : Layout
        Of its function space.

    Attributes
    ----------
    petsc : PETSc Mat
        It, until `close`.
    """

    def __init__(self, form: fem.Form, held: Sequence[fem.DirichletBC], layout: Layout) -> None:
        self._layout = layout
        self.petsc = fem_petsc.create_matrix(form)
        self.petsc.setOption(PETSc.Mat.Option.IGNORE_ZERO_ENTRIES, True)
        fem_petsc.assemble_matrix(self.petsc, form, list(held), 0.0)
        self.petsc.assemble()

    def times(self, change: Array) -> Array:
        """Return its product with an array."""
        return self._layout.times(self.petsc, change)

    def close(self) -> None:
        """Free the matrix."""
        self.petsc.destroy()
