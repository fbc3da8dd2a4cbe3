"""What both solvers came to on a sheet, as rows of a file."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

import bilayer
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import PlanarMesh, flat_surface
from sheet_comparison.branches import Pair, SolverName, as_found, energy, in_one_state
from sheet_comparison.cases import FARTHEST, THIN, TOLERANCE, Case, softened

SOFTER = 0.01
"""Share by which the kirigami's moduli fall for the sensitivity."""

AT_ONCE = bilayer.SolidSettings(
    first_step=0.05, smallest_step=0.05, largest_step=0.05, flow_steps=0
)
"""Of the finite-element model from the shell's shape: it stays there, or gives up.

Small load steps from the flat state and the gradient flow would lead it to its own state again.
"""


@dataclass(frozen=True)
class SheetRow:
    """One milestone of one sheet on one mesh.

    The thickness is over the characteristic length; `mesh_size` is in m.
    """

    sheet: str
    pile: str
    thickness: float
    is_published: int
    prestretch: float
    mesh_size: float

    @property
    def case(self) -> tuple[str, str, float, int]:
        """Return what rows of one sheet on several meshes share."""
        return self.sheet, self.pile, round(self.thickness, 9), self.is_published

    @property
    def milestone(self) -> tuple[tuple[str, str, float, int], float, float]:
        """Return what tells it from the rows of all other milestones and meshes."""
        return self.case, self.prestretch, round(self.mesh_size, 9)


@dataclass(frozen=True)
class Row(SheetRow):
    """What both solvers came to.

    Lengths are over the characteristic length; what was not reached is NaN.
    `state` and the excesses are those of `sheet_comparison.branches.Pair`. `sensitivity` is the rms
    distance of the shell's shape from that with a kirigami softer by `SOFTER`, NaN if it was not
    asked for.
    """

    triangles: int
    state: str
    distance: float
    sensitivity: float
    height_fenics: float
    height_shell: float
    energy_ratio: float
    excess_fenics: float
    excess_shell: float
    unstable_fenics: int
    unstable_shell: int
    gap: float

    @property
    def is_known(self) -> bool:
        """Return whether both solvers came to a shape."""
        return bool(np.isfinite(self.distance))

    @property
    def is_judged(self) -> bool:
        """Return whether the solvers must agree on it."""
        return self.thickness <= THIN + 1e-9 and self.prestretch < FARTHEST

    @property
    def is_missed(self) -> bool:
        """Return whether they must and do not."""
        return self.is_judged and not self.distance <= TOLERANCE


def rows_of(case: Case, kept: Path) -> Iterator[Row]:
    """Solve a sheet by both solvers on one mesh, the shell's shapes leading the FE model's.

    Parameters
    ----------
    case : Case
        The sheet.
    kept : Path
        Folder of the results; those that are there are not computed again.
    """
    mesh = bilayer.generate_mesh(case.specimen)
    runs = Runs(case, mesh, kept)
    for stretch in case.specimen.prestretch.nominal:
        pair = pair_at(stretch, runs)
        yield _row(case, stretch, mesh, pair, runs.sensitivity(stretch, pair.shell))


def pair_at(stretch: float, runs: "Runs") -> Pair:
    """Return both solvers at a milestone, of a thin sheet in one state."""
    shell, solid = runs.alone("dshell"), runs.alone("fenics")
    place = [runs.case.specimen.prestretch.nominal.index(stretch)]
    own = [result.isel(prestretch=place) for result in (solid, shell)]
    if runs.case.is_thin:
        return in_one_state(*own, TOLERANCE, partial(runs.led, stretch))
    return as_found(*own, TOLERANCE)


def with_sensitivity(case: Case, rows: Sequence[Row], kept: Path) -> list[Row]:
    """Return the rows of a case, those that both solvers came to by themselves with sensitivity."""
    runs = Runs(case, bilayer.generate_mesh(case.specimen), kept)
    shell = runs.alone("dshell")
    places = {stretch: [k] for k, stretch in enumerate(case.specimen.prestretch.nominal)}
    return [
        replace(
            row,
            sensitivity=runs.sensitivity(
                row.prestretch, shell.isel(prestretch=places[row.prestretch])
            ),
        )
        if row.state == "both" and np.isnan(row.sensitivity)
        else row
        for row in rows
    ]


