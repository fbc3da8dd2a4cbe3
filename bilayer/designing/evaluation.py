"""The value of a design: how far its shapes are from the target, with derivatives.

    value = M(D_s^2) / L^2 + w mean(P_s)

over all scenarios s, with the distance D from the target, its bounding diagonal L, M the mean or
the worst (`Robustness`), and the penalty P on places that nearly touch (`GapPenalty`). A field of
density has another, on what is between none and all (`grey_penalty`).
"""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.designing.distance import Distance, Place, TargetDistance
from bilayer.designing.equilibria import DesignShape, Model, SheetMesh, find_shape
from bilayer.designing.fields import grey_penalty
from bilayer.designing.gap import GapPenalty
from bilayer.designing.softness import least_stiffness
from bilayer.designing.task import DesignTask
from bilayer.errors import ComputationError
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

GAP_WEIGHT = 0.05
"""w: a penalty of 0.01, a hundredth of the sheet within range, is as bad as 2 % of the diagonal."""
SAVED = "saved."


@dataclass(frozen=True, eq=False)
class ShapeFound:
    """The shape of a design in one scenario.

    Parameters
    ----------
    distance : float
        From the target, root mean square both ways, m.
    mean_distance, largest_distance : float
        m.
    gap : float
        From itself, m; infinite if no two places come near.
    unstable_modes, iterations : int
        Of the equilibrium.
    position : (n, 3) array of float
        m.
    place : Place
        Of the target.
    saved : mapping
        The equilibrium.
    state_changes : (k, dofs) array of float
        Derivatives of its state by the scaled variables.
    stiffness : float
        Its least, see `bilayer.designing.softness`, N/m3; NaN if nobody has asked.
    """

    distance: float
    mean_distance: float
    largest_distance: float
    gap: float
    unstable_modes: int
    iterations: int
    position: Array
    place: Place
    saved: Mapping[str, NDArray[Any]]
    state_changes: Array
    stiffness: float = np.nan

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all of it as arrays, for a file."""
        numbers = [self.distance, self.mean_distance, self.largest_distance, self.gap,
                   self.unstable_modes, self.iterations, self.place.size]  # fmt: skip
        return {
            "numbers": np.array([*numbers, self.stiffness]),
            "position": self.position,
            "rotation": self.place.rotation,
            "shift": self.place.shift,
            "state_changes": self.state_changes,
            **{f"{SAVED}{name}": value for name, value in self.saved.items()},
        }

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[Any]]) -> "ShapeFound":
        """Return what `arrays` holds."""
        numbers = [float(number) for number in arrays["numbers"]]
        saved = {
            name.removeprefix(SAVED): value
            for name, value in arrays.items()
            if name.startswith(SAVED)
        }
        return cls(
            numbers[0],
            numbers[1],
            numbers[2],
            numbers[3],
            int(numbers[4]),
            int(numbers[5]),
            arrays["position"],
            Place(arrays["rotation"], arrays["shift"], numbers[6]),
            saved,
            arrays["state_changes"],
            *numbers[7:],
        )


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The value of a design; see `bilayer.designing.trust_region.Evaluated`.

    Parameters
    ----------
    point : (k,) array of float
        The scaled variables.
    value : float
        See the module.
    gradient : (k,) array of float
        Its derivatives.
    curvature : (k, k) array of float
        Gauss and Newton's second derivatives, without those of the penalty.
    shapes : tuple of ShapeFound
        By scenario.
    margins : (s,) array of float
        By how much the least stiffness of each is more than what is wanted, over that; (0,) if none
        is wanted.
    """

    point: Array
    value: float
    gradient: Array
    curvature: Array
    shapes: tuple[ShapeFound, ...]
    margins: Array

    @property
    def is_admissible(self) -> bool:
        """Whether all shapes are stable and none touches itself."""
        return all(shape.unstable_modes == 0 and shape.gap > 0 for shape in self.shapes)


