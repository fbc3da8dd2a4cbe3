"""A case of a study: one specimen with one solver, named by the hash of what defines it."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from bilayer.mesh.generation import check_memory, estimated_triangles
from bilayer.results.schema import SCHEMA_VERSION
from bilayer.solvers.registry import solver_named
from bilayer.specimen.settings import settings_to_toml
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import specimen_to_toml

BYTES_OF_A_PROCESS = 290_000_000
"""The interpreter with its libraries, the most that `scripts/studies/overhead.py` finds."""


@dataclass(frozen=True, eq=False)
class Case:
    """One computation of a study.

    Parameters
    ----------
    specimen : Specimen
        With all its milestones: a sweep of the prestretch is one load path, so one case.
    solver, model : str
        Names as in `bilayer.solvers.registry`.
    settings : settings dataclass
        Of that model.
    values : mapping
        What the study varies of it, value by dotted name.
    """

    specimen: Specimen
    solver: str
    model: str
    settings: Any
    values: Mapping[str, Any]

    @cached_property
    def identity(self) -> str:
        """Hash of the specimen without its label, the solver, the model and all its settings.

        Neither file names nor the version of the program count; a result of another schema does.
        """
        definition = [
            SCHEMA_VERSION,
            specimen_to_toml(replace(self.specimen, name="")),
            self.solver,
            self.model,
            settings_to_toml(self.settings),
        ]
        return _hash(definition)

    @property
    def mesh_identity(self) -> str:
        """Hash of what the planar mesh is made from: cases of one hash share their mesh."""
        return _hash(self.specimen.flat_identity)

    @cached_property
    def triangles(self) -> float:
        """Estimated number of triangles of the planar mesh."""
        return estimated_triangles(self.specimen)

    @property
    def milestones(self) -> int:
        """Number of milestones on the load path."""
        return len(self.specimen.prestretch.milestones)

    @property
    def memory(self) -> float:
        """Estimated memory of the process that computes it, bytes."""
        return BYTES_OF_A_PROCESS + self._model_memory

    def check_memory(self, available: float) -> None:
        """Raise NotEnoughMemoryError if its process would take more than is available, bytes."""
        check_memory(
            self.specimen,
            self._bytes_per_triangle,
            f"the solver {self.solver!r}",
            max(available - BYTES_OF_A_PROCESS, 0.0),
        )

    @property
    def _model_memory(self) -> float:
        return self.triangles * self._bytes_per_triangle

    @property
    def _bytes_per_triangle(self) -> float:
        return solver_named(self.solver).bytes_per_triangle(self.specimen, self.settings)

    @property
    def cost(self) -> float:
        """Estimated effort, in no particular unit: memory to fill times milestones to reach."""
        return self._model_memory * self.milestones

    def __str__(self) -> str:
        """Return the varied values, as "solver = dshell, cut.strips = 5"."""
        words = {"solver": self.solver, **self.values}
        return ", ".join(f"{name} = {value}" for name, value in words.items())


def _hash(definition: Any) -> str:
    return hashlib.sha256(json.dumps(definition).encode()).hexdigest()[:16]
