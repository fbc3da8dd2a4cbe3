"""The verification ladder: computes its rungs, prints them, writes docs/verification.md.

Started by scripts/verify, which sets the environment up.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from verification.calculix_rung import CALCULIX_RUNGS
from verification.fenics_rungs import FENICS_RUNGS
from verification.rung import Check, Rung
from verification.shell_rungs import SHELL_RUNGS
from verification.table import missed, page, renewed_page, rung_text, summary

from bilayer.errors import InputError
from bilayer.runtime.output_file import whole_file

RUNGS: tuple[Rung, ...] = tuple(
    sorted((*SHELL_RUNGS, *FENICS_RUNGS, *CALCULIX_RUNGS), key=lambda rung: rung.number)
)
PAGE = Path(__file__).parents[1] / "docs" / "verification.md"
ABSENT = {
    "20, a sheet rolled into two turns": "with one end bare it gets past the first turn (1.7 "
    "turns at 1.14 by the shell, a strip of 70 mm); two turns are not shown yet.",
    "4 to 13 for the models `hinge` and `paper`": "a lattice is not a plate (rung 9). The "
    "ladder has only the curvature of a uniform disc and the closed forms of the lattice.",
}


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    known = {rung.number for rung in RUNGS}
    unknown = sorted(set(options.rung) - known)
    if unknown:
        print(
            f"scripts/verify: error: rung {unknown[0]}: expected one of "
            f"{', '.join(map(str, sorted(known)))}",
            file=sys.stderr,
        )
        return 2
    chosen = [rung for rung in RUNGS if not options.rung or rung.number in options.rung]
    try:
        if options.renew:
            return renew(chosen, options.output)
        return verify(chosen, None if options.rung else options.output)
    except InputError as error:
        print(f"scripts/verify: error: {error}", file=sys.stderr)
        return 2


def verify(rungs: Sequence[Rung], output: Path | None) -> int:
    """Climb the rungs, print each, write the page if there is one; 1 if a check misses."""
    ladder = _climb(rungs)
    if output is not None:
        _write(output, page(ladder, ABSENT))
    return 1 if missed(ladder) else 0


def renew(rungs: Sequence[Rung], output: Path) -> int:
    """Climb some rungs and put them in their places on the page; 1 if a check misses."""
    ladder = _climb(rungs)
    _write(output, renewed_page(output.read_text(encoding="utf-8"), RUNGS, ladder, ABSENT))
    return 1 if missed(ladder) else 0


def _climb(rungs: Sequence[Rung]) -> list[tuple[Rung, list[Check]]]:
    ladder: list[tuple[Rung, list[Check]]] = []
    for rung in rungs:
        start = time.process_time()
        checks = rung.climb()
        ladder.append((rung, checks))
        print(rung_text(rung, checks), f"  CPU {time.process_time() - start:.1f} s\n", flush=True)
    print(summary(ladder))
    return ladder


def _write(output: Path, text: str) -> None:
    with whole_file(output, "page") as path:
        path.write_text(text, encoding="utf-8")
    print(f"The page is {output}")


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/verify",
        description="Cases with known answers: what is measured, the reference, the verdict. "
        "Exit status 1 if a check misses its tolerance.",
        epilog="examples:\n  scripts/verify          # all rungs, and docs/verification.md"
        "\n  scripts/verify 9 13     # these rungs, printed only"
        "\n  scripts/verify 9 --renew    # this rung, in its place on the page",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "rung", type=int, nargs="*", metavar="RUNG",
        help=f"number of a rung: {', '.join(map(str, sorted({r.number for r in RUNGS})))}",
    )  # fmt: skip
    parser.add_argument(
        "--output", type=Path, default=PAGE, metavar="FILE",
        help="page to write if all rungs are computed (default: docs/verification.md)",
    )  # fmt: skip
    parser.add_argument(
        "--renew", action="store_true",
        help="put the rungs that are named in their places on the page, the others as they were",
    )  # fmt: skip
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
