"""One release by the paper's discrete shell, exactly as printed: a run in time from flat.

Natural lengths and angles grow linearly with time, a gravity that breaks the symmetry tapers off
to zero, a weak viscous force acts, the node nearest to the origin is held. Where Newton-Raphson
stops converging the run ends with its last shape, which the paper reports as a result too.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import INTERRUPTED, InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.result import MilestoneState
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.two_layers import TwoLayers
from dshell.energies.assembly import coordinates_of, total_energies
from dshell.models.interface import bonded_interface
from dshell.models.masses import lumped_masses
from dshell.models.paper_rest_state import Ramp, rest_state
from dshell.release.visit import Visit
from dshell.settings import PaperSettings
from dshell.solve.dynamics import ConvergenceError, Motion, MovingBody, Stepping, implicit_euler

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Release:
    """How one milestone ended.

    Parameters
    ----------
    state : MilestoneState
        Its shape and its numbers.
    stop_reason : str
        Why it stopped before its end, or an empty text.
    """

    state: MilestoneState
    stop_reason: str


def release_paper(
    specimen: Specimen,
    mesh: PlanarMesh,
    settings: PaperSettings,
    start: Array | None,
    progress: Progress | None,
) -> Visit:
    """Run every milestone by itself, from flat.

    Parameters
    ----------
    specimen : Specimen
        What to release; the settings' thickness rule takes the place of its own.
    mesh : PlanarMesh
        The flat bonded interface.
    settings : PaperSettings
        What the paper leaves open.
    start : None
        This model has no use for a start.
    progress : callable or None
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Visit
        A state per milestone; which of them stopped before their end, and why.

    Raises
    ------
    InputError
        A start or a true weight is given, or the layers are not as the paper has them.
    """
    _check_input(specimen, start)
    ruled = replace(specimen, prestretch=replace(specimen.prestretch, thickness=settings.thickness))
    releases: list[Release] = []
    try:
        for index, stretch in enumerate(ruled.prestretch.milestones):
            report = _milestone_report(progress, specimen, index)
            releases.append(release(ruled, mesh, stretch, settings, report))
        reasons = [done.stop_reason for done in releases if done.stop_reason]
    except KeyboardInterrupt:
        if not releases:
            raise
        reasons = [INTERRUPTED]
    return Visit([done.state for done in releases], "; ".join(reasons))


def release(
    specimen: Specimen,
    mesh: PlanarMesh,
    stretch: tuple[float, float],
    settings: PaperSettings,
    report: Callable[[float], None],
) -> Release:
    """Run one milestone from flat to the end of its ramp, or as far as it converges.

    Parameters
    ----------
    specimen : Specimen
        With the thickness rule that the run follows.
    mesh : PlanarMesh
        The flat bonded interface.
    stretch : (float, float)
        The milestone, (lambda_x, lambda_y).
    settings : PaperSettings
        What the paper leaves open.
    report : callable
        Called with the share of the ramp after each time step.
    """
    begun = time.perf_counter()
    thickness = specimen.bonded_layer("substrate", stretch).thickness
    body = paper_body(specimen, mesh, rest_state(specimen, mesh, stretch), stretch, settings)
    scale = force_scale(specimen, thickness)
    stepping = Stepping(
        settings.total_time / settings.steps,
        settings.steps,
        settings.tolerance * scale,
        settings.max_iterations,
    )
    motion = flat = flat_start(mesh, thickness)
    steps = iterations = 0
    error, failure = 0.0, ""
    try:
        for motion in implicit_euler(body, flat, stepping):
            steps, iterations, error = steps + 1, iterations + motion.iterations, motion.error
            report(steps / settings.steps)
    except ConvergenceError as stop:
        iterations, error = iterations + stop.iterations, stop.error
        failure = _stop_reason(max(stretch), steps / settings.steps, stop)
    state = MilestoneState(
        bonded_interface(motion.position, mesh.triangles, mesh.areas, thickness / 2),
        converged=not failure,
        reached=1 + (max(stretch) - 1) * steps / settings.steps,
        energy=energy_terms(body, motion),
        iterations=iterations,
        load_steps=steps,
        residual=error / scale,
        wall_time=time.perf_counter() - begun,
    )
    return Release(state, failure)


def paper_body(
    specimen: Specimen,
    mesh: PlanarMesh,
    ramp: Ramp,
    stretch: tuple[float, float],
    settings: PaperSettings,
) -> MovingBody:
    """Return what moves: the energies on their ramp, the lumped masses and the tapering gravity.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.
    ramp : Ramp
        The rest state.
    stretch : (float, float)
        The milestone, (lambda_x, lambda_y), which thins the substrate.
    settings : PaperSettings
        Duration, gravity and damping.
    """
    masses = np.repeat(lumped_masses(specimen, mesh, stretch)[:, None], 3, axis=1)
    weight = -settings.gravity * masses * [0, 0, 1]
    end = settings.total_time
    return MovingBody(
        masses,
        coordinates_of(np.array([mesh.centre_node])).reshape(-1),
        energies=lambda now: ramp.at(now / end),
        load=lambda now: (1 - now / end) * weight,
        damping_rate=settings.damping_rate,
    )


def flat_start(mesh: PlanarMesh, thickness: float) -> Motion:
    """Return the flat bonded state at rest: the substrate's mid-plane, below the bond at z = 0."""
    depth = np.full(len(mesh.points), -thickness / 2)
    position = np.column_stack([mesh.points, depth])
    return Motion(0.0, position, np.zeros_like(position))


def force_scale(specimen: Specimen, thickness: float) -> float:
    """Return the force that the tolerance is relative to, Y_s t_s R, N."""
    return specimen.carrier.material.young_modulus * thickness * specimen.characteristic_length


def energy_terms(body: MovingBody, motion: Motion) -> dict[str, float]:
    """Return the energies at one time, J; the kinetic one tells how far from rest the shape is."""
    elastic = total_energies(body.energies(motion.time), motion.position)
    return {**elastic, "kinetic": float(0.5 * (body.masses * motion.velocity**2).sum())}


def _stop_reason(prestretch: float, share: float, stop: ConvergenceError) -> str:
    return f"prestretch {prestretch:g} stopped after {share:.0%} of its ramp: {stop}"


def _check_input(specimen: Specimen, start: Array | None) -> None:
    if start is not None:
        raise InputError(
            "start = a result: the paper's model runs each milestone from flat, expected none"
        )
    if specimen.gravity > 0:
        raise InputError(
            f"gravity.acceleration = {specimen.gravity} m/s2: the paper's model ends without "
            "weight (its gravity tapers to zero), expected 0"
        )
    layers = TwoLayers.of(specimen, "model = 'paper'")
    if layers.kirigami_side != "above":
        raise InputError(
            f"kirigami.side = {layers.kirigami_side!r}: the paper's model has the kirigami layer "
            "above the substrate, expected 'above'"
        )
    if layers.stretched != ("substrate",) or not layers.follow_the_path:
        raise InputError(
            f"prestretch.layers = {list(layers.stretched)}: the paper's model stretches "
            "the substrate alone, expected ['substrate']"
        )


def _milestone_report(
    progress: Progress | None, specimen: Specimen, index: int
) -> Callable[[float], None]:
    """Return what passes the share of one milestone's ramp on as progress of the whole."""
    prestretches = specimen.prestretch.nominal

    def report(share: float) -> None:
        if progress is not None:
            text = f"prestretch {prestretches[index]:g}, {share:.0%} of the ramp"
            progress((index + share) / len(prestretches), text)

    return report
