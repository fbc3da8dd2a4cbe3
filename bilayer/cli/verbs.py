"""The verbs of the command line, each with its help in a line.

A verb is a module of its own: `add` its arguments, `run` it. The module is loaded when the verb is
called, so that none waits for what another needs.
"""

import keyword
from importlib import import_module
from types import ModuleType

VERBS = {
    "demo": "compute the paper's specimen; write a picture and a page of its shapes",
    "init": "print the paper's specimen as a commented template",
    "mesh": "mesh the flat disc; write the mesh, and its picture beside it",
    "cut": "write what has to be cut for each layer, 1:1 in mm, as DXF, SVG or PDF",
    "fit": "find the constants of a law from tests of a material",
    "solve": "compute the released shapes; write them as NetCDF",
    "states": "find the stable shapes at one prestretch, and say how sure that is",
    "barrier": "find the way of least energy between two stable shapes",
    "compare": "compare two results on the same planar mesh",
    "settings": "list the models of the solvers, or the settings of one",
    "plot": "draw isometric and bird's-eye views per prestretch",
    "animate": "write the shapes one after the other as a GIF or an MP4",
    "view": "write a page that shows a result in three dimensions, and open it",
    "convert": "write the shapes for ParaView and others",
    "export": "write the specimen as Abaqus input decks, which CalculiX runs; one per prestretch",
    "import": "read what CalculiX made of exported decks; write it as NetCDF",
    "info": "say what a sheet is, or what made a result and how far it can be trusted",
    "study": "compute many specimens; a second start goes on where one ended",
    "plot-study": "draw a quantity of a study over one of its fields",
    "design": "find the cuts, thicknesses and prestretch that make a wanted shape",
    "rerun": "compute a result again, and say whether the numbers agree",
}


def load_verb(name: str) -> ModuleType:
    """Return the module of a verb: `plot_study` of "plot-study", `import_` of "import"."""
    module = name.replace("-", "_")
    return import_module(f"bilayer.cli.{module}{'_' * keyword.iskeyword(module)}")