class Evaluator:
    """Evaluates the designs on one moving mesh.

    Parameters
    ----------
    task : DesignTask
        What is wanted.
    model : Model
        Finds the shapes.
    sheet : SheetMesh
        The moving mesh.
    correction : (n, 3) array of float or None
        By how much the shapes of this solver fall short of the true ones, m; see
        `bilayer.designing.correction`.
    """

    def __init__(
        self,
        task: DesignTask,
        model: Model,
        sheet: SheetMesh,
        correction: Array | None = None,
    ) -> None:
        self._task, self._model, self._sheet = task, model, sheet
        self._correction = correction
        self._distance = TargetDistance(task.target.surface, task.target.is_size_free)
        self._gap = GapPenalty(sheet, task.least_gap) if task.least_gap > 0 else None

    def specimen(self, point: Array) -> Specimen:
        """Return the nominal specimen of some scaled variables."""
        return self._task.variables.specimen(self._sheet.specimen, point)

    def evaluate(self, point: Array, best: Evaluation | None) -> Evaluation:
        """Return the value of a design, whose shapes are searched near those of another one.

        Raises
        ------
        BilayerError
            There is no shape near, it passes through itself, or the mesh cannot follow.
        """
        nominal = self.specimen(point)
        parts: list[_Part] = []
        for number, scenario in enumerate(self._task.robustness.scenarios):
            near = parts[0].found if best is None and parts else None
            near = best.shapes[number] if best is not None else near
            slopes = self._task.variables.ranges * scenario.slopes(self._task.variables.names)
            step = None if best is None else point - best.point
            parts.append(self._part(scenario.specimen(nominal), near, step, slopes))
        mesh = self._sheet.of(nominal)
        grey, by_grey = grey_penalty(nominal, mesh, self._task.variables.names)
        return self._total(point, parts, grey, by_grey * self._task.variables.ranges)

    def _total(self, point: Array, parts: list["_Part"], grey: float, by_grey: Array) -> Evaluation:
        squares = np.array([part.square for part in parts])
        total, weights = self._task.robustness.total(squares)
        gradient = sum(w * part.slope for w, part in zip(weights, parts, strict=True))
        curvature = sum(w * part.curvature for w, part in zip(weights, parts, strict=True))
        penalty = GAP_WEIGHT * np.mean([part.penalty for part in parts])
        by_penalty = GAP_WEIGHT * np.mean([part.penalty_slope for part in parts], axis=0)
        return Evaluation(
            point,
            float(total + penalty + grey),
            np.asarray(gradient + by_penalty + by_grey),
            np.asarray(curvature),
            tuple(part.found for part in parts),
            self._margins([part.found.stiffness for part in parts]),
        )

    def _margins(self, stiffnesses: list[float]) -> Array:
        least = self._task.least_stiffness
        return np.array(stiffnesses) / least - 1 if least > 0 else np.empty(0)

    def _stiffness(self, shape: DesignShape) -> float:
        if self._task.least_stiffness == 0:
            return np.nan
        areas = flat_surface(shape.mesh).node_areas
        return least_stiffness(shape.equilibrium, shape.linearised, areas)

    def _part(
        self, specimen: Specimen, near: ShapeFound | None, step: Array | None, slopes: Array
    ) -> "_Part":
        """Return what one scenario adds.

        step: of the variables from the design of the shape nearby, None if that is of this one.
        slopes: derivatives of its numbers by the variables.
        """
        saved = None if near is None else near.saved
        change = None if near is None or step is None else step @ near.state_changes
        with closing(find_shape(self._model, specimen, self._sheet, saved, change)) as shape:
            return self._part_of(shape, near, slopes)

    def _part_of(self, shape: DesignShape, near: ShapeFound | None, slopes: Array) -> "_Part":
        surface = self._corrected(shape)
        if near is None:
            distance = self._distance.measure_anew(surface)
        else:
            distance = self._distance.measure(surface, near.place)
        names, scale = self._task.variables.names, self._task.target.diagonal**2
        slope = shape.gradient(distance.gradient, names) * slopes / scale
        changes = shape.changes(names) * slopes[:, None, None]
        curvature = self._distance.curvature(surface, distance.place, changes) / scale
        penalty, penalty_slope = self._penalty(shape, slopes)
        return _Part(
            distance.mean_square / scale,
            np.asarray(slope),
            np.asarray(curvature),
            penalty,
            penalty_slope,
            _found(
                shape, distance, shape.state_changes(names) * slopes[:, None],
                self._stiffness(shape),
            ),
        )  # fmt: skip

    def _penalty(self, shape: DesignShape, slopes: Array) -> tuple[float, Array]:
        names = self._task.variables.names
        if self._gap is None:
            return 0.0, np.zeros(len(names))
        value, by_position, by_numbers = self._gap.of(shape, names)
        if value == 0:
            return 0.0, np.zeros(len(names))
        return value, (shape.gradient(by_position, names) + by_numbers) * slopes

    def _corrected(self, shape: DesignShape) -> Surface:
        if self._correction is None:
            return shape.surface
        return Surface(shape.surface.points + self._correction, shape.surface.triangles)


@dataclass(frozen=True, eq=False)
class _Part:
    square: float
    slope: Array
    curvature: Array
    penalty: float
    penalty_slope: Array
    found: ShapeFound


def _found(
    shape: DesignShape, distance: Distance, state_changes: Array, stiffness: float
) -> ShapeFound:
    here = shape.equilibrium
    if not np.isfinite(distance.mean_square):
        raise ComputationError("the shape has no finite distance from the target")
    return ShapeFound(
        distance.rms,
        distance.mean,
        distance.largest,
        shape.gap,
        here.unstable_modes,
        here.effort.iterations,
        here.position,
        distance.place,
        here.save(),
        state_changes,
        stiffness,
    )
