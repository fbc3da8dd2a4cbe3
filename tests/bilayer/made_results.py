"""Results whose shapes are known: the disc on spherical caps, as if a solver had found them."""

import math
from dataclasses import dataclass, replace

from shapes import cap

from bilayer import MeshSize, generate_mesh, paper_specimen
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.schema import MilestoneState


@dataclass(frozen=True)
class NoSettings:
    tolerance: float = 1e-8


def small_specimen(milestones=(1.03, 1.06, 1.09)):
    specimen = replace(paper_specimen(), mesh=MeshSize(0.01))
    return specimen.with_milestones(milestones)


def half_angle(prestretch):
    """A cap that is deeper the more is stretched."""
    return 8 * (1 - 1 / prestretch)


def cap_result(specimen=None, *, reached=None, motion=None, solver="dshell", **options):
    """Return a result of caps, moved by `motion`; milestones beyond `reached` are failures."""
    specimen = small_specimen() if specimen is None else specimen
    mesh = options.pop("mesh", None) or generate_mesh(specimen)
    reached = math.inf if reached is None else reached

    def state(milestone):
        at = min(milestone, reached)
        position = cap(mesh.points, half_angle(at))
        return MilestoneState(
            position if motion is None else motion(position),
            converged=milestone <= reached,
            reached=at,
            energy={"membrane": 1e-3, "bending": 2e-3},
            iterations=7,
            load_steps=2,
            residual=1e-9,
            wall_time=0.5,
            unstable_modes=0,
        )

    options = {
        "model": "paper",
        "settings": NoSettings(),
        "versions": {"numpy": "1"},
        **options,
    }
    stopped = "" if math.isinf(reached) else f"no convergence at {reached}"
    reason = options.pop("stop_reason", stopped)
    states = [state(milestone) for milestone in specimen.prestretch.nominal]
    made_by = Provenance.found(solver, **options)
    return build_result(specimen, mesh, states, made_by, stop_reason=reason)
