"""Pages of the reference that the program itself knows best: its verbs and its settings."""

import argparse
import dataclasses
import re
from collections.abc import Iterator, Mapping
from textwrap import dedent

from bilayer.cli.parser import Parser, main_parser
from bilayer.cli.verbs import VERBS, load_verb
from bilayer.solvers.registry import SOLVERS, solver_named
from documentation.staging import CHECKOUT


def written_texts() -> Mapping[str, str]:
    """Return the texts in MyST that pages ask for, by their names."""
    return {
        "the verbs": "\n".join(map(verb_text, VERBS)),
        "the settings": "\n".join(_settings_texts()),
        "the changes": _changes(),
        "how to contribute": _contributing(),
    }


def _changes() -> str:
    """Return the changelog without its title, its links as seen from docs/."""
    text = (CHECKOUT / "CHANGELOG.md").read_text(encoding="utf-8")
    return text.partition("\n")[2].replace("](docs/", "](")


def _contributing() -> str:
    """Return the page for contributors as a section, its links as seen from docs/."""
    text = (CHECKOUT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for seen, there in (
        ("](docs/", "]("),
        ("](CHANGELOG.md)", "](changelog.md)"),
        ("[MIT licence](LICENSE)", "[MIT licence](../LICENSE)"),
        ("[code of conduct](CODE_OF_CONDUCT.md)", "code of conduct (`CODE_OF_CONDUCT.md`)"),
    ):
        text = text.replace(seen, there)
    return re.sub("^#", "##", text, flags=re.MULTILINE)


def verb_text(name: str) -> str:
    """Return the section of a verb: what it does, how it is called, its options."""
    parser = verb_parser(name)
    example = dedent((parser.epilog or "").removeprefix("example:\n"))
    lines = [f"## {name}", "", _sentence(VERBS[name]), "", "```text", parser.format_usage().strip()]
    rows = [f"| {_called(action)} | {_meaning(action)} |" for action in _told(parser)]
    lines += ["```", "", *(["| argument | meaning |", "|---|---|", *rows] if rows else [])]
    return "\n".join([*lines, "", "```text", example.rstrip(), "```", ""])


def verb_parser(name: str) -> Parser:
    """Return the parser of a verb, as the command makes it."""
    verbs = main_parser(prog="bilayer").add_subparsers()
    load_verb(name).add(verbs)
    return verbs.choices[name]


def _told(parser: Parser) -> list[argparse.Action]:
    """Return the arguments that are the verb's own."""
    return [
        action
        for action in parser._actions
        if action.help != argparse.SUPPRESS and action.dest not in ("help", "quiet", "verbose")
    ]


def _called(action: argparse.Action) -> str:
    """Return how an argument is written."""
    value = "" if action.nargs == 0 else _value(action)
    if not action.option_strings:
        return f"`{value}`"
    return ", ".join(f"`{option} {value}`".replace(" `", "`") for option in action.option_strings)


def _value(action: argparse.Action) -> str:
    if action.metavar is not None:
        given = action.metavar if isinstance(action.metavar, str) else " ".join(action.metavar)
    elif action.choices is not None:
        given = "{" + ",".join(map(str, action.choices)) + "}"
    else:
        given = action.dest.upper()
    return given.replace("|", "\\|") + ("..." if action.nargs in ("+", "*") else "")


def _meaning(action: argparse.Action) -> str:
    words = [_in_table(action.help)] if action.help else []
    shown = action.default not in (None, False, argparse.SUPPRESS, [])
    if shown and "default" not in (action.help or "") and action.nargs != 0:
        words.append(f"(default: {_in_table(str(action.default))})")
    if action.required and action.option_strings:
        words.append("(required)")
    return " ".join(words) or "see above"


def _settings_texts() -> Iterator[str]:
    for solver in SOLVERS:
        for model, kind in solver_named(solver).models.items():
            title = f"## `--solver {solver}`" + (f" `--model {model}`" if solver != model else "")
            yield f"{title}\n\nFrom Python: `bilayer.{kind.__name__}`.\n\n{_settings_table(kind)}\n"


def _settings_table(kind: type) -> str:
    rows = ["| setting | default | meaning |", "|---|---|---|"]
    for field in dataclasses.fields(kind):
        text = _in_table(field.metadata.get("text", ""))
        rows.append(f"| `solver.{field.name}` | `{_default(field.default)}` | {text} |")
    return "\n".join(rows)


def _default(value: object) -> str:
    """Return a default as one writes it in TOML."""
    if value is None:
        return "none"
    return str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _in_table(text: str) -> str:
    return text.replace("%%", "%").replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")
