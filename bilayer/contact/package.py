"""The package that models contact: whether it is there, and how to get it."""

from importlib.util import find_spec
from typing import Any

from bilayer.errors import ComputationError

PACKAGE = "ipctk"
HOW_TO_INSTALL = "pip install 'bilayer-shells[contact]'"


def contact_is_installed() -> bool:
    """Whether ipctk is there."""
    return find_spec(PACKAGE) is not None


def require_contact() -> Any:
    """Return the module ipctk, or raise ComputationError that says how to install it."""
    if not contact_is_installed():
        raise ComputationError(f"contact needs the package {PACKAGE}: {HOW_TO_INSTALL}")
    import ipctk

    ipctk.set_num_threads(1)
    ipctk.set_logger_level(ipctk.error)  # its warnings are no lines of ours
    return ipctk
