"""The barrier between two states: the way over the pass between them."""

from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.landscape.catalogue import SAME_SHAPE
from bilayer.landscape.symmetry import Images, symmetry_of
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import MilestoneState, result_mesh, result_specimen
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Equilibrium, Pass
from bilayer.solvers.registry import solver_named
from bilayer.solvers.rerun import result_settings
from bilayer.validation import whole

IMAGES, ROUNDS = 13, 15
"""States along the way, and rounds of their relaxation, unless told."""
MOST_IMAGES, MOST_ROUNDS = 1000, 10_000
UP, BACK = "barrier", "barrier_back"
"""Attributes: energy from the first and from the second state up to the pass, J."""
LEADS_TO = "saddle_leads_to"
"""Attribute: the states downhill of the saddle to either side, -1 none of the file's."""
MODES = "saddle_modes"
"""Attribute: unstable modes of the saddle; -1 if none was found."""


def barrier(
    states: xr.Dataset,
    first: int,
    second: int,
    *,
    images: int = IMAGES,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Find the barrier between two states of a search, by the shell that found them.

    A string of shapes between them goes downhill across itself. Newton's method leads from its
    highest shape to a saddle, which is checked: it has one unstable mode, and the states lie
    downhill of it to both sides. Of the second state that image is taken which lies nearest.

    Parameters
    ----------
    states : Dataset
        From `bilayer.states`, or another result of the shell with both shapes at one prestretch.
    first, second : int
        Which states, from 0 on.
    images : int
        Shapes along the way, without its ends.
    rounds : int
        Of their relaxation.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        A result with a milestone for each shape along the way, in their order, all at the same
        prestretch; only its ends are equilibria, and the saddle, which stands in place of the
        highest shape. `way_length` is the distance along the way in m. Attributes `barrier` and
        `barrier_back` (J), `saddle_modes` and `saddle_leads_to`.

    Raises
    ------
    InputError
        There is no such state, the two are at different prestretches, or another solver made them.
    ComputationError
        A state is no equilibrium of the shell.

    Examples
    --------
    The states of the file are those of `bilayer.states`. A state has no barrier to itself:

    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.016))  # coarse: for the example
    >>> states = bilayer.states(specimen, starts=1)
    >>> bilayer.barrier(states, 0, 0)
    Traceback (most recent call last):
    bilayer.errors.InputError: states 0 and 0: expected two, at the same prestretch
    """
    states = along_milestones(states)
    pair = [_row(states, name, row) for name, row in (("first", first), ("second", second))]
    specimen, mesh = result_specimen(states), result_mesh(states)
    milestones = {specimen.milestones[row] for row in pair}
    if len(milestones) != 1 or pair[0] == pair[1]:
        raise InputError(f"states {first} and {second}: expected two, at the same prestretch")
    stretch = specimen.prestretch.milestones[pair[0]]
    solver, settings = solver_named(states.attrs["solver"]), result_settings(states)
    if solver.open_finder is None:
        raise InputError(f"states: {solver.name} made them, expected states of dshell")
    finder = solver.open_finder(specimen, settings, stretch, mesh=mesh)
    shapes = states["position"].values
    symmetry = Images(mesh, symmetry_of(specimen, stretch))
    count = whole("rounds", rounds, 1, MOST_ROUNDS)

    def tell(number: int) -> None:
        if progress is not None:
            progress((number + 1) / count, f"round {number + 1}")

    found = finder.find_pass(
        shapes[pair[0]],
        symmetry.nearest(shapes[pair[0]], shapes[pair[1]]),
        whole("images", images, 3, MOST_IMAGES),
        count,
        tell,
    )
    rows = _rows(found, max(stretch))
    provenance = Provenance.found(solver.name, states.attrs["model"], settings, finder.versions)
    result = build_result(specimen.with_milestones([stretch] * len(rows)), mesh, rows, provenance)
    result.attrs |= _summary(found, states, symmetry, specimen.characteristic_length)
    result.attrs["start"] = f"states {pair[0]} and {pair[1]} of a search"
    length = {"units": "m", "long_name": "distance along the way, rms of the nodes"}
    return result.assign(way_length=("prestretch", found.lengths, length))


def _row(states: xr.Dataset, name: str, row: int) -> int:
    count = states.sizes["prestretch"]
    if not 0 <= row < count:
        raise InputError(f"{name} = {row}: expected a state from 0 to {count - 1}")
    return row


def _rows(found: Pass, reached: float) -> list[MilestoneState]:
    """Return the shapes along the way, the saddle in place of the highest."""
    top = 1 + int(np.argmax(found.energies[1:-1]))
    rows = [
        MilestoneState(found.positions[place, :, :], True, reached, {"total": float(energy)})
        for place, energy in enumerate(found.energies)
    ]
    saddle: Equilibrium | None = found.saddle
    if saddle is not None:
        energy = {"total": _total(saddle)}
        rows[top] = MilestoneState(
            saddle.position, True, reached, energy, unstable_modes=saddle.unstable_modes
        )
    return rows


def _total(equilibrium: Equilibrium) -> float:
    return sum(equilibrium.energy.values())


def _summary(found: Pass, states: xr.Dataset, images: Images, length: float) -> dict[str, Any]:
    top = found.energies[1:-1].max() if found.saddle is None else _total(found.saddle)
    known = states["position"].values
    leads_to = [
        next(
            (
                row
                for row, shape in enumerate(known)
                if images.distance(side.position, shape) < SAME_SHAPE * length
            ),
            -1,
        )
        for side in found.sides
    ]
    return {
        UP: float(top - found.energies[0]),
        BACK: float(top - found.energies[-1]),
        MODES: -1 if found.saddle is None else int(found.saddle.unstable_modes),
        LEADS_TO: np.array(leads_to or [-1], dtype=np.int32),
    }


def describe_barrier(way: xr.Dataset, first: int, second: int) -> str:
    """Return the barrier between two states in a few sentences."""
    energy = way["energy"].sum("term").values
    up, back, modes = way.attrs[UP], way.attrs[BACK], way.attrs[MODES]
    lines = [
        f"from state {first} {1e6 * up:.4g} uJ up ({up / energy[0]:.3%} of its energy), "
        f"from state {second} {1e6 * back:.4g} uJ ({back / energy[-1]:.3%})"
    ]
    if modes < 0:
        lines.append(
            "NO SADDLE was found near the highest shape of the way: the barrier is an estimate"
        )
    else:
        sides = " and ".join(
            "a state that is not in the file" if row < 0 else f"state {row}"
            for row in np.atleast_1d(way.attrs[LEADS_TO])
        )
        lines.append(
            f"over a saddle with {modes} unstable mode{'s' * (modes != 1)}, down to {sides}"
        )
    return "\n".join(lines)
