"""The unknown of a form, and the present state as a constant of differentiation.

`Unknown.present` has the values of the unknown, whatever they become, but is another coefficient to
UFL: what is built of it has the present value and no derivative.
"""

from typing import Any

import ufl
from dolfinx import fem
from ufl.algorithms import extract_coefficients, strip_variables


class Unknown(fem.Function):
    """A finite-element function that forms are differentiated by.

    Attributes
    ----------
    present : dolfinx.fem.Function
        The same values in the same memory.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        super().__init__(space)
        self.present = fem.Function(space, self.x)


def freeze(expression: Any) -> Any:
    """Return an expression at the present state, which derivatives take for a constant."""
    coefficients = extract_coefficients(expression)
    present = {c: c.present for c in coefficients if isinstance(c, Unknown)}
    return strip_variables(ufl.replace(expression, present))


def at_state(expression: Any, unknown: Unknown, state: fem.Function) -> Any:
    """Return an expression of the unknown at another state."""
    return ufl.replace(expression, {unknown: state, unknown.present: state})
