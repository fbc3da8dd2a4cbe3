"""The relaxation of a material as a Prony series: how much of a stress is left after a time.

    g(t) = 1 - sum g_i (1 - exp(-t / tau_i)) = g_inf + sum g_i exp(-t / tau_i),

of a strain that is held from time 0 on. The constants of the law are the instantaneous ones, g(0),
as Abaqus has them with MODULI=INSTANTANEOUS.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.units import in_si
from bilayer.validation import finite, listed, positive, shown

Array = NDArray[np.float64]

MOST_TERMS = 20
EXAMPLE = '[[0.5, "6 s"], [0.2, "60 s"]]'
ALMOST_ALL = 1e-12
"""The shares may exceed 1 by so much round-off."""


@dataclass(frozen=True)
class PronySeries:
    """A Prony series; without terms the material is elastic.

    Parameters
    ----------
    terms : sequence of (float, float)
        Share g_i of the instantaneous stress, and the time tau_i in which it relaxes, s.

    Examples
    --------
    >>> series = PronySeries([(0.5, 6.0), (0.2, 60.0)])
    >>> round(float(series.stress_left(6.0)), 6)
    0.664907
    """

    terms: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        given = [_term(item) for item in listed("relaxation", self.terms)]
        if len(given) > MOST_TERMS:
            raise InputError(f"relaxation: has {len(given)} terms, expected at most {MOST_TERMS}")
        total = sum(share for share, _ in given)
        if total > 1 + ALMOST_ALL:
            raise InputError(f"relaxation: its shares add up to {total:g}, expected at most 1")
        object.__setattr__(self, "terms", tuple(given))

    @classmethod
    def from_file(cls, field: str, given: Any) -> "PronySeries":
        """Return the series of a list [[share, time], ...] in a file; times may have units.

        Raises
        ------
        InputError
            It is no such list; `field` is what the message calls it.
        """
        try:
            pairs = [(share, time) for share, time in listed(field, given)]
        except InputError:
            raise
        except (TypeError, ValueError) as error:
            raise InputError(f"{field} = {shown(given)}: expected such as {EXAMPLE}") from error
        return cls(
            tuple(
                (share, in_si(field, {"time": time}, {"time": "s"})["time"])
                for share, time in pairs
            )
        )

    @property
    def shares(self) -> Array:
        """g_i, (n,)."""
        return np.array([share for share, _ in self.terms])

    @property
    def times(self) -> Array:
        """tau_i, s, (n,)."""
        return np.array([time for _, time in self.terms])

    @property
    def relaxed_share(self) -> float:
        """g_inf, the share of a stress that never relaxes."""
        return max(0.0, 1.0 - sum(share for share, _ in self.terms))

    def stress_left(self, time: Any) -> Any:
        """Return g(t), the share of a stress that is left after so many seconds."""
        after = np.asarray(time, dtype=float)[..., None]
        return 1.0 - (self.shares * -np.expm1(-after / self.times)).sum(axis=-1)


ELASTIC = PronySeries()


def _term(item: Any) -> tuple[float, float]:
    pair = list(item) if isinstance(item, Sequence) and not isinstance(item, str) else []
    if len(pair) != 2:
        raise InputError(f"relaxation: {shown(item)}: expected [share, time] such as {EXAMPLE}")
    share = finite("relaxation: share", pair[0])
    if not 0 <= share <= 1:
        raise InputError(f"relaxation: share = {share:g}: expected from 0 to 1")
    return share, positive("relaxation: time", pair[1], "s")
