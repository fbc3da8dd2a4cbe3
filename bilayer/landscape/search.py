"""The search for the stable shapes of a specimen at one prestretch."""

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import INTERRUPTED, ComputationError, InputError, Interrupted
from bilayer.landscape.catalogue import Catalogue, State
from bilayer.landscape.dataset import read_catalogue, states_dataset
from bilayer.landscape.schedule import schedule
from bilayer.landscape.starts import Sheet, Start
from bilayer.landscape.symmetry import Images, interpolation, symmetry_of
from bilayer.measures.milestone import Measures, measure
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.assembly import Provenance
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import MilestoneState, result_mesh
from bilayer.runtime.progress import Progress
from bilayer.runtime.termination import signals_put_off
from bilayer.solvers.contract import Equilibrium, Solver, StateFinder
from bilayer.solvers.path import follow_path
from bilayer.solvers.registry import settings_class, solver_named, specimen_given
from bilayer.solvers.resuming import check_same_run
from bilayer.solvers.run import model_of
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair
from bilayer.specimen.specimen import Specimen
from bilayer.validation import whole

Array = NDArray[np.float64]

STARTS = 60
"""Of a search, unless told: 1 to 2 minutes on the paper's specimen at 6 mm."""
MOST_STARTS = 100_000
STIFFNESSES = 2
"""Eigenvalues of each state."""


def states(
    specimen: Specimen | str | Path,
    settings: Any = None,
    *,
    starts: int = STARTS,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | None = None,
    progress: Progress | None = None,
    output: str | Path | None = None,
    resume: str | Path | None = None,
) -> xr.Dataset:
    """Find the stable shapes of a specimen at its last milestone, by the discrete shell.

    Each start goes downhill in energy; an equilibrium that is not stable is left to both sides of
    its unstable modes. Shapes that the specimen's own symmetry and a rigid motion bring onto each
    other are one state. docs/states.md has the starts and what the numbers mean.

    Parameters
    ----------
    specimen : Specimen or path-like
        The specimen, or its file.
    settings : MorleySettings or HingeSettings, optional
        Of the shell; the defaults of `morley` if left out.
    starts : int
        How many starts.
    mesh : PlanarMesh, optional
        The planar mesh to use; made from the specimen if left out.
    start : Dataset, optional
        A result, such as the states of another mesh or of a specimen that differs by little: its
        shapes are the first starts.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    output : path-like, optional
        File of the states: all that are known are in it after every start.
    resume : path-like, optional
        File of a search of the same specimen, prestretch and settings: go on from it.

    Returns
    -------
    Dataset
        A result with a milestone for each state, the lowest energy first, all at the same
        prestretch, and what the search knows of them; see `bilayer.landscape.dataset.VARIABLES`.

    Raises
    ------
    InputError
        See the message.
    ComputationError
        No start led to a stable shape.
    Interrupted
        Ctrl-C; with the states that were known, if there were any.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.016))  # coarse: for the example
    >>> found = bilayer.states(specimen, starts=2)  # far too few to be sure
    >>> found["times_found"].values.tolist()
    [2]
    """
    asked = specimen_given(specimen)
    solver = solver_named("dshell")
    chosen = settings_class("dshell")() if settings is None else settings
    count = whole("starts", starts, 1, MOST_STARTS)
    search = Search(asked, solver, chosen, count, mesh, output, start)
    if resume is not None:
        search.restore(resume)
    return search.run(progress)


