"""What a design shall bear: small errors of what is made, each a specimen beside the nominal one.

A relative error of 5 % of the prestretch is one of its strain, lambda - 1: nobody errs by 5 % of
lambda at 1.06.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.designing.variables import value_of, with_values
from bilayer.errors import InputError
from bilayer.specimen.specimen import Specimen
from bilayer.validation import fraction, keep, listed, one_of, text

Array = NDArray[np.float64]

MEANS = ("mean", "worst")
WORST_POWER = 4
"""Of the power mean of the squared distances that stands for the worst of them, smoothly."""


@dataclass(frozen=True)
class Scenario:
    """Relative errors of some numbers of a specimen; none of the nominal one.

    Parameters
    ----------
    errors : mapping of str to float
        By the name of the number, see `bilayer.designing.variables`.
    """

    errors: Mapping[str, float]

    @property
    def words(self) -> str:
        """Description for a report."""
        return ", ".join(f"{name} {error:+.0%}" for name, error in self.errors.items()) or "nominal"

    def specimen(self, nominal: Specimen) -> Specimen:
        """Return the specimen with these errors."""
        values = {name: _erring(name, value_of(nominal, name), error)
                  for name, error in self.errors.items()}  # fmt: skip
        return with_values(nominal, values)

    def slopes(self, names: tuple[str, ...]) -> Array:
        """Return the derivative of each number with its error by the nominal one, (k,)."""
        return np.array([1 + self.errors.get(name, 0.0) for name in names])


def _erring(name: str, value: float, error: float) -> float:
    if name.split(".")[0] == "prestretch":
        return 1 + (1 + error) * (value - 1)
    return (1 + error) * value


@dataclass(frozen=True)
class Robustness:
    """The errors that are looked at, and what is minimised over them.

    Parameters
    ----------
    spread : float
        Relative error of each number, up and down, one at a time.
    of : sequence of str
        The numbers; none: the nominal specimen alone.
    minimise : {"mean", "worst"}
        Of the squared distances over all scenarios, the nominal one among them.
    """

    spread: float = 0.05
    of: tuple[str, ...] = ()
    minimise: str = "mean"

    def __post_init__(self) -> None:
        keep(self, fraction, "spread", table="robust.")
        keep(self, one_of, "minimise", table="robust.", choices=MEANS)
        names = tuple(text("robust.of", name) for name in listed("robust.of", self.of))
        if len(set(names)) < len(names):
            raise InputError(f"robust.of = {list(names)}: expected each parameter once")
        object.__setattr__(self, "of", names)

    @property
    def scenarios(self) -> tuple[Scenario, ...]:
        """The nominal one, and each error alone."""
        errors = [{name: sign * self.spread} for name in self.of for sign in (1.0, -1.0)]
        return tuple(map(Scenario, [{}, *errors]))

    def total(self, values: Array) -> tuple[float, Array]:
        """Return what is minimised, and its derivatives by the values of the scenarios, (s,)."""
        if self.minimise == "mean":
            return float(values.mean()), np.full(len(values), 1 / len(values))
        scaled = values / values.max()
        mean = np.mean(scaled**WORST_POWER)
        total = values.max() * mean ** (1 / WORST_POWER)
        weights = scaled ** (WORST_POWER - 1) * mean ** (1 / WORST_POWER - 1) / len(values)
        return float(total), weights
