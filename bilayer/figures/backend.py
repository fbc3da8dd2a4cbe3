"""matplotlib, loaded without the settings of the environment that a figure is drawn in.

A notebook sets MPLBACKEND for all that it starts, and what is named there may be missing here;
a figure of this project is drawn by FigureCanvasAgg, in the style of `bilayer.figures.style`. The
module is imported before any other of this package.
"""

import logging
import os
import sys
from contextlib import suppress

from bilayer.errors import ComputationError

_SETTINGS = ("MPLBACKEND", "MATPLOTLIBRC")


def load_matplotlib() -> None:
    """Load matplotlib; a backend of the environment that it knows stays chosen for the user.

    Raises
    ------
    ComputationError
        It cannot be loaded: a file `matplotlibrc` in the current folder is not readable, ...
    """
    if "matplotlib" in sys.modules:
        return
    hidden = {name: os.environ.pop(name) for name in _SETTINGS if name in os.environ}
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.ERROR)  # it warns of a home folder that cannot be written
    try:
        import matplotlib.font_manager

        matplotlib.get_configdir()
    except Exception as error:  # whatever its own reader of settings meets
        raise ComputationError(
            f"matplotlib cannot be loaded ({type(error).__name__}: {error}); expected a "
            "matplotlibrc that it can read, in the current folder or in its own of the home folder"
        ) from error
    finally:
        log.setLevel(level)
        os.environ.update(hidden)
    if backend := hidden.get("MPLBACKEND"):
        with suppress(ValueError, ImportError):
            matplotlib.rcParams["backend"] = backend


load_matplotlib()
