"""The contract of a solver: a package that follows the equilibria of a specimen along a load path.

A solver package offers one object, `SOLVER`, of the class `Solver`. Its `open_path` makes a
`SpecimenPath`; the driver (`bilayer.solvers.path`) takes that through the milestones, and whoever
measures, writes or draws is an observer of the driver. The driver needs less than that of a path,
so a `Path` may as well be that of a plate under a pressure, without a specimen.

On several ranks every rank makes the same path and calls the same members in the same order: all
members are collective, and what they return is the same on all ranks.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self, TypeVar, runtime_checkable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.measures.milestone import Measures
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.planar import PlanarMesh
from bilayer.runtime.progress import Progress
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]
Saved = Mapping[str, NDArray[Any]]
"""All that a path needs to go on, as arrays (numbers or text) by name; part of a file."""
Start = xr.Dataset | Callable[[PlanarMesh], xr.Dataset] | None
"""A result on the mesh of the run, a function that makes one, or None: the flat state.

A solver that `takes_neighbours` knows the function `bilayer.results.starting.Neighbour`."""


class TargetMissedError(ComputationError):
    """A target cannot be reached, but the path may be asked for the next one."""


class Effort(Protocol):
    """The work between two points of a path; it adds up."""

    @property
    def iterations(self) -> int:
        """Newton iterations, each with one factorisation, failed attempts included."""

    @property
    def load_steps(self) -> int:
        """Load or time steps."""

    def __add__(self, other: Self, /) -> Self:
        """Return the work of both."""


class PathPoint(Protocol):
    """A state of a body on a path, good until the path is asked for the next one."""

    @property
    def share(self) -> float:
        """Part of the way from the last target to the next, from 0 to 1; 1 at the target alone."""

    @property
    def effort(self) -> Effort:
        """The work since the point before."""


Target = TypeVar("Target", contravariant=True)
Point = TypeVar("Point", bound=PathPoint, covariant=True)


class Path(Protocol[Target, Point]):
    """A body that goes from target to target, in any order, from where it is."""

    def approach(self, target: Target) -> Iterator[Point]:
        """Go to a target.

        Yields
        ------
        PathPoint
            Each one on the way; the last is at the target.

        Raises
        ------
        TargetMissedError
            The target cannot be reached, another one may.
        ComputationError
            The path ends before the target.
        """

    def stopped(self) -> Point:
        """Return the state where `approach` failed: the last one, with the work done in vain."""


class Linearised(Protocol):
    """The equations of a body near an equilibrium: residual(state, parameters) = 0.

    A parameter is one of `bilayer.solvers.parameters`. The equilibrium follows it by

        d state / d parameter = -solve(residual_by(parameter)),

    and a function J of the position by, with a = solve(state_gradient(dJ/dposition)),

        dJ / d parameter = sum(dJ/dposition * position_by(parameter)) - a . residual_by(parameter).

    The tangent is symmetric. It is good until the path goes on.
    """

    def solve(self, right_side: Array) -> Array:
        """Return the solution of tangent x = right side, with the factorised tangent.

        Parameters
        ----------
        right_side : (dofs,) array of float
            Entries of held degrees of freedom do not count; those of the solution are 0.
        """

    def residual_by(self, parameter: str) -> Array:
        """Return the derivative of the residual by a parameter, the state fixed, (dofs,)."""

    def position_by(self, parameter: str) -> Array:
        """Return the derivative of the position by a parameter, the state fixed, (n, 3)."""

    def state_gradient(self, position_gradient: Array) -> Array:
        """Return the gradient by the state of a function whose gradient by the position is given.

        Parameters
        ----------
        position_gradient : (n, 3) array of float
            Derivative of a number by `Equilibrium.position`.

        Returns
        -------
        (dofs,) array of float
            A right side for `solve`.
        """

    def position_change(self, state_change: Array) -> Array:
        """Return the change of the position, (n, 3), m, with the state, (dofs,)."""


@runtime_checkable
class ShapeLinearised(Linearised, Protocol):
    """Equations that are differentiated by the flat sheet, too: where its mesh has its nodes."""

    def residual_along(self, velocity: Array) -> Array:
        """Return the derivative of the residual as the nodes move, the state fixed, (dofs,).

        Parameters
        ----------
        velocity : (n, 2) array of float
            Of the nodes in the flat sheet.
        """

    def position_along(self, velocity: Array) -> Array:
        """Return the derivative of the position as the nodes move, the state fixed, (n, 3)."""


@runtime_checkable
class PointsLinearised(ShapeLinearised, Protocol):
    """Equations that are differentiated by all nodes of the flat mesh at once."""

    def points_gradient(self, adjoint: Array, position_gradient: Array) -> Array:
        """Return the gradient of a function of the shape by the nodes of the planar mesh, (n, 2).

        For a function J of the position that no rigid motion changes, this is

            sum(dJ/dposition * dposition/dpoints) - adjoint . dresidual/dpoints

        at the fixed state, 1/m times the unit of J.

        Parameters
        ----------
        adjoint : (dofs,) array of float
            solve(state_gradient(dJ/dposition)).
        position_gradient : (n, 3) array of float
            dJ/dposition.

        Raises
        ------
        InputError
            The model, its weight or its contact is none that can be differentiated so.
        """


class Equilibrium(PathPoint, Protocol):
    """A specimen in equilibrium on its load path, good until the path goes on."""

    @property
    def stretch(self) -> StretchPair:
        """(lambda_x, lambda_y) of its prestretch."""

    @property
    def milestone(self) -> Milestone:
        """Its prestretch, then the value of each load."""

    @property
    def responses(self) -> Mapping[str, float]:
        """What each load does its work on, by its name; see `bilayer.specimen.load.RESPONSES`."""

    @property
    def position(self) -> Array:
        """The reference surface on the nodes of the planar mesh, m, shape (n, 3)."""

    @property
    def energy(self) -> Mapping[str, float]:
        """Energy terms that a result lists, J."""

    @property
    def residual(self) -> float:
        """Norm of the residual, relative to the solver's own reference."""

    @property
    def unstable_modes(self) -> int:
        """Number of unstable modes; -1 if the method cannot tell, or nobody has counted."""

    def measures(self) -> Measures:
        """Return the measures of the shape."""

    def details(self) -> Any:
        """Return the data of this milestone for `SpecimenPath.variables`; they must outlive it."""

    def save(self) -> Saved:
        """Return all that the path needs to go on from here, for `SpecimenPath.restore`."""

    def layer_states(self) -> Sequence[LayerState]:
        """Return the deformation of each layer, for its fields; none if the model has no layers."""

    def linearised(self) -> Linearised:
        """Return the equations linearised here."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The solver's own part of a milestone that was tried.

    Parameters
    ----------
    effort : Effort
        The work since the milestone before.
    details : any
        From `Equilibrium.details`; None if the milestone was not reached.
    """

    effort: Any
    details: Any


