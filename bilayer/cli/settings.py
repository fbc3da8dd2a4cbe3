"""The verb `settings`: the models of the solvers, and what can be set of each."""

import argparse
from typing import Any

from bilayer.cli.parser import add_json_argument, add_verb
from bilayer.errors import InputError
from bilayer.runtime.terminal import say, say_json
from bilayer.solvers.registry import SOLVERS, solver_named
from bilayer.specimen.settings import describe, settings_records
from bilayer.validation import nearest


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "settings",
        "bilayer settings morley\n"
        "  bilayer solve specimen.toml --model morley --set solver.branch=other",
    )  # fmt: skip
    verb.add_argument(
        "model", nargs="?", metavar="MODEL", help="the settings of this model (default: all models)"
    ).completer = lambda **_: list(models())  # type: ignore[attr-defined]
    add_json_argument(verb)


def models() -> dict[str, tuple[str, type]]:
    """Return the solver and the class of the settings of each model, by the model's name."""
    return {
        model: (solver, kind)
        for solver in SOLVERS
        for model, kind in solver_named(solver).models.items()
    }


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    known = models()
    if options.model is not None and options.model not in known:
        raise InputError(
            f"model = {options.model!r}: expected one of {', '.join(known)}"
            f"{nearest(options.model, known)}"
        )
    chosen = [options.model] if options.model else list(known)
    if options.json:
        say_json({name: settings_records(known[name][1]) for name in chosen})
    elif options.model:
        say(f"{_heading(options.model)}; --set solver.NAME=VALUE changes:\n")
        say(describe(known[options.model][1]))
    else:
        say("\n".join(f"{_heading(name):36} bilayer settings {name}" for name in known))
    return 0


def _heading(model: str) -> str:
    return f"--solver {models()[model][0]} --model {model}"
