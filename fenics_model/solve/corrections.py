"""Corrections with one factor: accelerated, and given up for a new factor when that costs less.

With the factor of a tangent K at hand, a correction is z(x) = K^-1 R(x). It costs a small part of a
new tangent with its factor, but the iteration x - z(x) alone diverges where the body bends: a
deflection also stretches the sheet, which another K would know. Anderson's acceleration takes

    x - z + sum_i g_i (dx_i + dz_i),   g least squares of z = sum_i g_i (-dz_i),

over the last changes dx, dz of state and correction: for a linear R it is GMRES with K as
preconditioner. Corrections are lengths, in both unknowns, so soft directions count in the norm as
they should; with the residual in its place the stiff ones would rule, and the iteration wanders.

Source: D. G. Anderson, *Iterative procedures for nonlinear integral equations*, J. ACM 12 (1965)
547-560; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715-1735.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_model.solid.state import State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CorrectionRule:
    """When corrections with one factor are worth it.

    Parameters
    ----------
    history : int
        Changes that the acceleration keeps.
    tangent_cost : float
        What a new tangent and its factor are taken to cost, in corrections. They take the time of
        20 to 25; more, because the rate of accelerated corrections recovers after a plateau.
    fresh_rate : float
        What a correction with a new factor is expected to leave of the residual.
    window : int
        Corrections over which the present rate is measured.
    fewest, most : int
        Corrections with one factor.
    halvings : int
        How often a step is halved at which the residual is no number.
    fruitless : float
        What a second or later tangent may leave of the residual; beyond it, the solution has
        failed.
    growth_limit : float
        Over the first residual; beyond it, the solution has failed.
    """

    history: int = 12
    tangent_cost: float = 60.0
    fresh_rate: float = 0.1
    window: int = 4
    fewest: int = 2
    most: int = 40
    halvings: int = 8
    fruitless: float = math.inf
    growth_limit: float = 1e10


class AndersonMixing:
    """Accelerates corrections with one factor.

    Parameters
    ----------
    dot : callable
        The dot product of two arrays.
    history : int
        Changes that are kept.

    Examples
    --------
    Two corrections with a factor that is wrong by half solve a linear equation, x = 3:

    >>> mixing = AndersonMixing(np.dot, history=2)
    >>> x = State(np.array([0.0]))
    >>> for _ in range(2):
    ...     x += mixing.step(x, 0.5 * (x.values - 3.0))
    >>> float(x.values[0])
    3.0
    """

    def __init__(self, dot: Callable[[Array, Array], float], history: int) -> None:
        self._dot, self._history = dot, history
        self._last: tuple[State, Array] | None = None
        self._changes: list[tuple[Array, Array]] = []

    def step(self, state: State, correction: Array) -> Array:
        """Return the change of a state at which K^-1 R is `correction`."""
        if self._last is not None:
            change = state - self._last[0], correction - self._last[1]
            self._changes = [*self._changes, change][-self._history :]
        self._last = state, correction
        step = -correction
        for weight, (moved, turned) in zip(self._weights(correction), self._changes, strict=True):
            step = step - weight * (moved - turned)
        return step

    def _weights(self, correction: Array) -> Array:
        """Least squares of the correction by the changes of corrections."""
        if not self._changes:
            return np.zeros(0)
        turned = [change for _, change in self._changes]
        products = np.array([[self._dot(one, other) for other in turned] for one in turned])
        side = np.array([self._dot(one, correction) for one in turned])
        scale = 1 / np.sqrt(np.maximum(np.diag(products), 1e-300))
        scaled = np.linalg.lstsq(products * np.outer(scale, scale), side * scale, rcond=1e-14)[0]
        return np.asarray(scaled * scale)


class Progress:
    """The residuals with one factor, and whether a new one would cost less.

    It depends on the residuals alone, so every rank and every repetition decides the same.

    Parameters
    ----------
    rule : CorrectionRule
        When a new one is due.
    first : float
        Norm of the residual where it was made.
    accepted : float
        Norm to which it is to fall.

    Examples
    --------
    >>> quick, slow = (Progress(CorrectionRule(), 1.0, 1e-6) for _ in range(2))
    >>> for k in range(1, 4):
    ...     quick.note(0.1**k)
    ...     slow.note(0.9**k)
    >>> quick.is_slow, slow.is_slow
    (False, True)
    >>> strict = Progress(CorrectionRule(fruitless=0.3), 1.0, 1e-6)
    >>> strict.note(0.4)
    >>> strict.is_fruitless
    True
    """

    def __init__(self, rule: CorrectionRule, first: float, accepted: float) -> None:
        self._rule, self._norms, self._accepted = rule, [first], accepted

    def note(self, norm: float) -> None:
        """Take note of the norm after one more correction."""
        self._norms.append(norm)

    @property
    def is_fruitless(self) -> bool:
        """Whether the factor has left more of the residual than is accepted of a later one."""
        return self._norms[-1] > self._rule.fruitless * self._norms[0]

    @property
    def is_slow(self) -> bool:
        """Whether the corrections that are left are expected to cost more than a new factor."""
        rule, corrections = self._rule, len(self._norms) - 1
        if corrections < rule.fewest or self._norms[-1] <= self._accepted:
            return False
        window = min(rule.window, corrections)
        rate = (self._norms[-1] / self._norms[-1 - window]) ** (1 / window)
        to_go = math.log(self._accepted / self._norms[-1])
        here = to_go / math.log(min(rate, 0.98))
        anew = rule.tangent_cost + to_go / math.log(rule.fresh_rate)
        return here > anew or corrections >= rule.most
