"""The specimen, its prestretches and its mesh, as the verbs that need them are told."""

import argparse
import re
from pathlib import Path
from typing import Any

from bilayer.cli.parser import Parser
from bilayer.errors import InputError
from bilayer.mesh.agreement import check_agreement
from bilayer.mesh.generation import generate_mesh
from bilayer.mesh.planar import PlanarMesh
from bilayer.mesh.planar_files import read_planar_mesh
from bilayer.results.files import open_result
from bilayer.results.schema import result_mesh
from bilayer.runtime.ranks import is_first_rank
from bilayer.runtime.terminal import keep_quiet, warn
from bilayer.specimen.doubts import doubts
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import read_specimen


def add_specimen_arguments(verb: Parser) -> None:
    """Add the specimen file and what may be changed of it, its mesh size too."""
    add_specimen_file(verb)
    verb.add_argument(
        "--mesh-size", metavar="M",
        help="edge length of the planar mesh, a number in m or a text such as '4 mm'",
    )  # fmt: skip


def add_specimen_file(verb: Parser) -> None:
    """Add the specimen file and what may be changed of it, for a verb that meshes nothing."""
    verb.add_argument("specimen", help="the specimen's TOML file")
    verb.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="replace one value of the specimen, as in --set substrate.thickness='0.8 mm'",
    )  # fmt: skip


def add_case_arguments(verb: Parser) -> None:
    """Add which of the specimen's prestretches are meant, and on which mesh."""
    verb.add_argument(
        "--prestretch", nargs="+", metavar="L",
        help="milestones instead of the file's; L, or LX,LY for two directions",
    )  # fmt: skip
    verb.add_argument("--mesh", metavar="FILE", help="use this planar mesh, or that of a result")


def read_specimen_argument(options: argparse.Namespace, overrides: list[str]) -> Specimen:
    """Read the specimen of the command line, some of its values replaced; tell what is doubtful."""
    if options.mesh_size is not None:
        overrides = [*overrides, f"mesh.size={options.mesh_size}"]
    first = is_first_rank()
    specimen = read_specimen(options.specimen, overrides, notice=warn if first else keep_quiet)
    if getattr(options, "prestretch", None) is not None:
        milestones = [milestone_argument(word) for word in options.prestretch]
        specimen = specimen.with_milestones(milestones)
    if first:
        for doubt in doubts(specimen):
            warn(doubt)
    return specimen


def read_mesh_argument(options: argparse.Namespace, specimen: Specimen) -> PlanarMesh:
    """Return the mesh of the command line, one of the specimen, or a generated one."""
    if options.mesh is None:
        return generate_mesh(specimen)
    if Path(options.mesh).suffix == ".nc":
        mesh = result_mesh(open_result(options.mesh))
    else:
        mesh = read_planar_mesh(options.mesh, specimen.layer_sets)
    try:
        check_agreement(specimen, mesh)
    except InputError as error:
        raise InputError(str(error).replace("mesh:", f"mesh file {options.mesh}:", 1)) from error
    return mesh


def milestone_argument(word: str) -> Any:
    """Read L or LX,LY; "1,06" is a decimal comma, not a stretch of 6."""
    if re.search(r",0\d", word):
        raise InputError(f"--prestretch {word}: expected a decimal point, not a comma")
    try:
        numbers = tuple(float(part) for part in word.split(","))
    except ValueError:
        raise InputError(
            f"--prestretch {word}: expected a number, or two as LX,LY (1.06 is 6 %)"
        ) from None
    return numbers[0] if len(numbers) == 1 else numbers
