"""A design from its task to its end: stages of the search, and a last look from the flat sheet."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.designing.checked import CHECK_SOLVER, Checked, check_design
from bilayer.designing.equilibria import Model
from bilayer.designing.evaluation import Evaluation
from bilayer.designing.fields import cut_out, has_fields
from bilayer.designing.folder import DesignFolder
from bilayer.designing.lowest import Lowest, look_for_lowest
from bilayer.designing.stage import Stage, correction_between
from bilayer.designing.task import DESIGN_SOLVER, DesignTask, read_design
from bilayer.designing.trust_region import Iterate, NoValueError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.files import open_result
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import settings_class, solve, solver_named
from bilayer.specimen.specimen import MeshSize, Specimen

Array = NDArray[np.float64]

ENOUGH_FALL = 0.02
"""Fall of the value in a stage, relative, that is worth another one."""
WORSE = 1.5
"""A value from flat, over that along the way, which is another shape's and not another mesh's."""
CORRECTED_EVALUATIONS = 5
"""Of a search with corrected shapes, which are true near the checked design alone."""
NEARBY = {"first_step": 0.05, "largest_step": 0.1, "smallest_step": 0.01, "flow_steps": 0}
"""Settings of the finite-element model from one design to the next: a far one fails soon."""
NEAR_ENOUGH = 0.05
"""Margin of the least stiffness, relative, that holds a design."""
FIRST_RADIUS_AGAIN = 0.05
"""Half the width of the first box of a later stage."""


@dataclass(frozen=True, eq=False)
class Tried:
    """An evaluation of the search, for its history.

    Parameters
    ----------
    stage : int
        From 1.
    distances : tuple of float
        By scenario, m; empty if there was no shape.
    best : float
        The nominal distance of the best design of the stage so far, m.
    radius : float
        Half the width of the next box.
    failure : str
        Why there was no shape, or empty.
    solver : str
        Which model computed it.
    """

    stage: int
    distances: tuple[float, ...]
    best: float
    radius: float
    failure: str
    solver: str = DESIGN_SOLVER


@dataclass(frozen=True, eq=False)
class DesignOutcome:
    """A design.

    Parameters
    ----------
    task : DesignTask
        What was wanted.
    specimen : Specimen
        The design.
    mesh : PlanarMesh
        On which its shapes were found.
    along_the_way : Evaluation
        The best evaluation of the search.
    from_flat : Evaluation
        The same design, its shapes found from the flat sheet on a mesh of its own; that along the
        way if there are none.
    flat_failure : str
        Why there are none from flat, or empty.
    check_failure : str
        Why the last check came to nothing, or empty.
    lowest : Lowest or None
        What a search for lower states found, if one was wanted.
    history : tuple of Tried
        All evaluations.
    checks : tuple of Checked
        Designs as the finite-element model has them; the last one is of this design.
    """

    task: DesignTask
    specimen: Specimen
    mesh: PlanarMesh
    along_the_way: Evaluation
    from_flat: Evaluation
    history: tuple[Tried, ...]
    checks: tuple[Checked, ...] = ()
    flat_failure: str = ""
    check_failure: str = ""
    lowest: Lowest | None = None

    @property
    def solves(self) -> int:
        """Number of shapes that the shell computed, or tried."""
        return self._solves_by(DESIGN_SOLVER)

    @property
    def solves_by_elements(self) -> int:
        """Number of shapes that the finite-element model computed, or tried."""
        return len(self.checks) + self._solves_by(CHECK_SOLVER)

    def _solves_by(self, solver: str) -> int:
        tried = [each for each in self.history if each.solver == solver]
        return len(tried) * len(self.task.robustness.scenarios)

    @property
    def is_by_elements(self) -> bool:
        """Whether the finite-element model ended the search."""
        return self._solves_by(CHECK_SOLVER) > 0

    @property
    def is_the_same_from_flat(self) -> bool:
        """Whether the flat sheet comes to the shape of the search, but for the mesh."""
        along = self.along_the_way
        if self.is_by_elements:
            last = self.checks[-1].distance.mean_square
            return not self.check_failure and last <= WORSE * along.shapes[0].distance ** 2
        return not self.flat_failure and self.from_flat.value <= WORSE * along.value

    @property
    def bounds_reached(self) -> list[str]:
        """What holds the design: bounds of variables, and least widths."""
        variables = self.task.variables.variables
        ends = [
            f"{variable.name} = {bound:.6g}"
            for variable, share in zip(variables, self.from_flat.point, strict=True)
            for bound, at in ((variable.low, share < 1e-3), (variable.high, share > 1 - 1e-3))
            if at
        ]
        margin = self.from_flat.margins.min(initial=np.inf)
        softest = ["least_stiffness"] if margin < NEAR_ENOUGH else []
        return ends + self.task.widths.binding(self.specimen) + softest


def design(
    task: DesignTask | str | Path,
    folder: str | Path,
    *,
    progress: Progress | None = None,
    observer: Callable[[Tried], None] | None = None,
) -> DesignOutcome:
    r"""Design a specimen that takes a wanted shape.

    Parameters
    ----------
    task : DesignTask or path-like
        What is wanted, or its file.
    folder : path-like
        Keeps all evaluations. Called again with the same task and folder, a design that was ended
        at any moment goes on, and comes to the same end.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    observer : callable, optional
        Told of each evaluation.

    Returns
    -------
    DesignOutcome
        The design.

    Raises
    ------
    InputError
        See the message.
    ComputationError
        The specimen that the search begins with has no shape.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import bilayer
    >>> sheet = bilayer.paper_specimen().with_milestones([1.06])
    >>> sheet = bilayer.Specimen(
    ...     sheet.outline, sheet.layers, sheet.prestretch, bilayer.MeshSize(0.013)
    ... )
    >>> folder = Path(tempfile.mkdtemp())
    >>> _ = (folder / "sheet.toml").write_text(bilayer.specimen_to_toml(sheet))
    >>> _ = (folder / "design.toml").write_text(
    ...     'specimen = "sheet.toml"\n'
    ...     'target = { shape = "hemisphere" }\n'
    ...     'free = { prestretch = [1.02, 1.2] }\n'
    ...     'search = { evaluations = 3 }\n'
    ... )
    >>> outcome = bilayer.design(folder / "design.toml", folder / "dome")
    >>> outcome.from_flat.value < outcome.task.target.diagonal**2
    True
    >>> outcome.specimen.prestretch.milestones[0][0] > 1.06
    True
    """
    wanted = task if isinstance(task, DesignTask) else read_design(task)
    held = DesignFolder(folder)
    with held.lock():
        held.claim(wanted.identity)
        return _Design(wanted, held, progress, observer).run()


class _Design:
    """The run of a design."""

    def __init__(
        self,
        task: DesignTask,
        folder: DesignFolder,
        progress: Progress | None,
        observer: Callable[[Tried], None] | None,
    ) -> None:
        self._task, self._folder = task, folder
        self._progress, self._observer = progress, observer
        self._shell = Model(solver_named(DESIGN_SOLVER), task.settings)
        self._history: list[Tried] = []
        self._stages, self._budget = 0, task.limits.evaluations

    def run(self) -> DesignOutcome:
        """Search stage by stage, with each sharpness, then look at the design from flat."""
        point = self._task.variables.shares_of(self._task.specimen)
        first, *sharper = self._task.sharpened()
        self._task = first
        searched = self._search_in_stages(point)
        for number, task in enumerate(sharper, start=2):
            before = self._task
            self._task, self._budget = task, number * task.limits.evaluations
            try:
                searched = self._search_in_stages(searched.best.point)
            except NoValueError:  # none that is so sharp
                self._task = before
                break
        return self._with_lowest(self._checked(self._look(searched)))

    def _search_in_stages(self, point: Array) -> "_Searched":
        stage = Stage.begin(self._folder, self._stages + 1, self._task, point)
        searched = self._search(stage, self._left - 1)
        while self._left > 1 and searched.has_fallen:
            following = searched.stage.number + 1
            stage = Stage.begin(self._folder, following, self._task, searched.best.point)
            try:
                searched = self._search(stage, self._left - 1)
            except NoValueError:
                break
        return searched

    def _with_lowest(self, outcome: DesignOutcome) -> DesignOutcome:
        """Return a design with what is known of lower states than the one of its last check."""
        if not self._task.check.starts or outcome.check_failure:
            return outcome
        last = outcome.checks[-1]
        lowest = look_for_lowest(self._task, last, self._folder.path, self._progress)
        return replace(outcome, lowest=lowest)

    def _checked(self, outcome: DesignOutcome) -> DesignOutcome:
        """Return a design that the finite-element model has checked, as often as is wanted.

        All checks but the last correct the shell's shapes, and the search goes on.
        """
        runs, finer = self._task.check.runs, self._task.check.mesh_size
        checks: list[Checked] = []
        for run in range(1, runs + 1):
            if run == runs and self._task.check.evaluations:
                outcome = self._ended_by_elements(outcome, checks)
            file = self._folder.path / f"check-{run}.nc"
            specimen = cut_out(outcome.specimen)
            mesh = None if has_fields(outcome.specimen) else outcome.mesh
            if run == runs and finer is not None:
                specimen, mesh = replace(specimen, mesh=MeshSize(finer)), None
            checked = check_design(self._task, specimen, mesh, file, self._progress)
            if checked is None:
                failure = f"the finite-element model did not reach it ({file.name})"
                return replace(outcome, checks=tuple(checks), check_failure=failure)
            checks.append(checked)
            if run < runs - bool(self._task.check.evaluations):
                outcome = self._corrected(outcome, checked)
        return replace(outcome, checks=tuple(checks))

    def _corrected(self, outcome: DesignOutcome, checked: Checked) -> DesignOutcome:
        """Return what the search comes to from a design, its shapes corrected."""
        found = outcome.from_flat
        correction = correction_between(outcome.mesh, found.shapes[0].position, checked.position)
        number = self._stages + 1
        stage = Stage.begin(
            self._folder, number, self._task, found.point, mesh=outcome.mesh, correction=correction
        )
        try:
            return self._look(self._search(stage, CORRECTED_EVALUATIONS))
        except NoValueError as error:
            return replace(outcome, flat_failure=str(error))

    def _ended_by_elements(
        self, outcome: DesignOutcome, checks: Sequence[Checked]
    ) -> DesignOutcome:
        """Return what the search by the finite-element model comes to from a design.

        It begins near the shape of the last check, or else of the shell.
        """
        number, point = self._stages + 1, outcome.from_flat.point

        def start(mesh: PlanarMesh) -> xr.Dataset:
            if checks:
                return open_result(checks[-1].file)
            return solve(outcome.specimen, DESIGN_SOLVER, self._task.settings, mesh=mesh)

        mesh = checks[-1].mesh if checks else outcome.mesh
        stage = Stage.begin(self._folder, number, self._task, point, mesh=mesh)
        settings: Any = settings_class(CHECK_SOLVER)
        model = Model(
            solver_named(CHECK_SOLVER), settings(), start, settings(**NEARBY), self._progress
        )
        try:
            searched = self._search(stage, self._task.check.evaluations, model)
        except NoValueError as error:
            return replace(outcome, check_failure=str(error), history=tuple(self._history))
        return self._look(searched)

    @property
    def _left(self) -> int:
        return self._budget - len(self._history)

    def _search(self, stage: Stage, evaluations: int, model: Model | None = None) -> "_Searched":
        """Return what the search on one mesh comes to, by the shell if no model is given."""
        model = self._shell if model is None else model
        radius = self._task.limits.radius if stage.number == 1 else FIRST_RADIUS_AGAIN
        limits = replace(self._task.limits, evaluations=max(evaluations, 1), radius=radius)
        self._stages = stage.number
        bests = []
        for step in stage.search(self._folder, self._task, model, limits):
            bests.append(step.best)
            self._tell(stage.number, step, model.solver.name)
        return _Searched(stage, bests[0], bests[-1])

    def _look(self, searched: "_Searched") -> DesignOutcome:
        """Return a design with its shapes from flat, on a mesh of its own.

        If there are none, on that of the search.
        """
        last, best = searched.stage, searched.best
        stage = Stage.begin(self._folder, last.number + 1, self._task, best.point)
        specimen = stage.specimen(self._task, best.point)
        outcome = DesignOutcome(
            self._task, specimen, last.sheet.of(specimen), best, best, tuple(self._history)
        )
        try:
            found = self._search(stage, 1).best
        except NoValueError as error:
            return replace(outcome, flat_failure=str(error))
        history = tuple(self._history)
        return replace(outcome, mesh=stage.sheet.mesh, from_flat=found, history=history)

    def _tell(self, number: int, step: Iterate[Evaluation], solver: str) -> None:
        shapes = () if step.tried is None else step.tried.shapes
        tried = Tried(
            number,
            tuple(shape.distance for shape in shapes),
            step.best.shapes[0].distance,
            step.radius,
            step.failure,
            solver,
        )
        self._history.append(tried)
        if self._observer is not None:
            self._observer(tried)
        if self._progress is not None:
            whole = max(len(self._task.sharpness), 1) * self._task.limits.evaluations
            share = min(1.0, len(self._history) / (whole + 1))
            away = 1e3 * tried.best
            self._progress(share, f"stage {number}: {away:.4g} mm from the target")


@dataclass(frozen=True, eq=False)
class _Searched:
    """What the search on one mesh came to: its first and its best evaluation."""

    stage: Stage
    first: Evaluation
    best: Evaluation

    @property
    def has_fallen(self) -> bool:
        """Whether another stage is worth it."""
        return self.best.value < (1 - ENOUGH_FALL) * self.first.value
