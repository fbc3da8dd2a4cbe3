"""The tangent with extrapolated stress, with which Newton's method takes fewer iterations.

If a thin body turns by a large angle in one iteration, the linearised motion leaves spurious
strains. Their stress enters the geometric stiffness and misleads the next iteration. The mixed
integration point method takes that stress from the point of linearisation,

    S* = S(x_last) + dS/dx (x - x_last),

and leaves residual and material stiffness as they are, so the solution is the same and the
convergence is quadratic still. Where nothing was linearised before, S* = S: the exact tangent.

Source: D. Magisano, L. Leonetti, G. Garcea, *How to improve efficiency and robustness of the Newton
method in geometrically non-linear structural problem discretized via displacement-based finite
elements*, CMAME 313 (2017) 986-1005, there for displacements alone.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from fenics_model.api.jit import compiled_form
from fenics_model.solid.unknown import Unknown, at_state


class ExtrapolatedTangent:
    """The second derivative of a potential energy, its geometric part with extrapolated stress.

    Parameters
    ----------
    state : Unknown
        The unknown x.
    exact : UFL form
        The second derivative.
    stresses : sequence of (UFL tensor, UFL measure)
        Second Piola-Kirchhoff stresses S, with the mesh as reference, and where they act.

    Attributes
    ----------
    form : dolfinx.fem.Form
        The tangent at the present state.
    """

    def __init__(self, state: Unknown, exact: Any, stresses: Sequence[tuple[Any, Any]]) -> None:
        self._state = state
        space = state.function_space
        self._last, self._change = fem.Function(space), fem.Function(space)
        u, v = (ufl.grad(ufl.split(f(space))[0]) for f in (ufl.TrialFunction, ufl.TestFunction))
        correction = sum(
            ufl.inner(self._extrapolated(stress) - stress, u.T * v) * dx for stress, dx in stresses
        )
        self.form = compiled_form(exact + correction)
        self._latest: NDArray[np.float64] | None = None

    def _extrapolated(self, stress: Any) -> Any:
        linearised = stress + ufl.derivative(stress, self._state, self._change)
        return at_state(linearised, self._state, self._last)

    def reset_extrapolation(self) -> None:
        """Make the next tangent the exact one."""
        self._latest = None

    def move_linearisation_point(self) -> None:
        """Extrapolate the stress from where the last tangent was taken to the present state."""
        now = self._state.x.array.copy()
        last = now if self._latest is None else self._latest
        self._last.x.array[:] = last
        self._change.x.array[:] = now - last
        self._latest = now