class Search:
    """A search; see `states`.

    Parameters
    ----------
    specimen : Specimen
        Its last milestone counts.
    solver : Solver
        One that has a finder.
    settings : settings dataclass
        Of one of its models.
    starts : int
        How many starts.
    mesh : PlanarMesh or None
        The planar mesh; made from the specimen if None.
    output : path-like or None
        File of the states.
    start : Dataset or None
        A result whose shapes are the first starts.
    """

    def __init__(
        self,
        specimen: Specimen,
        solver: Solver,
        settings: Any,
        starts: int,
        mesh: PlanarMesh | None = None,
        output: str | Path | None = None,
        start: xr.Dataset | None = None,
    ) -> None:
        if output is not None:
            check_result_output(output)
        if specimen.supports or specimen.loads:
            raise InputError("specimen: has supports or loads, a search for states has none")
        if solver.open_finder is None:
            raise InputError(f"solver = {solver.name!r}: has no search, expected 'dshell'")
        self.stretch: StretchPair = specimen.prestretch.milestones[-1]
        self.specimen, self._starts, self._output = specimen, starts, output
        self._solver, self._settings, self._mesh = solver, settings, mesh
        self._model = model_of(solver, settings)
        self._catalogue: Catalogue | None = None
        self._start = start

    def restore(self, path: str | Path) -> None:
        """Go on from the file of a search that was not finished, or of one with fewer starts."""
        earlier = open_result(path)
        same = self.specimen.with_milestones([self.stretch] * earlier.sizes["prestretch"])
        check_same_run(
            earlier, path, same, self._solver.name, self._model, self._settings, self._mesh
        )
        self._mesh = result_mesh(earlier)
        images = Images(self._mesh, symmetry_of(self.specimen, self.stretch))
        try:
            self._catalogue = read_catalogue(earlier, images, self.specimen.characteristic_length)
        except InputError as error:
            raise InputError(f"result file {path}: {error}") from error

    def run(self, progress: Progress | None = None) -> xr.Dataset:
        """Take all starts; return the states."""
        assert self._solver.open_finder is not None
        finder = self._solver.open_finder(
            self.specimen, self._settings, self.stretch, mesh=self._mesh
        )
        self._mesh = finder.mesh
        provenance = Provenance.found(
            self._solver.name, self._model, self._settings, finder.versions
        )
        catalogue = self._catalogue or self._empty_catalogue(finder.mesh)
        try:
            for _ in self._visits(finder, catalogue, progress):
                if self._output is not None and catalogue.states:
                    with signals_put_off():
                        found = self._dataset(catalogue, provenance, INTERRUPTED)
                        write_result(found, self._output)
        except KeyboardInterrupt as interrupt:
            if not catalogue.states:
                raise
            with signals_put_off():
                found = self._dataset(catalogue, provenance, INTERRUPTED)
                raise Interrupted(found, self._output) from interrupt
        if not catalogue.states:
            raise ComputationError(f"none of {self._starts} starts led to a stable shape")
        with signals_put_off():
            found = self._dataset(catalogue, provenance, "")
            if self._output is not None:
                write_result(found, self._output)
        return found

    def _empty_catalogue(self, mesh: PlanarMesh) -> Catalogue:
        images = Images(mesh, symmetry_of(self.specimen, self.stretch))
        return Catalogue(images, self.specimen.characteristic_length)

    def _dataset(
        self, catalogue: Catalogue, provenance: Provenance, stop_reason: str
    ) -> xr.Dataset:
        mesh = catalogue.images.mesh
        return states_dataset(
            self.specimen, self.stretch, mesh, catalogue, provenance, self._starts, stop_reason
        )

    def _visits(
        self, finder: StateFinder, catalogue: Catalogue, progress: Progress | None
    ) -> Iterator[None]:
        """Take the starts that have not been taken; yield after each."""
        sheet = Sheet(finder.mesh, self.specimen.characteristic_length)
        done = {name for name, _ in catalogue.visits}
        given = [] if self._start is None else shapes_on(finder.mesh, self._start)
        for start in schedule(sheet, catalogue, self._follow_path, given):
            if len(catalogue.visits) >= self._starts:
                return
            if start.name in done:
                continue
            if progress is not None:
                known = f"{len(catalogue.states)} states, next: {start.name}"
                progress(len(catalogue.visits) / self._starts, known)
            self._visit(finder, catalogue, start)
            yield

    def _visit(self, finder: StateFinder, catalogue: Catalogue, start: Start) -> None:
        """Take a start and keep what it leads to."""
        begun = time.perf_counter()
        try:
            shape = start.make_shape()
            if start.avoids_known:
                found = finder.settle_elsewhere(shape, list(catalogue.shapes_to_avoid()))
            else:
                found = finder.settle(shape)
        except ComputationError:
            found = []
        seconds = time.perf_counter() - begun
        kept = [self._keep(finder, catalogue, each, seconds) for each in found]
        catalogue.visits.append((start.name, tuple(kept)))

    def _keep(
        self, finder: StateFinder, catalogue: Catalogue, found: Equilibrium, seconds: float
    ) -> int:
        """Return the place of the state that a find is."""
        energy = sum(found.energy.values())
        place = catalogue.place_of(found.position, energy)
        if place is None:
            return catalogue.add(self._state(finder, catalogue, found, seconds))
        catalogue.count_again(place)
        if catalogue.is_lower(place, energy):
            catalogue.keep_image(place, self._state(finder, catalogue, found, seconds))
        return place

    def _state(
        self, finder: StateFinder, catalogue: Catalogue, found: Equilibrium, seconds: float
    ) -> State:
        """Return a find with its measures, stiffness and symmetry."""
        milestone = MilestoneState(
            found.position,
            converged=True,
            reached=max(self.stretch),
            energy=dict(found.energy),
            iterations=found.effort.iterations,
            load_steps=found.effort.load_steps,
            residual=found.residual,
            wall_time=seconds,
            unstable_modes=found.unstable_modes,
            measures=self._measured(found.position, finder.mesh),
        )
        stiffness = finder.stiffnesses(found, STIFFNESSES)
        symmetry = catalogue.symmetry_of(found.position)
        return State(milestone, stiffness, symmetry)

    def _measured(self, position: Array, mesh: PlanarMesh) -> Measures:
        """Return the measures of a shape, NaN if they fail."""
        try:
            return measure(self.specimen, mesh, self.stretch, position)
        except Exception:  # whatever it is, the state is there and is kept
            return Measures.undefined()

    def _follow_path(self, steps: int) -> Array:
        """Return the shape at the end of a load path from flat in equal steps."""
        shares = np.arange(1, steps + 1) / steps
        ways = [
            tuple(a + share * (b - a) for a, b in zip(UNSTRETCHED, self.stretch, strict=True))
            for share in shares
        ]
        specimen = self.specimen.with_milestones([*ways[:-1], self.stretch])  # type: ignore[list-item]
        path = self._solver.open_path(
            specimen, self._settings, mesh=self._mesh, start=None, comm=None, progress=None
        )
        with closing(path):
            for step in follow_path(path, specimen.prestretch.milestones):
                if step.failure is not None:
                    raise ComputationError(str(step.failure)) from step.failure
            return step.point.position


def shapes_on(mesh: PlanarMesh, result: xr.Dataset) -> list[Array]:
    """Return the shapes that a result reached, on a mesh, linear between the nodes of its own."""
    result = along_milestones(result)
    shapes = result["position"].values[result["converged"].values == 1]
    own = result_mesh(result)
    if own.same_as(mesh):
        return list(shapes)
    values_at = interpolation(own, mesh.points)
    return [values_at @ shape for shape in shapes]
