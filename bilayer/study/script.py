"""A script that starts a study: the processes that compute its cases import it, too.

They need what it defines, such as a law of its own. A script that calls `run_study` without
`if __name__ == "__main__":` would start the study again in each of them.
"""

import multiprocessing
import os
import sys
from pathlib import Path

from bilayer.errors import InputError
from bilayer.runtime.system import process_context

STARTS_A_STUDY = 97
"""Exit status of a process whose import of the script has started a study."""


def end_if_imported_by_a_worker() -> None:
    """End this process if it is one that imports the script, and does not run it."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        os._exit(STARTS_A_STUDY)  # an exception would print its trace


def check_script() -> None:
    """Raise InputError if a process that imports the script would start the study again."""
    file = getattr(sys.modules["__main__"], "__file__", None)
    if file is None or getattr(sys.modules["__main__"], "__spec__", None) is not None:
        return  # an interpreter, a notebook or `python -m`: nothing is run again
    probe = process_context().Process(target=_do_nothing)  # type: ignore[attr-defined]
    probe.start()
    probe.join()
    if probe.exitcode == STARTS_A_STUDY:
        raise InputError(
            f"{Path(file).name}: run_study is called when the script is imported, expected it "
            'under if __name__ == "__main__": the processes of a study import the script'
        )


def _do_nothing() -> None:
    return None
