"""xarray without pint and dask, in a process of the command line.

To make an index xarray asks whether it is given one of pint's arrays, and loads pint for that: a
third of a second. The command line has none. Only xarray is told so, and no one else: units in a
specimen file still load pint. A program that uses this package as a library is left as it is.

For the same question xarray loads dask, a tenth of a second. Only the verbs of studies have arrays
of dask.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

WITH_DASK = ("study", "plot-study")
"""The verbs that open many files as one dataset."""


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


@contextmanager
def spared_dask(verb: str) -> Iterator[None]:
    """Let xarray, if it is loaded inside for the first time, take dask for missing.

    Parameters
    ----------
    verb : str
        Which one is loaded inside; those of `WITH_DASK` spare nothing.
    """
    if verb in WITH_DASK or "xarray" in sys.modules or "dask" in sys.modules:
        yield
        return
    sys.modules["dask"] = None  # type: ignore[assignment]  # so it is not found
    try:
        yield
    finally:
        del sys.modules["dask"]
