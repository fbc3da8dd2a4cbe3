"""The energy of the displacements alone: that of the mixed body, its pressures in balance.

The mixed energy L(u, p) is stationary at an equilibrium, not least: it is a maximum in p. It is
quadratic in p, so with the displacements fixed its maximum is one linear solution away,

    p(u) = p - L_pp^-1 L_p(u, p),   E(u) = L(u, p(u)),

and E is least at a stable equilibrium. So E tells whether a step went downhill.

In an incompressible layer L_pp = 0, and E would be infinite wherever the volume changes. There the
compliance of a nearly incompressible layer stands in, around the pressures of the state.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem, la
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_model.api.jit import compiled_form
from fenics_model.solid.state import State
from fenics_model.solve.layout import Array, AssembledMatrix
from fenics_model.solve.newton import Newton

STAND_IN_COMPLIANCE = 0.02
"""Of an incompressible layer, over the inverse of the carrier's shear modulus: nu = 0.49."""
NO_COMPLIANCE = 1e-9
"""Of a layer over the one that stands in, below which it counts as incompressible."""


class PressureBalance:
    """Balances the pressures of states, and evaluates the energy that this leaves.

    Parameters
    ----------
    newton : Newton
        Evaluates residuals.
    free : array of int
        Pressure dofs that this rank owns and that are not held.
    solver : PETSc KSP
        Solves with L_pp on these.
    """

    def __init__(self, newton: Newton, free: NDArray[np.int64], solver: PETSc.KSP) -> None:
        self._newton, self._pressures, self._solver = newton, free, solver

    def balance(self, state: State) -> State:
        """Return the state whose pressures are in balance with its displacements."""
        layout, matrix = self._newton.layout, self._solver.getOperators()[0]
        change, side = matrix.createVecs()
        try:
            side.array[:] = -self._newton.residual(state)[self._pressures]
            self._solver.solve(side, change)
            whole = np.zeros_like(state.values)
            whole[self._pressures] = change.array_r
        finally:
            change.destroy()
            side.destroy()
        with layout.vectors(whole) as (vector,):
            return state + layout.read(vector)

    def energy(self, state: State) -> float:
        """Return the energy of the displacements of a state, J; it may not be a number."""
        return self._newton.potential_energy(self.balance(state))


class CondensedEnergy:
    """The energy of the displacements of a solid.

    Parameters
    ----------
    newton : Newton
        Evaluates its residuals.
    """

    def __init__(self, newton: Newton) -> None:
        self._newton = newton

    @contextmanager
    def at_present_loads(self) -> Iterator[PressureBalance]:
        """Give what balances the pressures at the loads of the moment."""
        with ExitStack() as stack:
            block = self._block()
            stack.callback(block.destroy)
            solver = PETSc.KSP().create(self._newton.layout.comm)
            stack.callback(solver.destroy)
            solver.setOperators(block)
            solver.setType(PETSc.KSP.Type.PREONLY)
            solver.getPC().setType(PETSc.PC.Type.CHOLESKY)
            solver.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
            yield PressureBalance(self._newton, self._pressures, solver)

    def _block(self) -> PETSc.Mat:
        """Return L_pp of the free pressures, negative definite."""
        newton = self._newton
        whole = AssembledMatrix(self._second_derivative, newton.held, newton.layout)
        first, _ = whole.petsc.getOwnershipRange()
        places = (first + self._pressures).astype(PETSc.IntType)
        rows = PETSc.IS().createGeneral(places, comm=newton.layout.comm)
        try:
            block = whole.petsc.createSubMatrix(rows, rows)
        finally:
            rows.destroy()
            whole.close()
        self._stand_in(block)
        block.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return block

    def _stand_in(self, block: PETSc.Mat) -> None:
        """Give a compliance to the pressures that have none."""
        diagonal, least = block.getDiagonal(), self._least_compliance[self._pressures]
        missing = -diagonal.array_r < NO_COMPLIANCE * least
        if self._newton.layout.comm.allreduce(int(missing.sum())):
            diagonal.array[missing] = -least[missing]
            block.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
            block.setDiagonal(diagonal)
        diagonal.destroy()

    @cached_property
    def _pressures(self) -> NDArray[np.int64]:
        """Pressure dofs that this rank owns and that are not held."""
        solid, owned = self._newton.solid, self._newton.layout.owned
        dofs = [solid.pressure_space(layer).dofmap.list for layer in range(len(solid.layers))]
        found = np.setdiff1d(np.concatenate([each.reshape(-1) for each in dofs]),
                             self._newton.held_dofs)  # fmt: skip
        return found[found < owned]

    @cached_property
    def _second_derivative(self) -> fem.Form:
        """The second derivative of the mixed energy by the pressures, as a form."""
        solid = self._newton.solid
        C, J = solid.gradient.T * solid.gradient, ufl.det(solid.gradient)
        trials, tests = (f(solid.space)[1:] for f in (ufl.TrialFunctions, ufl.TestFunctions))
        integrals = 0
        for layer, body in enumerate(solid.layers):
            p = ufl.variable(solid.pressures[layer])
            curvature = ufl.diff(ufl.diff(body.density(C, J, p), p), p)
            product = solid.pressure_scale**2 * trials[layer] * tests[layer]
            integrals += curvature * product * solid.dx(layer)
        return compiled_form(integrals)

    @cached_property
    def _least_compliance(self) -> Array:
        """The lumped compliance that stands in at each dof, in the unknowns' own scale."""
        solid = self._newton.solid
        heights = solid.mesh.volume.heights
        scale, thickness = float(solid.pressure_scale.value), float(heights[-1] - heights[0])
        tests = ufl.TestFunctions(solid.space)[1:]
        volumes = fem.assemble_vector(
            compiled_form(sum(test * solid.dx(layer) for layer, test in enumerate(tests)))
        )
        volumes.scatter_reverse(la.InsertMode.add)
        volumes.scatter_forward()
        return np.asarray(STAND_IN_COMPLIANCE * scale / thickness * volumes.array)