class SpecimenPath(Path[Milestone, Equilibrium], Protocol):
    """The load path of a specimen."""

    @property
    def mesh(self) -> PlanarMesh:
        """The planar mesh."""

    @property
    def comm(self) -> Any:
        """The communicator of the ranks that share the path, or None."""

    @property
    def start(self) -> str:
        """The start of the path, in one line, as far as it is known by now."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the packages that compute."""

    def restore(self, saved: Saved) -> None:
        """Be where an equilibrium of the same specimen, mesh and settings was saved.

        The path was opened with `start=None`. What follows is the same, to the last bit on the same
        machine, as if the path had never been left.
        """

    def restore_neighbour(
        self, saved: Saved, target: Milestone | None = None, change: Array | None = None
    ) -> None:
        """Be where an equilibrium of a specimen nearby was saved, which is none of this one.

        The neighbour has a mesh of the same triangles, its nodes moved a little, and the settings
        of this path, which was opened with `start=None`. What the neighbour had learnt on its way
        is forgotten.

        Parameters
        ----------
        saved : mapping
            From `Equilibrium.save` of the neighbour.
        target : tuple of float, optional
            Where the path shall be instead: at a milestone of its own.
        change : (dofs,) array of float, optional
            By how much the state there is expected to differ from the neighbour's.
        """

    def variables(self, milestones: Sequence[Recorded | None]) -> xr.Dataset:
        """Return the variables that this solver adds to a result; called on the first rank.

        Parameters
        ----------
        milestones : sequence of Recorded or None
            Of the milestones so far, in their order; None if an earlier run has tried it: that
            row is taken from its file. The dataset has a row for every milestone of the specimen.
        """

    def close(self) -> None:
        """Free what the path holds."""


class OpenPath(Protocol):
    """A function with which a solver makes a path."""

    def __call__(
        self,
        specimen: Specimen,
        settings: Any,
        *,
        mesh: PlanarMesh | None,
        start: Start,
        comm: Any,
        progress: Progress | None,
    ) -> SpecimenPath:
        """Return the path of a specimen, in its flat state or where it is to start.

        Parameters
        ----------
        specimen : Specimen
            What to release, with the milestones that are going to be the targets.
        settings : settings dataclass
            One of the solver's models.
        mesh : PlanarMesh or None
            The planar mesh; made from the specimen if None.
        start : Dataset, callable or None
            See `Start`.
        comm : mpi4py.MPI.Comm or None
            The ranks that share the path; if the solver is parallel, None is all of them.
        progress : callable or None
            Told of what comes before the path, such as another path on a coarse mesh.

        Raises
        ------
        InputError
            The settings are of no model of the solver, the specimen or the start does not suit it,
            or the mesh would not fit into memory.
        ComputationError
            What the solver needs is not installed, or gmsh fails.
        """


