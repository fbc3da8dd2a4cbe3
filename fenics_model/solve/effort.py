"""The work to reach an equilibrium, added up from milestone to milestone."""

from dataclasses import dataclass, field, fields


@dataclass(frozen=True)
class Work:
    """CPU seconds of this process, and counts.

    Parameters
    ----------
    factorisations : int
        Of tangents, those for the inertia included.
    assembly : float
        Residuals and tangents, s.
    factorisation : float
        Factorisations and the solutions with them, s.
    total : float
        Everything, s.
    corrections : int
        Of states, each a solution with a factor that was there.
    """

    factorisations: int = 0
    assembly: float = 0.0
    factorisation: float = 0.0
    total: float = 0.0
    corrections: int = 0

    def __add__(self, other: "Work") -> "Work":
        return Work(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(Work)))


@dataclass(frozen=True)
class Effort:
    """Counts of what was done, failed attempts included.

    Parameters
    ----------
    iterations : int
        Newton iterations: new tangents, each with one factorisation.
    load_steps : int
        Load steps that came to an equilibrium.
    flow_steps : int
        Time steps of the gradient flow.
    dissipated : float
        Energy that the flow's viscosity took away, J.
    escapes : int
        Unstable equilibria at a milestone that were left for a stable one.
    guided_steps : int
        Load steps that the start's shapes predicted, successful or not.
    work : Work
        Seconds and factorisations.
    """

    iterations: int = 0
    load_steps: int = 0
    flow_steps: int = 0
    dissipated: float = 0.0
    escapes: int = 0
    guided_steps: int = 0
    work: Work = field(default_factory=Work)

    def __add__(self, other: "Effort") -> "Effort":
        return Effort(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(Effort)))
