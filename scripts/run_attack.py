"""The reliability of the program: bad inputs, signals, kills, limits; writes docs/reliability.md.

Started by scripts/attack, which sets the environment up. The inputs are those of tests/attack.
"""

import argparse
import csv
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from attack import campaign, conditions, page, signals  # noqa: E402
from attack.bench import Bench  # noqa: E402

FOLDER = ROOT / "results" / "attack"
COUNT = 3000


@dataclass(frozen=True)
class ClassRow:
    """The outcome of one class of inputs."""

    kind: str
    inputs: int
    mishandled: int
    longest_seconds: float


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    with tempfile.TemporaryDirectory(prefix="attack-", dir="/tmp") as scratch:
        bench = Bench(Path(scratch, "bench"))
        status: int = options.run(options, bench, Path(scratch))
    if options.write:
        page.write(ROOT / "docs" / "reliability.md", FOLDER)
    return status


def run_inputs(options: argparse.Namespace, bench: Bench, scratch: Path) -> int:
    """Try inputs, print and count what was mishandled, by class."""
    classes = options.classes or list(campaign.CLASSES)
    count = None if options.all else options.count
    chosen = campaign.choose(bench, options.seed, classes, count, options.quick)
    rows = {name: ClassRow(name, 0, 0, 0.0) for name in classes}
    mishandled = []
    for verdict in campaign.run(bench, chosen, scratch / "tried"):
        kind = verdict.attempt.kind
        row = rows[kind]
        rows[kind] = ClassRow(
            kind,
            row.inputs + 1,
            row.mishandled + bool(verdict.wrong),
            max(row.longest_seconds, round(verdict.seconds, 2)),
        )
        if verdict.wrong:
            name = _printable(f"{verdict.attempt.name}: {verdict.wrong}")
            print(f"{kind}: {name}", flush=True)
            mishandled.append({"kind": kind, "what": name})
    for row in rows.values():
        print(
            f"{row.kind:18} {row.mishandled:4d} of {row.inputs:4d} mishandled, "
            f"longest {row.longest_seconds:.1f} s"
        )
    print(f"{len(mishandled)} of {len(chosen)} mishandled")
    if options.write:
        _keep(
            "inputs.csv", [asdict(row) | {"seed": options.seed} for row in rows.values()], ["kind"]
        )
    return int(bool(mishandled))


def run_signals(options: argparse.Namespace, bench: Bench, scratch: Path) -> int:
    """Signal runs at placed moments; print what came of it."""
    reports = signals.strike_all(bench, scratch, options.only)
    return _reported(reports, "signals.csv", options, ["moment", "signal"])


def run_kills(options: argparse.Namespace, bench: Bench, scratch: Path) -> int:
    """Kill studies at placed and at random moments; print what came of it."""
    return _reported(signals.kill_all(bench, scratch, options.seed), "kills.csv", options)


def run_conditions(options: argparse.Namespace, bench: Bench, scratch: Path) -> int:
    """Full disks, two writers, two studies, files that go; print what came of it."""
    return _reported(conditions.meet_all(bench, scratch), "conditions.csv", options)


def _reported(
    reports: Iterator[Any], name: str, options: argparse.Namespace, key: Sequence[str] = ()
) -> int:
    """Print reports as they come; keep them if asked to; return 1 if one is of something wrong."""
    rows = []
    for report in reports:
        words = ", ".join(
            f"{field.name} {getattr(report, field.name)}"
            for field in fields(report)
            if field.name != "wrong"
        )
        print(
            f"{'WRONG' if report.wrong else 'right'}  {words}  {report.wrong}".rstrip(), flush=True
        )
        rows.append(asdict(report))
    wrong = sum(bool(row["wrong"]) for row in rows)
    print(f"{wrong} of {len(rows)} mishandled")
    if options.write:
        _keep(name, rows, key)
    return int(wrong > 0)


def _keep(name: str, rows: Sequence[dict[str, Any]], key: Sequence[str] = ()) -> None:
    """Keep rows in a file; if a key is told, those of other runs with another key stay."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    file = FOLDER / name
    held: dict[Any, dict[str, Any]] = {}
    if key and file.exists():
        with file.open(encoding="utf-8", newline="") as lines:
            held = {tuple(row[part] for part in key): row for row in csv.DictReader(lines)}
    kept = held | {tuple(str(row[part]) for part in key or row): row for row in rows}
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept.values())


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/attack",
        description="What bad input, signals, kills and lacking resources do to the program.",
        epilog="example: scripts/attack inputs --class 'mesh file' --all",
    )
    parts = parser.add_subparsers(required=True, metavar="WHAT")
    texts = {
        "inputs": (run_inputs, "bad and unusual inputs, each in a child process"),
        "signals": (run_signals, "Ctrl-C and SIGTERM at 30 moments"),
        "kills": (run_kills, "SIGKILL of a study, at 9 placed and 20 random moments"),
        "conditions": (run_conditions, "full disk, two writers, two studies, what is deleted"),
    }
    for name, (run, text) in texts.items():
        part = parts.add_parser(name, help=text, description=text)
        part.set_defaults(run=run)
        part.add_argument("--seed", type=int, default=1, help="of the choice (default: 1)")
        part.add_argument(
            "--write", action="store_true", help="keep the figures in results/attack and the page"
        )
        if name == "inputs":
            _add_choice(part)
        if name == "signals":
            part.add_argument("--only", default="", help="moments whose names contain this text")
    return parser.parse_args(words)


def _add_choice(part: argparse.ArgumentParser) -> None:
    part.add_argument(
        "--class",
        action="append",
        dest="classes",
        choices=list(campaign.CLASSES),
        help="a class of inputs; several if given several times (default: all)",
    )
    part.add_argument(
        "--count", type=int, default=COUNT, help=f"number of inputs (default: {COUNT})"
    )
    part.add_argument("--all", action="store_true", help="all inputs that there are")
    part.add_argument("--quick", action="store_true", help="none that need a process of their own")


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
