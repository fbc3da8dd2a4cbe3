"""What it took to reach an equilibrium, added up from milestone to milestone."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Counts of what was done, failed attempts included.

    Parameters
    ----------
    iterations : int
        Newton iterations, each with one factorisation.
    flow_steps : int
        Time steps of the gradient flow.
    dissipated : float
        Energy that the flow's viscosity took away, J.
    escapes : int
        Unstable equilibria at a milestone that were left for a stable one.
    guided_steps : int
        Load steps that the start's shapes predicted, successful or not.
    """

    iterations: int = 0
    flow_steps: int = 0
    dissipated: float = 0.0
    escapes: int = 0
    guided_steps: int = 0

    def __add__(self, other: "Effort") -> "Effort":
        return Effort(
            self.iterations + other.iterations,
            self.flow_steps + other.flow_steps,
            self.dissipated + other.dissipated,
            self.escapes + other.escapes,
            self.guided_steps + other.guided_steps,
        )