@dataclass(frozen=True, eq=False)
class Pass:
    """The way from one shape to another over the pass between them.

    Parameters
    ----------
    positions : (k, n, 3) array of float
        Shapes along the way, both ends included, m.
    energies : (k,) array of float
        Of each, J.
    lengths : (k,) array of float
        Distance from the first along the way, rms of the nodes' displacements, m.
    saddle : Equilibrium or None
        The equilibrium near the highest of them; None if Newton's method found none.
    sides : sequence of Equilibrium
        What lies downhill of it to either side, stable.
    """

    positions: Array
    energies: Array
    lengths: Array
    saddle: Any
    sides: Sequence[Any]


class StateFinder(Protocol):
    """A specimen at one prestretch, whose stable shapes are looked for.

    A shape is the reference surface on the nodes of the planar mesh, (n, 3), m, in any position and
    orientation. What is found stays good.
    """

    @property
    def mesh(self) -> PlanarMesh:
        """The planar mesh."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the packages that compute."""

    def settle(self, shape: Array) -> Sequence[Equilibrium]:
        """Return the stable equilibria downhill of a shape, at best one.

        There are several if the way down ends at an unstable equilibrium: those to both sides of
        its unstable modes. There is none if the method does not converge.
        """

    def settle_elsewhere(self, shape: Array, known: Sequence[Array]) -> Sequence[Equilibrium]:
        """Return stable equilibria beside one that is near a shape but is none of those known.

        Parameters
        ----------
        shape : (n, 3) array of float
            Where to begin.
        known : sequence of (n, 3) array of float
            The shapes that are avoided.
        """

    def stiffnesses(self, equilibrium: Any, count: int) -> Array:
        """Return the least eigenvalues of the stiffness over the flat area, N/m3, ascending.

        The pressure per displacement in the shape of each mode. Rigid motions are left out.
        """

    def find_pass(
        self,
        first: Array,
        second: Array,
        images: int,
        rounds: int,
        tell: Callable[[int], None] | None = None,
    ) -> Pass:
        """Return the way over the lowest pass between two stable shapes.

        Parameters
        ----------
        first, second : (n, 3) array of float
            The shapes, one laid onto the other.
        images : int
            States along the way, without its ends.
        rounds : int
            Of their relaxation.
        tell : callable, optional
            Told of each round.

        Raises
        ------
        ComputationError
            One of the shapes is near no equilibrium.
        """


class OpenFinder(Protocol):
    """A function with which a solver makes a finder of stable shapes."""

    def __call__(
        self,
        specimen: Specimen,
        settings: Any,
        stretch: StretchPair,
        *,
        mesh: PlanarMesh | None,
    ) -> StateFinder:
        """Return the finder of a specimen at a prestretch.

        Raises
        ------
        InputError
            The settings are of a model that has no search, or the mesh would not fit into memory.
        """


@dataclass(frozen=True)
class Solver:
    """A solver, as its package offers it.

    Parameters
    ----------
    name : str
        As in the registry and in results.
    models : mapping of str to type
        Its models by name, each the dataclass of that model's settings; the first is the default.
        A class attribute `stopping_is_a_result` says that a run that stops early succeeds.
    parallel : bool
        Whether the ranks of mpirun share one path.
    bytes_per_triangle : callable
        Returns the memory that a run of a specimen takes, with the settings of a model, for each
        triangle of the planar mesh.
    default_start : str
        One of `bilayer.solvers.registry.STARTS`.
    open_path : OpenPath
        Makes a path.
    has_layers : callable
        Returns whether a model, told by its settings, has `Equilibrium.layer_states`.
    takes_neighbours : callable
        Returns whether a run with some settings comes to the same states if a `Neighbour` starts
        it, with rare exceptions.
    open_finder : OpenFinder or None
        Makes a finder of stable shapes; None: the solver has no search of its own.
    """

    name: str
    models: Mapping[str, type]
    parallel: bool
    bytes_per_triangle: Callable[[Specimen, Any], float]
    default_start: str
    open_path: OpenPath
    has_layers: Callable[[Any], bool] = lambda settings: True
    takes_neighbours: Callable[[Any], bool] = lambda settings: False
    open_finder: OpenFinder | None = None
