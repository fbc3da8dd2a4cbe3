"""The code blocks of a page, and running them as a reader would, in an empty folder.

Blocks of bash and TOML are taken in their order: a TOML block becomes the file that its first line
names. Python blocks of a page are one script, run after them. Two comments in a page, which no
reader sees, say more: `<!-- not run: WHY -->` before a block, and `<!-- before: COMMANDS -->` for
what the reader has done before (`checkout` is the repository).
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from documentation.staging import CHECKOUT

BLOCK = re.compile(
    r"<!-- before:\s(?P<before>.*?)\s-->"
    r"|(?P<skipped><!-- not run: .*? -->\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)
FILE_NAME = re.compile(r"# ([\w.-]+\.(?:toml|csv))\n")
COMMANDS = re.compile(r"^(?:    [^\n]*\n)+|^```bash\n.*?^```$", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^ *(?:scripts/)?bilayer +(.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A code block of a page.

    Parameters
    ----------
    language : str
        As it is written behind the fence; "bash" for what goes before.
    text : str
        Its lines.
    run : bool
        Whether a reader of the page can run it here.
    """

    language: str
    text: str
    run: bool = True


def blocks_of(page: str) -> Iterator[Block]:
    """Yield the fenced blocks of a page that have a language, in their order."""
    for found in BLOCK.finditer(page):
        if found["before"] is not None:
            yield Block("bash", found["before"] + "\n")
        else:
            yield Block(found["language"], found["text"], run=found["skipped"] is None)


def shell_script(page: str) -> str:
    """Return what a page lets its reader do, as one script of bash."""
    lines = ["set -euo pipefail\n"]
    python = []
    for block in blocks_of(page):
        named = FILE_NAME.match(block.text)
        if not block.run:
            continue
        if block.language == "bash":
            lines.append(block.text)
        elif block.language == "python":
            python.append(block.text)
        elif block.language in ("toml", "text") and named:
            lines.append(_written(named[1], block.text))
    if python:
        lines.append(_written("page.py", "\n".join(python)) + f"{sys.executable} page.py\n")
    return "".join(lines)


def _written(name: str, text: str) -> str:
    return f"cat > {name} <<'END OF {name}'\n{text}END OF {name}\n"


def run_page(page: Path) -> str:
    """Run the blocks of a page; return what went wrong, or nothing."""
    with TemporaryDirectory() as folder:
        for name in ("scripts", "checkout"):
            Path(folder, name).symlink_to(CHECKOUT / name if name == "scripts" else CHECKOUT)
        paths = [str(CHECKOUT / "scripts"), os.environ["PATH"]]
        environment = {
            **os.environ, "PATH": os.pathsep.join(paths), "PYTHONPATH": str(CHECKOUT),
        }  # fmt: skip
        done = subprocess.run(
            ["bash", "-x", "-c", shell_script(page.read_text(encoding="utf-8"))],
            cwd=folder, env=environment, capture_output=True, text=True,
        )  # fmt: skip
    return "" if done.returncode == 0 else done.stdout[-2000:] + done.stderr[-3000:]


def commands_of(page: str) -> Iterator[str]:
    """Yield the words behind `bilayer` of each command that a page shows."""
    page = re.sub(r"^```\n.*?^```$", "", page, flags=re.DOTALL | re.MULTILINE)  # no commands
    joined = re.sub(r" *\\\n *", " ", page)
    for block in re.findall(
        r"^(?:    [^\n]*\n)+|^```bash\n.*?^```$", joined, re.DOTALL | re.MULTILINE
    ):
        for words in COMMAND.findall(block):
            yield re.sub(r"  +#.*| +# .*|[;>|].*", "", words).strip()
