"""The 3D shape that a flat kirigami bilayer takes on release: specimen, mesh, result, comparison.

>>> import bilayer
>>> result = bilayer.solve(bilayer.paper_specimen(), "dshell")  # doctest: +SKIP

The names in `__all__` are all that a user needs; each is loaded when it is first used.
"""

import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if not {"netCDF4", "h5py"} & set(sys.modules):  # what is loaded has read it already
    # Not every file system has locks (NFS without lockd, Lustre). A file of ours is written under
    # a name of its own and moved, so it needs none.
    os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

if TYPE_CHECKING:
    from bilayer.cutting.files import write_cut_files
    from bilayer.designing.run import design
    from bilayer.designing.task import read_design
    from bilayer.errors import BilayerError, ComputationError, InputError
    from bilayer.exports.conversion import convert, convert_milestones
    from bilayer.exports.series import convert_series
    from bilayer.exports.solid import convert_solid
    from bilayer.figures import (
        draw_birds_eye,
        draw_comparison,
        draw_distances,
        draw_isometric,
        draw_mesh,
        draw_quality,
        draw_quality_against,
        draw_shape,
        draw_shapes,
        save_figure,
    )
    from bilayer.figures.animation import save_animation
    from bilayer.figures.fit import draw_fits
    from bilayer.figures.scan import draw_scan
    from bilayer.fitting.fit import fit
    from bilayer.fitting.measurement import Measurement, read_measurement
    from bilayer.landscape.barrier import barrier
    from bilayer.landscape.confirm_barrier import confirm_barrier
    from bilayer.landscape.lower import look_below
    from bilayer.landscape.lowest import take_lowest
    from bilayer.landscape.search import states
    from bilayer.mechanics.selection import scalar_field
    from bilayer.mesh.generation import generate_mesh
    from bilayer.mesh.planar import PlanarMesh
    from bilayer.mesh.planar_files import read_planar_mesh, write_planar_mesh
    from bilayer.results.comparison import compare
    from bilayer.results.files import open_result, write_result
    from bilayer.results.schema import result_mesh, result_specimen
    from bilayer.runtime.version import __version__
    from bilayer.scan.cloud import Cloud, read_cloud
    from bilayer.scan.comparison import compare_scan
    from bilayer.scan.field import distance_to_scan
    from bilayer.solvers.between import solve_between
    from bilayer.solvers.fields import fields
    from bilayer.solvers.registry import follow, solve
    from bilayer.solvers.scan_fit import fit_to_scan
    from bilayer.specimen.density_field import DensityField
    from bilayer.specimen.layer import BondedLayer, Layer, Response
    from bilayer.specimen.load import Load
    from bilayer.specimen.materials import (
        ArrudaBoyce,
        Gent,
        Hyperelastic,
        LinearElastic,
        MooneyRivlin,
        NeoHookean,
        Ogden,
        Yeoh,
        register_law,
    )
    from bilayer.specimen.obstacle import PlaneObstacle, SphereObstacle
    from bilayer.specimen.outline import Disc, Ellipse, Polygon, Rectangle, RegularPolygon
    from bilayer.specimen.part import Limit, Part
    from bilayer.specimen.pattern import (
        Contours,
        Cross,
        CutPattern,
        Pattern,
        Polygons,
        SectorProfile,
    )
    from bilayer.specimen.prestretch import Prestretch
    from bilayer.specimen.specimen import MeshSize, Specimen
    from bilayer.specimen.supported import Support
    from bilayer.specimen.toml import (
        paper_specimen,
        parse_specimen,
        read_specimen,
        specimen_to_toml,
    )
    from bilayer.specimen.two_layers import disc_bilayer
    from bilayer.study.dataset import open_study
    from bilayer.study.plan import read_study
    from bilayer.study.run import run_study
    from bilayer.viewer.page import view
    from dshell.settings import HingeSettings, MorleySettings, PaperSettings
    from fenics_model.settings import SolidSettings

