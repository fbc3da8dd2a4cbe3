"""What every model of the shell returns of its way along the milestones."""

from typing import NamedTuple

from bilayer.results.result import MilestoneState


class Visit(NamedTuple):
    """What a visit to the milestones came to.

    Parameters
    ----------
    states : list of MilestoneState
        Of the milestones reached and, last, of the one where the path stopped.
    stop_reason : str
        Why it stopped, or an empty text.
    lost_start : bool
        Whether a start was given that led to no equilibrium; the path began flat then.
    """

    states: list[MilestoneState]
    stop_reason: str
    lost_start: bool = False