@dataclass(frozen=True, eq=False)
class Runs:
    """The runs of a case, each kept in a file.

    Parameters
    ----------
    case : Case
        The sheet.
    mesh : PlanarMesh
        Of all runs.
    kept : Path
        Their folder.
    """

    case: Case
    mesh: PlanarMesh
    kept: Path

    def alone(self, solver: SolverName) -> xr.Dataset:
        """Return what a solver comes to through all milestones by itself."""
        return self._kept(self.case.specimen, solver, solver)

    def led(self, stretch: float, solver: SolverName, start: xr.Dataset) -> xr.Dataset:
        """Return what a solver comes to at a milestone from the other one's shape there."""
        specimen = self.case.specimen.with_milestones([stretch])
        settings = AT_ONCE if solver == "fenics" else None
        return self._kept(specimen, solver, f"{solver}_led_{stretch:g}", settings, start)

    def started(
        self, stretch: float, name: str, settings: bilayer.MorleySettings, start: xr.Dataset
    ) -> xr.Dataset:
        """Return what the shell comes to at a milestone from a shape, with other settings."""
        specimen = self.case.specimen.with_milestones([stretch])
        return self._kept(specimen, "dshell", f"dshell_{name}_{stretch:g}", settings, start)

    def sensitivity(self, stretch: float, shell: xr.Dataset) -> float:
        """Return how far a shape of the shell moves with the moduli; NaN for a thick sheet."""
        if not self.case.is_thin:
            return np.nan
        length = self.case.specimen.characteristic_length
        softer = softened(self.case.specimen.with_milestones([stretch]), SOFTER)
        result = bilayer.solve(softer, "dshell", mesh=self.mesh, start=shell)
        shapes = [found["position"].values[0] for found in (result, shell)]
        return rms_distance(*shapes, flat_surface(self.mesh).node_areas) / length

    def _kept(
        self,
        specimen: bilayer.Specimen,
        solver: SolverName,
        name: str,
        settings: bilayer.SolidSettings | bilayer.MorleySettings | None = None,
        start: xr.Dataset | None = None,
    ) -> xr.Dataset:
        path = self.kept / f"{self.case.file_name}_{name}.nc"
        return bilayer.solve(
            specimen,
            solver,
            settings,
            mesh=self.mesh,
            start=start,
            output=path,
            resume=path if path.exists() else None,
        )


def _row(case: Case, stretch: float, mesh: PlanarMesh, pair: Pair, sensitivity: float) -> Row:
    specimen, solid, shell = case.specimen, pair.solid, pair.shell
    length = specimen.characteristic_length
    return Row(
        case.sheet,
        case.pile,
        sum(layer.thickness for layer in specimen.layers) / length,
        int(case.share is None),
        stretch,
        specimen.mesh.size,
        len(mesh.triangles),
        pair.state,
        pair.distance,
        sensitivity,
        solid["height"].item() / length,
        shell["height"].item() / length,
        energy(solid) / energy(shell),
        pair.excess_solid,
        pair.excess_shell,
        solid["unstable_modes"].item(),
        shell["unstable_modes"].item(),
        solid["self_contact_gap"].item() / length,
    )


def rows_on(rows: Sequence[Row], case: Case) -> list[Row]:
    """Return the rows of a case on its mesh."""
    specimen = case.specimen
    thickness = sum(layer.thickness for layer in specimen.layers) / specimen.characteristic_length
    key = (case.sheet, case.pile, round(thickness, 9), int(case.share is None))
    return [
        row for row in rows if row.case == key and abs(row.mesh_size - specimen.mesh.size) < 1e-9
    ]


def on_finest_mesh(rows: Sequence[Row]) -> list[Row]:
    """Return the rows on the finest mesh of each sheet."""
    finest: dict[tuple[str, str, float, int], float] = {}
    for row in rows:
        finest[row.case] = min(row.mesh_size, finest.get(row.case, np.inf))
    return [row for row in rows if row.mesh_size == finest[row.case]]