_MODULES = {
    "bilayer.cutting.files": ("write_cut_files",),
    "bilayer.designing.run": ("design",),
    "bilayer.designing.task": ("read_design",),
    "bilayer.errors": ("BilayerError", "ComputationError", "InputError"),
    "bilayer.figures": (
        "draw_birds_eye",
        "draw_comparison",
        "draw_distances",
        "draw_isometric",
        "draw_mesh",
        "draw_quality",
        "draw_quality_against",
        "draw_shape",
        "draw_shapes",
        "save_figure",
    ),
    "bilayer.figures.animation": ("save_animation",),
    "bilayer.figures.fit": ("draw_fits",),
    "bilayer.figures.scan": ("draw_scan",),
    "bilayer.fitting.fit": ("fit",),
    "bilayer.fitting.measurement": ("Measurement", "read_measurement"),
    "bilayer.landscape.barrier": ("barrier",),
    "bilayer.landscape.confirm_barrier": ("confirm_barrier",),
    "bilayer.landscape.lower": ("look_below",),
    "bilayer.landscape.lowest": ("take_lowest",),
    "bilayer.landscape.search": ("states",),
    "bilayer.mechanics.selection": ("scalar_field",),
    "bilayer.mesh.generation": ("generate_mesh",),
    "bilayer.mesh.planar": ("PlanarMesh",),
    "bilayer.mesh.planar_files": ("read_planar_mesh", "write_planar_mesh"),
    "bilayer.results.comparison": ("compare",),
    "bilayer.exports.conversion": ("convert", "convert_milestones"),
    "bilayer.exports.series": ("convert_series",),
    "bilayer.exports.solid": ("convert_solid",),
    "bilayer.results.files": ("open_result", "write_result"),
    "bilayer.results.schema": ("result_mesh", "result_specimen"),
    "bilayer.runtime.version": ("__version__",),
    "bilayer.scan.cloud": ("Cloud", "read_cloud"),
    "bilayer.scan.comparison": ("compare_scan",),
    "bilayer.scan.field": ("distance_to_scan",),
    "bilayer.solvers.between": ("solve_between",),
    "bilayer.solvers.fields": ("fields",),
    "bilayer.solvers.registry": ("follow", "solve"),
    "bilayer.solvers.scan_fit": ("fit_to_scan",),
    "bilayer.specimen.materials": (
        "ArrudaBoyce",
        "Gent",
        "Hyperelastic",
        "LinearElastic",
        "MooneyRivlin",
        "NeoHookean",
        "Ogden",
        "Yeoh",
        "register_law",
    ),
    "bilayer.specimen.density_field": ("DensityField",),
    "bilayer.specimen.layer": ("BondedLayer", "Layer", "Response"),
    "bilayer.specimen.load": ("Load",),
    "bilayer.specimen.obstacle": ("PlaneObstacle", "SphereObstacle"),
    "bilayer.specimen.outline": ("Disc", "Ellipse", "Polygon", "Rectangle", "RegularPolygon"),
    "bilayer.specimen.part": ("Limit", "Part"),
    "bilayer.specimen.pattern": (
        "Contours",
        "Cross",
        "CutPattern",
        "Pattern",
        "Polygons",
        "SectorProfile",
    ),
    "bilayer.specimen.prestretch": ("Prestretch",),
    "bilayer.specimen.specimen": ("MeshSize", "Specimen"),
    "bilayer.specimen.supported": ("Support",),
    "bilayer.specimen.toml": (
        "paper_specimen",
        "parse_specimen",
        "read_specimen",
        "specimen_to_toml",
    ),
    "bilayer.specimen.two_layers": ("disc_bilayer",),
    "bilayer.study.dataset": ("open_study",),
    "bilayer.study.plan": ("read_study",),
    "bilayer.study.run": ("run_study",),
    "bilayer.viewer.page": ("view",),
    "dshell.settings": ("HingeSettings", "MorleySettings", "PaperSettings"),
    "fenics_model.settings": ("SolidSettings",),
}
"""The module of each public name."""

_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Load a public name from its module, and keep it."""
    if name not in _HOME:
        raise AttributeError(f"module 'bilayer' has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_HOME[name]), name)
    if "xarray" in sys.modules:
        import_module("bilayer.accessor")  # datasets get `.bilayer`
    return value


def __dir__() -> list[str]:
    """Return the public names alone."""
    return __all__
