"""The packages that read and write drawings; they are installed by those who have drawings."""

from importlib import import_module
from typing import Any

from bilayer.errors import ComputationError


def package(name: str) -> Any:
    """Return a module that reads or writes drawings; raise ComputationError without it."""
    try:
        return import_module(name)
    except ImportError as error:
        top = name.partition(".")[0]
        raise ComputationError(
            f"drawings need the package {top} ({error}); expected it to be installed "
            f"(pip install {top})"
        ) from error
