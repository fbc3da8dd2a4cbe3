"""The 3D shape that a flat kirigami bilayer takes on release: specimen, mesh, result, comparison.

>>> import bilayer
>>> result = bilayer.solve(bilayer.paper_specimen(), "dshell")  # doctest: +SKIP
"""

from bilayer.errors import BilayerError, ComputationError, InputError
from bilayer.material import LinearElastic, MooneyRivlin, NeoHookean
from bilayer.mesh_generation import generate_mesh
from bilayer.planar_mesh import PlanarMesh, read_planar_mesh, write_planar_mesh
from bilayer.result import open_result, result_mesh, result_specimen, write_result
from bilayer.solvers import solve
from bilayer.specimen import CutPattern, Layer, MeshSize, Prestretch, Specimen
from bilayer.specimen_file import (
    paper_specimen,
    parse_specimen,
    read_specimen,
    specimen_to_toml,
)
from bilayer.study.dataset import open_study
from bilayer.version import __version__

__all__ = [
    "BilayerError",
    "ComputationError",
    "CutPattern",
    "InputError",
    "Layer",
    "LinearElastic",
    "MeshSize",
    "MooneyRivlin",
    "NeoHookean",
    "PlanarMesh",
    "Prestretch",
    "Specimen",
    "__version__",
    "generate_mesh",
    "open_result",
    "open_study",
    "paper_specimen",
    "parse_specimen",
    "read_planar_mesh",
    "read_specimen",
    "result_mesh",
    "result_specimen",
    "solve",
    "specimen_to_toml",
    "write_planar_mesh",
    "write_result",
]
