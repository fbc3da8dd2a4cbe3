"""The versions that made a result: of this package, its commit, and its libraries."""

import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path

__version__ = "1.0.0"

COMMIT_FILE = Path(__file__).parents[1] / "COMMIT"
"""Written if the package is installed without its repository, as in the Docker image."""

MAKERS = (".", ":(exclude)results")
"""Whose changes count: `scripts/reproduce` writes into results/, which makes nothing else."""


def git_commit() -> str:
    """Return the commit of the checkout that holds this package, or an empty text.

    It ends in "-dirty" if what makes results has been changed since.

    An installed package has no checkout; it may have been told its commit when it was built. If
    the commit cannot be found out, for whatever reason, the text is empty.
    """
    checkout = Path(__file__).parents[2]
    try:
        if COMMIT_FILE.exists():
            return COMMIT_FILE.read_text(encoding="utf-8").strip()
        if not (checkout / ".git").exists():  # another project's repository may be further up
            return ""
        commit = _git(checkout, "describe", "--always")
        changed = _git(checkout, "status", "--porcelain", "--untracked-files=no", "--", *MAKERS)
    except (OSError, UnicodeError, subprocess.SubprocessError):
        return ""
    return f"{commit}-dirty" if changed else commit


def _git(checkout: Path, *words: str) -> str:
    command = ["git", "-C", str(checkout), *words]
    # Git's own variables, set in every hook, name another repository; no lock: nothing is written
    own = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    own["GIT_OPTIONAL_LOCKS"] = "0"
    found = subprocess.run(
        command, capture_output=True, text=True, check=True, timeout=10, env=own
    )  # fmt: skip
    return found.stdout.strip()


def own_versions() -> dict[str, str]:
    """Versions of this package and of what every result needs, as installed."""
    return {"bilayer-shells": __version__, "python": platform.python_version()} | {
        name: found for name in ("numpy", "xarray", "gmsh") if (found := _installed(name))
    }


def _installed(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except Exception:  # the metadata of an installed package may be damaged in any way
        return ""
