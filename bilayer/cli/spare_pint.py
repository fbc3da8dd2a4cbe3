"""xarray without pint, in a process of the command line.

To make an index xarray asks whether it is given one of pint's arrays, and loads pint for that: a
third of a second. The command line has none. Only xarray is told so, and no one else: units in a
specimen file still load pint. A program that uses this package as a library is left as it is.
"""

import sys


def spare_pint() -> None:
    """Let xarray, if it is loaded, take pint for missing; do nothing if its internals differ."""
    if "xarray" not in sys.modules or "pint" in sys.modules:
        return
    try:
        from xarray.namedarray.pycompat import array_type
    except ImportError:
        return
    sys.modules["pint"] = None  # type: ignore[assignment]  # so an import of it fails
    try:
        array_type("pint")  # xarray keeps the answer
    finally:
        del sys.modules["pint"]
