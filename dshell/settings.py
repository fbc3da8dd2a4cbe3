"""Settings of the discrete shell's models."""

import math
from dataclasses import dataclass
from typing import ClassVar

from bilayer.errors import InputError
from bilayer.specimen.prestretch import BONDED_THICKNESS_RULES
from bilayer.specimen.settings import BRANCH_CHOICES, CONTACT_CHOICES, setting
from bilayer.validation import (
    LARGEST,
    fraction,
    keep,
    not_negative,
    one_of,
    positive,
    whole,
    within,
)
from dshell.energies.through_thickness import PROFILES

WALLS = ("strained", "relieved")
"""What layers do at the walls where they end: `dshell.models.wall_relief`."""
METHOD_NAMES = ("static", "dynamic")
"""Methods that find a shape: `dshell.release.static` and `dshell.release.dynamic`."""
MOST_TIME_STEPS = 10_000_000
MOST_ITERATIONS = 100_000
"""In one load step; what takes more does not converge."""


@dataclass(frozen=True)
class ReleaseSettings:
    """Settings of the search for equilibria, shared by the models `morley` and `hinge`."""

    method: str = setting(
        "static",
        "'static': Newton's method on the energy; 'dynamic': damped motion until it is at rest",
    )
    total_time: float = setting(
        20.0, "dynamic: time to each milestone; the prestretch grows in its first half [s]"
    )
    time_step: float = setting(
        0.01, "dynamic: first time step of implicit Euler; later ones adapt [s]"
    )
    damping_rate: float = setting(10.0, "dynamic: viscous force per mass and velocity [1/s]")
    tolerance: float = setting(
        1e-8, "norm of the residual force at an equilibrium over that of the flat state"
    )
    max_iterations: int = setting(200, "Newton iterations allowed in one load step")
    ramp: float = setting(
        0.015, "growth of the prestretch in each of the first Newton iterations of a load step [1]"
    )
    longest_step: float = setting(
        0.5,
        "maximum nodal displacement per Newton iteration, as a fraction of the outer radius [1]",
    )
    smallest_step: float = setting(
        0.01, "smallest load step, as a fraction of the way between two milestones [1]"
    )
    coarse_triangles: int = setting(
        1500,
        "static: a mesh with more than 4 times as many triangles starts from the shape on a "
        "coarse mesh with about this number; 0: from flat",
    )
    branch: str = setting(
        "lowest",
        "after a loss of stability, follow the branch of lowest energy ('lowest'), the other one "
        "('other'), or stay on the unstable one ('unstable')",
    )

    contact: str = setting(
        "none",
        "'barrier': the sheet does not pass through itself (frictionless contact; needs ipctk); "
        "'none': it may, and shapes that do are flagged",
    )
    contact_range: float = setting(
        0.1,
        "barrier: distance from which on nothing acts, as a fraction of the thickness of all "
        "layers; less if the flat mesh has smaller distances [1]",
    )

    def __post_init__(self) -> None:
        keep(self, one_of, "method", table="solver.", choices=METHOD_NAMES)
        keep(self, one_of, "contact", table="solver.", choices=CONTACT_CHOICES)
        keep(self, positive, "contact_range", table="solver.")
        if self.contact == "barrier" and self.method == "dynamic":
            raise InputError(
                "solver.contact = 'barrier': expected solver.method = 'static', got 'dynamic', "
                "which does not model contact"
            )
        keep(self, one_of, "branch", table="solver.", choices=BRANCH_CHOICES)
        _keep_times(self)
        keep(self, not_negative, "damping_rate", table="solver.", unit="1/s")
        keep(self, whole, "max_iterations", table="solver.", at_least=1, at_most=MOST_ITERATIONS)
        keep(self, whole, "coarse_triangles", table="solver.", at_least=0)
        keep(self, fraction, "tolerance", table="solver.")
        keep(self, within, "ramp", table="solver.", low=1e-4, high=LARGEST)
        keep(self, within, "longest_step", table="solver.", low=1e-4, high=LARGEST)
        keep(self, within, "smallest_step", table="solver.", low=1e-6, high=1.0)


@dataclass(frozen=True)
class MorleySettings(ReleaseSettings):
    """The accurate shell: Morley's bending on the laminate's own layers.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.MorleySettings(contact="barrier").contact
    'barrier'
    """

    profile: str = setting(
        "quadratic",
        "strain through the thickness: 'quadratic' E + z k - z^2 det(k) / 2, 'linear' E + z k",
    )
    walls: str = setting(
        "strained",
        "layers at the free walls where they end, at cuts and rims: 'strained' as the shell "
        "around them, 'relieved' as the section across the wall by finite elements tells",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        keep(self, one_of, "profile", table="solver.", choices=PROFILES)
        keep(self, one_of, "walls", table="solver.", choices=WALLS)


@dataclass(frozen=True)
class HingeSettings(ReleaseSettings):
    """Hinges and springs with the rest state of laminate theory.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.HingeSettings(tolerance=1e-9).tolerance
    1e-09
    """


@dataclass(frozen=True)
class PaperSettings:
    """Settings of the paper's shell that the paper leaves open; see docs/theory-dshell.md.

    Examples
    --------
    >>> import bilayer
    >>> settings = bilayer.PaperSettings()
    """

    stopping_is_a_result: ClassVar[bool] = True  # where it fails is one of the paper's results

    thickness: str = setting(
        "constant",
        "thickness of the bonded substrate, in place of prestretch.thickness: "
        "'constant' as printed, 'natural' divided by the stretch's area ratio",
    )
    total_time: float = setting(
        1.0, "duration of the ramp of natural lengths and angles, and of the run [s]"
    )
    time_step: float = setting(0.001, "time step of implicit Euler [s]")
    gravity: float = setting(
        0.5, "symmetry-breaking acceleration along -z at the start, tapered to 0 at the end [m/s2]"
    )
    damping_rate: float = setting(10.0, "viscous force per mass and velocity [1/s]")
    tolerance: float = setting(
        1e-8, "norm of the residual force at convergence over Y_s t_s times the outer radius"
    )
    max_iterations: int = setting(200, "Newton-Raphson iterations allowed in a time step")

    def __post_init__(self) -> None:
        keep(self, one_of, "thickness", table="solver.", choices=BONDED_THICKNESS_RULES)
        _keep_times(self)
        keep(self, not_negative, "gravity", table="solver.", unit="m/s2")
        keep(self, not_negative, "damping_rate", table="solver.", unit="1/s")
        keep(self, fraction, "tolerance", table="solver.")
        keep(self, whole, "max_iterations", table="solver.", at_least=1, at_most=MOST_ITERATIONS)

    @property
    def steps(self) -> int:
        """Number of equal time steps that fill the total time, none longer than `time_step`."""
        return math.ceil(self.total_time / self.time_step * (1 - 1e-12))


def _keep_times(settings: "ReleaseSettings | PaperSettings") -> None:
    """Raise InputError unless a time step fits into the total time, not too many times."""
    keep(settings, positive, "total_time", "time_step", table="solver.", unit="s")
    total_time, time_step = settings.total_time, settings.time_step
    shortest = total_time / MOST_TIME_STEPS
    if not shortest <= time_step <= total_time:
        raise InputError(
            f"solver.time_step = {time_step} s: expected at most "
            f"solver.total_time = {total_time} s and at least {shortest:g} s, a "
            f"{MOST_TIME_STEPS}th of it"
        )
