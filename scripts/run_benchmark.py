"""The benchmarks: each prints its tables and writes its part of docs/performance.md.

Started by scripts/benchmark, which sets the environment up. A benchmark is a module with
`DESCRIPTION`, `EXAMPLES`, `add_options(parser)` and `tables(options)`.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks import calculix, compare, dshell, fenics, machines
from benchmarks.page import with_part

from bilayer.errors import ComputationError, InputError
from bilayer.runtime.output_file import whole_file

BENCHMARKS = {
    "dshell": dshell,
    "fenics": fenics,
    "calculix": calculix,
    "compare": compare,
    "machines": machines,
}
PAGE = Path(__file__).parents[1] / "docs" / "performance.md"


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    try:
        return run(options)
    except (InputError, ComputationError) as error:
        print(f"scripts/benchmark: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1


def run(options: argparse.Namespace) -> int:
    """Print the tables of a benchmark as they come; keep them in the page if asked to."""
    texts = []
    for text in BENCHMARKS[options.benchmark].tables(options):
        print(text, end="\n\n", flush=True)
        texts.append(text)
    if options.write:
        page = with_part(PAGE.read_text(encoding="utf-8"), options.benchmark, texts)
        with whole_file(PAGE, "page") as path:
            path.write_text(page, encoding="utf-8")
        print(f"The page is {PAGE}")
    return 0


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/benchmark",
        description="The cost of a solver: CPU time, iterations, memory. Compare numbers of one "
        "run; seconds depend on the machine.",
        epilog="example: scripts/benchmark dshell --help",
    )
    parsers = parser.add_subparsers(dest="benchmark", required=True, metavar="NAME")
    for name, benchmark in BENCHMARKS.items():
        part = parsers.add_parser(
            name,
            help=benchmark.DESCRIPTION,
            description=benchmark.DESCRIPTION,
            epilog=f"examples:\n{benchmark.EXAMPLES}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        part.add_argument(
            "--write", action="store_true", help="also write the tables to docs/performance.md"
        )
        benchmark.add_options(part)
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
