"""The verb `mesh`: the planar mesh of a specimen, and its picture."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output, input_files
from bilayer.cli.parser import add_verb
from bilayer.cli.specimen_arguments import (
    add_specimen_arguments,
    read_specimen_argument,
)
from bilayer.mesh.files import check_mesh_output
from bilayer.mesh.formats import check_holds_layers
from bilayer.mesh.generation import generate_mesh
from bilayer.mesh.planar import PlanarMesh
from bilayer.mesh.planar_files import write_planar_mesh
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.terminal import say, tell

TITLE = "bilayer-shells mesh"
"""In the picture, so that it is known again and may be replaced."""


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "mesh",
        "bilayer mesh specimen.toml -o mesh.msh",
    )  # fmt: skip
    add_specimen_arguments(verb)
    verb.add_argument(
        "-o", "--output", required=True, help="file; its ending selects one of meshio's formats"
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    check_output(options, check_mesh_output)
    output = Path(options.output)
    specimen = read_specimen_argument(options, options.overrides)
    if not all(layer.is_whole for layer in specimen.layers):
        check_holds_layers(output)
    with progress_bar("mesh", shown=not options.quiet):
        mesh = generate_mesh(specimen)
    write_planar_mesh(mesh, output)
    _draw_beside(mesh, output, options)
    if not options.quiet:
        say(
            f"{len(mesh.points)} nodes, {len(mesh.triangles)} triangles, "
            + ", ".join(
                f"{len(mesh.faces_of(name))} of them {name}"
                for name in specimen.layer_names
                if name != specimen.carrier.name
            )
        )
    return 0


def _draw_beside(mesh: PlanarMesh, output: Path, options: argparse.Namespace) -> None:
    """Draw mesh.msh as mesh.msh.png; a result of that name has its picture in mesh.png."""
    from bilayer.figures import draw_mesh, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output, has_title

    picture = output.with_name(f"{output.name}.png")
    if picture.exists() and not has_title(picture, TITLE):
        tell(f"bilayer: {picture} is there and is no picture of a mesh: not drawn")
        return
    check_figure_output(picture, input_files(options))
    save_figure(draw_mesh(mesh), picture, title=TITLE)
