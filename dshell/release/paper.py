"""One release by the paper's discrete shell, exactly as printed: a run in time from flat.

Natural lengths and angles grow linearly with time, a gravity that breaks the symmetry tapers off
to zero, a weak viscous force acts, the node nearest to the origin is held. Where Newton-Raphson
stops converging the run ends with its last shape, which the paper reports as a result too.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError
from bilayer.measures.milestone import Measures, measure
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import UNKNOWN_STABILITY
from bilayer.results.starting import FLAT_START
from bilayer.solvers.contract import Linearised, Recorded, Saved, TargetMissedError
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair, stretch_of
from bilayer.specimen.specimen import (
    Specimen,
    refuse_fields,
    refuse_loading,
    refuse_obstacles,
    refuse_time,
)
from bilayer.specimen.two_layers import TwoLayers
from dshell.energies.assembly import coordinates_of, total_energies
from dshell.models.masses import lumped_masses
from dshell.models.paper_rest_state import Ramp, rest_state
from dshell.models.reference_surface import reference_surface_over
from dshell.release.effort import NO_EFFORT, ShellEffort
from dshell.release.specimen_path import VERSIONS
from dshell.release.static import between
from dshell.settings import PaperSettings
from dshell.solve.dynamics import ConvergenceError, Motion, MovingBody, Stepping, implicit_euler

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Run:
    """A run to one prestretch: what moves, in what time steps, from where."""

    specimen: Specimen
    mesh: PlanarMesh
    stretch: StretchPair
    thickness: float
    body: MovingBody
    stepping: Stepping
    force_scale: float


@dataclass(frozen=True, eq=False)
class PaperShape:
    """A state of a run; see `bilayer.solvers.contract.Equilibrium`, though it is none: it moves.

    Parameters
    ----------
    run : _Run
        Of which it is.
    motion : Motion
        Where the shell is, and how fast.
    error : float
        Norm of the last residual, N.
    share : float
        Part of the ramp that is done.
    effort : ShellEffort
        The work since the state before.
    """

    run: _Run
    motion: Motion
    error: float = 0.0
    share: float = 0.0
    effort: ShellEffort = NO_EFFORT

    @property
    def stretch(self) -> StretchPair:
        """Prestretch that the natural lengths and angles have grown to."""
        return between(UNSTRETCHED, self.run.stretch, self.share)

    @property
    def milestone(self) -> Milestone:
        """The same: this model has no loads."""
        return self.stretch

    @property
    def responses(self) -> Mapping[str, float]:
        """Return none."""
        return {}

    @property
    def position(self) -> Array:
        """The reference surface, m, shape (n, 3)."""
        mesh, height = self.run.mesh, self.run.thickness / 2
        return reference_surface_over(self.motion.position, mesh.triangles, mesh.areas, height)

    @property
    def energy(self) -> Mapping[str, float]:
        """Energy terms, J."""
        return energy_terms(self.run.body, self.motion)

    @property
    def residual(self) -> float:
        """Norm of the last residual over Y_s t_s R."""
        return self.error / self.run.force_scale

    @property
    def unstable_modes(self) -> int:
        """Return that nobody can tell: the shell moves."""
        return UNKNOWN_STABILITY

    def measures(self) -> Measures:
        """Return the measures of the shape."""
        return measure(self.run.specimen, self.run.mesh, self.stretch, self.position)

    def details(self) -> None:
        """Return None: this model has no variables of its own."""

    def layer_states(self) -> list[LayerState]:
        """Return none: springs and hinges have no strain in the layers."""
        return []

    def save(self) -> Saved:
        """Return nothing: the next run begins flat."""
        return {}

    def linearised(self) -> Linearised:
        """Raise ComputationError: there is no equilibrium to linearise at."""
        raise ComputationError("linearised: the paper's model ends in motion, not in equilibrium")


class PaperPath:
    """A run from flat for every prestretch; see `bilayer.solvers.contract.SpecimenPath`.

    Parameters
    ----------
    specimen : Specimen
        What to release; the settings' thickness rule takes the place of its own.
    mesh : PlanarMesh
        The flat reference surface.
    settings : PaperSettings
        What the paper leaves open.

    Raises
    ------
    InputError
        A true weight is given, or the layers are not as the paper has them.
    """

    comm = None
    versions = VERSIONS
    start = FLAT_START

    def __init__(self, specimen: Specimen, mesh: PlanarMesh, settings: PaperSettings) -> None:
        _check_input(specimen)
        self.mesh = mesh
        self._specimen, self._settings = specimen, settings
        ruled = replace(specimen.prestretch, thickness=settings.thickness)
        self._ruled = replace(specimen, prestretch=ruled)
        self._here: PaperShape | None = None

    def approach(self, target: Milestone) -> Iterator[PaperShape]:
        """Run from flat to the end of the ramp of a prestretch.

        Yields
        ------
        PaperShape
            The state after each time step.

        Raises
        ------
        TargetMissedError
            A time step does not converge: the last shape is where the run stopped.
        """
        run = self._run_to(stretch_of(target))
        flat = flat_start(run.mesh, run.thickness)
        self._here = PaperShape(run, flat)
        try:
            for step, motion in enumerate(implicit_euler(run.body, flat, run.stepping), 1):
                effort = ShellEffort(motion.iterations, 1)
                share = step / run.stepping.steps
                self._here = PaperShape(run, motion, motion.error, share, effort)
                yield self._here
        except ConvergenceError as stop:
            self._here = replace(self._here, error=stop.error, effort=ShellEffort(stop.iterations))
            raise TargetMissedError(
                f"prestretch {max(target):g} stopped after {self._here.share:.0%} of its ramp: "
                f"{stop}"
            ) from stop

    def stopped(self) -> PaperShape:
        """Return the last state of the run; see `Path`."""
        assert self._here is not None, "a run has begun"
        return self._here

    def restore(self, saved: Saved) -> None:
        """Do nothing: the next run begins flat."""

    def restore_neighbour(
        self, saved: Saved, target: Milestone | None = None, change: Array | None = None
    ) -> None:
        """Do nothing: the next run begins flat."""

    def variables(self, milestones: Sequence[Recorded | None]) -> xr.Dataset:
        """Return an empty dataset: this model has no variables of its own."""
        return xr.Dataset()

    def close(self) -> None:
        """Free nothing: Python does."""

    def _run_to(self, stretch: StretchPair) -> _Run:
        specimen, mesh, settings = self._ruled, self.mesh, self._settings
        thickness = specimen.bonded_layer("substrate", stretch).thickness
        scale = force_scale(specimen, thickness)
        stepping = Stepping(
            settings.total_time / settings.steps,
            settings.steps,
            settings.tolerance * scale,
            settings.max_iterations,
        )
        body = paper_body(specimen, mesh, rest_state(specimen, mesh, stretch), stretch, settings)
        return _Run(self._specimen, mesh, stretch, thickness, body, stepping, scale)


def paper_body(
    specimen: Specimen,
    mesh: PlanarMesh,
    ramp: Ramp,
    stretch: tuple[float, float],
    settings: PaperSettings,
) -> MovingBody:
    """Return the moving body: energies on their ramp, lumped masses and the tapering gravity.

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


def _check_input(specimen: Specimen) -> None:
    refuse_loading(specimen, "the paper's model")
    refuse_time(specimen, "the paper's model")
    refuse_fields(specimen, "the paper's model")
    refuse_obstacles(specimen, "the paper's model")
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
