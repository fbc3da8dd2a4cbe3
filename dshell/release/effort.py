"""The work of a shell's path, as it adds up."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ShellEffort:
    """Work between two states of a path; see `bilayer.solvers.contract.Effort`.

    Parameters
    ----------
    iterations : int
        Newton iterations, failed attempts included.
    load_steps : int
        Load or time steps.
    """

    iterations: int = 0
    load_steps: int = 0

    def __add__(self, other: "ShellEffort") -> "ShellEffort":
        """Return the work of both."""
        return ShellEffort(self.iterations + other.iterations, self.load_steps + other.load_steps)


NO_EFFORT = ShellEffort()
