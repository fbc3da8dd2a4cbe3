"""What docs/stability.md calls stable is still there: `old_files/stable_1.0.0.json` lists it.

A name that is added goes into the list with the next minor version; one that is missing is a change
that only a major version may make.
"""

import dataclasses
import inspect
import json
from pathlib import Path

import pytest

import bilayer
from bilayer.cli.parser import main_parser
from bilayer.cli.verbs import VERBS, load_verb
from bilayer.results.conformity import LAYOUTS
from bilayer.results.schema import REQUIRED
from bilayer.solvers.registry import SOLVERS, solver_named
from bilayer.specimen.long_form import LAYER, LONG_TABLES
from bilayer.specimen.outline import OUTLINES
from bilayer.specimen.pattern_kinds import PATTERNS
from bilayer.specimen.short_form import short_tables
from bilayer.specimen.units import UNITS
from bilayer.study.plan import KEYS

LIST = Path(__file__).parent / "bilayer/old_files/stable_1.0.0.json"


@pytest.fixture(scope="module")
def stable():
    return json.loads(LIST.read_text(encoding="utf-8"))


def keywords_of(name):
    """Return the arguments of a public name that can be given by keyword."""
    try:
        parameters = inspect.signature(getattr(bilayer, name)).parameters.values()
    except (TypeError, ValueError):  # a number, a type alias, an exception
        return []
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [each.name for each in parameters if each.kind in named]


def options_of(verb):
    """Return the options of a verb."""
    verbs = main_parser(prog="bilayer").add_subparsers()
    load_verb(verb).add(verbs)
    return sorted(verbs.choices[verb]._option_string_actions)


def settings_of(solver):
    """Return the settings of each model of a solver."""
    models = solver_named(solver).models
    return {name: [each.name for each in dataclasses.fields(kind)] for name, kind in models.items()}


def schema():
    """Return the variables of a result with their dimensions, and the attributes it must have."""
    variables = {name: list(layout.dims) for name, layout in sorted(LAYOUTS.items())}
    return {"variables": variables, "attributes": list(REQUIRED["attribute"])}


def keys():
    """Return the keys of each table of specimen and study files, and the names that they take."""
    tables = {f"short {name}": known for name, known in short_tables().items()}
    tables |= {f"long {name}": known for name, known in LONG_TABLES.items()}
    tables |= {"layer": LAYER, "outline": OUTLINES, "pattern": PATTERNS, "study": KEYS}
    return {name: sorted(map(str, known)) for name, known in tables.items()}


def test_python_names_and_their_arguments_stay(stable):
    gone = {
        name: [each for each in arguments if each not in keywords_of(name)]
        for name, arguments in stable["python"].items()
        if hasattr(bilayer, name)
    }
    assert not set(stable["python"]) - set(dir(bilayer))
    assert not {name: arguments for name, arguments in gone.items() if arguments}


def test_verbs_and_their_options_stay(stable):
    assert not set(stable["verbs"]) - set(VERBS)
    gone = {verb: set(options) - set(options_of(verb)) for verb, options in stable["verbs"].items()}
    assert not {verb: options for verb, options in gone.items() if options}


@pytest.mark.parametrize("solver", SOLVERS)
def test_settings_stay(solver, stable):
    now = settings_of(solver)
    for model, names in stable["settings"][solver].items():
        assert not set(names) - set(now[model])


def test_keys_of_files_and_their_units_stay(stable):
    now = keys()
    for table, names in stable["keys"].items():
        assert not set(names) - set(now[table]), table
    assert stable["units"].items() <= UNITS.items()


def test_the_schema_stays(stable):
    now = schema()
    assert not set(stable["schema"]["attributes"]) - set(now["attributes"])
    for name, dims in stable["schema"]["variables"].items():
        assert now["variables"][name] == dims, name


def everything():
    """Return the list of the version that is checked out, which `python3 FILE` writes."""
    return {
        "python": {name: keywords_of(name) for name in dir(bilayer)},
        "verbs": {verb: options_of(verb) for verb in VERBS},
        "settings": {solver: settings_of(solver) for solver in SOLVERS},
        "schema": schema(),
        "keys": keys(),
        "units": UNITS,
    }


if __name__ == "__main__":
    LIST.write_text(json.dumps(everything(), indent=1) + "\n", encoding="utf-8")
