"""A stage of the search: on one planar mesh that moves with the design, until it cannot follow.

Each stage begins with a mesh of its own, and with the shapes that are found from flat. So the
first value of a stage is also a check of the one before: a shape that is only reached along the way
of the search is another one.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.designing.equilibria import Model, SheetMesh
from bilayer.designing.evaluation import Evaluation, Evaluator, ShapeFound
from bilayer.designing.folder import Arrays, DesignFolder
from bilayer.designing.task import DesignTask
from bilayer.designing.trust_region import Iterate, Limits, NoValueError, search
from bilayer.errors import (
    ComputationError,
    InputError,
    MachineError,
    NotEnoughMemoryError,
    NotResumableError,
)
from bilayer.geometry.alignment import align
from bilayer.mesh.generation import generate_mesh
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

LEAST_AREA = 0.4
"""Of a triangle as the mesh moves, over what it was; below a new mesh is made."""
SHAPE = "shape-"


def correction_between(mesh: PlanarMesh, shell: Array, true: Array) -> Array:
    """Return how far the true shape is from that of the shell, both on one mesh, (n, 3), m.

    Parameters
    ----------
    mesh : PlanarMesh
        The planar mesh.
    shell, true : (n, 3) array of float
        The reference surfaces, m.
    """
    return align(true, shell, flat_surface(mesh).node_areas) - shell


@dataclass(frozen=True, eq=False)
class Stage:
    """A stage.

    Parameters
    ----------
    number : int
        From 1.
    sheet : SheetMesh
        The moving mesh.
    point : (k,) array of float
        The scaled variables that it begins with.
    correction : (n, 3) array of float or None
        See `Evaluator`.
    """

    number: int
    sheet: SheetMesh
    point: Array
    correction: Array | None = None

    @classmethod
    def begin(
        cls,
        folder: DesignFolder,
        number: int,
        task: DesignTask,
        point: Array,
        *,
        mesh: PlanarMesh | None = None,
        correction: Array | None = None,
    ) -> "Stage":
        """Return the stage that is there, or a new one with a mesh of its own.

        Parameters
        ----------
        folder, number, task
            Where it is kept, which one, and of what.
        point : (k,) array of float
            Where it begins.
        mesh : PlanarMesh, optional
            Of a new one; made from the specimen if left out.
        correction : (n, 3) array of float, optional
            Of a new one, see `correction_between`.
        """
        specimen = task.variables.specimen(task.specimen, point)
        file = folder.stage(number) / "mesh.npz"
        held = folder.read(file)
        if held is None:
            mesh = generate_mesh(specimen) if mesh is None else mesh
            held = {
                "points": mesh.points, "triangles": mesh.triangles, "region": mesh.region,
                "point": point,
            }  # fmt: skip
            if correction is not None:
                held["correction"] = correction
            folder.write(file, held)
        _check_point(held, point, file)
        mesh = PlanarMesh(held["points"], held["triangles"], held["region"], specimen.layer_sets)
        return cls(number, SheetMesh(specimen, mesh), point, held.get("correction"))

    def search(
        self, folder: DesignFolder, task: DesignTask, model: Model, limits: Limits
    ) -> Iterator[Iterate[Evaluation]]:
        """Yield the steps of the search on this mesh, up to where the mesh cannot follow.

        Evaluations that are in the folder are not computed again.
        """
        evaluator = Evaluator(task, model, self.sheet, self.correction)
        kept = _Kept(evaluator, folder, folder.stage(self.number))

        def margins(point: Array) -> Array:
            return task.widths.margins(evaluator.specimen(point))

        constraints = margins if len(margins(self.point)) else None
        for step in search(kept.evaluate, self.point, limits, constraints):
            yield step
            if self.distortion(task, step.point) < LEAST_AREA:
                return

    def distortion(self, task: DesignTask, point: Array) -> float:
        """Return the least ratio of a triangle's area to what it was when the stage began."""
        return self.sheet.least_area_ratio(self.specimen(task, point))

    def specimen(self, task: DesignTask, point: Array) -> Specimen:
        """Return the nominal specimen of some scaled variables."""
        return task.variables.specimen(task.specimen, point)


class _Kept:
    """Evaluations that are kept in a folder, in their order."""

    def __init__(self, evaluator: Evaluator, folder: DesignFolder, place: Path) -> None:
        self._evaluator, self._folder, self._place = evaluator, folder, place
        self._count = 0

    def evaluate(self, point: Array, best: Evaluation | None) -> Evaluation:
        """Return the next evaluation, from its file if it is there."""
        self._count += 1
        file = self._place / f"{self._count:04d}.npz"
        held = self._folder.read(file)
        if held is None:
            held = self._computed(point, best)
            self._folder.write(file, held)
        _check_point(held, point, file)
        if "failure" in held:
            raise NoValueError(str(held["failure"]))
        return _from_arrays(held)

    def _computed(self, point: Array, best: Evaluation | None) -> Arrays:
        try:
            return _to_arrays(self._evaluator.evaluate(point, best))
        except (MachineError, NotEnoughMemoryError):
            raise
        except (ComputationError, InputError) as error:
            return {"point": point, "failure": np.array(str(error))}


def _check_point(held: Arrays, point: Array, file: Path) -> None:
    """Raise unless a file is of the point that is asked for: another machine may round otherwise.

    The search goes on from what is there; a point that differs by round-off is the same.
    """
    if held["point"].shape != point.shape or np.abs(held["point"] - point).max() > 1e-6:
        raise NotResumableError(
            f"{file}: is of another design than the one that the search comes to, expected the "
            "folder as this machine left it"
        )


def _to_arrays(found: Evaluation) -> Arrays:
    arrays: dict[str, NDArray[Any]] = {
        "point": found.point,
        "value": np.array(found.value),
        "gradient": found.gradient,
        "curvature": found.curvature,
        "margins": found.margins,
    }
    for number, shape in enumerate(found.shapes):
        for name, value in shape.arrays().items():
            arrays[f"{SHAPE}{number}.{name}"] = np.asarray(value)
    return arrays


def _from_arrays(held: Arrays) -> Evaluation:
    shapes: dict[int, dict[str, NDArray[Any]]] = {}
    for name, value in held.items():
        if name.startswith(SHAPE):
            number, _, own = name.removeprefix(SHAPE).partition(".")
            shapes.setdefault(int(number), {})[own] = value
    return Evaluation(
        held["point"],
        float(held["value"]),
        held["gradient"],
        held["curvature"],
        tuple(ShapeFound.of(shapes[number]) for number in sorted(shapes)),
        held.get("margins", np.empty(0)),
    )
