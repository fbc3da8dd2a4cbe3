"""Builds the site from docs/, the examples and the docstrings; checks it on the way.

Started by scripts/docs, which sets the environment up.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from documentation.blocks import run_page
from documentation.links import faults
from documentation.reference import written_texts
from documentation.staging import CHECKOUT, copy_mathjax, stage

PAGES = sorted(
    page
    for page in (CHECKOUT / "docs").rglob("*.md")
    if page.parent.name in ("tutorials", "how-to") or "```python" in page.read_text("utf-8")
)
"""The pages whose blocks are run: the lessons, and all others with Python in them."""


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    start = time.monotonic()
    folder = options.folder.resolve()
    source = stage(folder / "source", written_texts())
    if _sphinx(source, folder / "html", options.fast) != 0:
        print("scripts/docs: Sphinx found faults, see above", file=sys.stderr)
        return 1
    copy_mathjax(folder / "html" / "_static" / "mathjax")
    found = list(faults(folder / "html"))
    print(*found, sep="\n", file=sys.stderr, end="\n" if found else "")
    failed = [] if options.fast else _pages_that_fail()
    pages = sum(1 for _ in (folder / "html").rglob("*.html"))
    seconds = time.monotonic() - start
    print(
        f"{pages} pages, {len(found)} dead links, {len(failed)} pages whose blocks fail, "
        f"{seconds:.0f} s (CPU {_cpu_seconds():.0f} s): {folder}/html/index.html"
    )
    return 1 if found or failed else 0


def _cpu_seconds() -> float:
    """Return the CPU time of this process and of all that it has started."""
    return sum(os.times()[:4])


def _pages_that_fail() -> list[Path]:
    """Run the blocks of all pages, as many pages at a time as there are cores."""
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        went_well = list(pool.map(_runs, PAGES))
    return [page for page, good in zip(PAGES, went_well, strict=True) if not good]


def _runs(page: Path) -> bool:
    """Run the blocks of a page, and say how long they take and what went wrong."""
    start = time.monotonic()
    fault = run_page(page)
    name = page.relative_to(CHECKOUT)
    print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
    if fault:
        print(f"scripts/docs: {name}: a block fails:\n{fault}", file=sys.stderr)
    return not fault


def _sphinx(source: Path, target: Path, fast: bool) -> int:
    """Return Sphinx's exit status; warnings are errors, and all are told."""
    shutil.rmtree(target, ignore_errors=True)
    words = ["-W", "--keep-going", "--quiet", "-b", "html", "-d", str(target.parent / "doctrees")]
    words += ["-E", "-D", f"plot_gallery={0 if fast else 1}"]
    paths = [str(CHECKOUT), str(CHECKOUT / "scripts"), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    command = [sys.executable, "-m", "sphinx", *words, str(source), str(target)]
    return subprocess.run(command, env=environment).returncode


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/docs",
        description="Build the site without a network. Warnings and dead links are errors.",
    )
    parser.add_argument("--fast", action="store_true", help="run neither examples nor code blocks")
    parser.add_argument(
        "--folder", type=Path, default=CHECKOUT / "build" / "docs",
        help="where to build (default: build/docs); the start page is html/index.html there",
    )  # fmt: skip
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
