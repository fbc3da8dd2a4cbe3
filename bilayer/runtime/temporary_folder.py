"""The folder for temporary files: one that is there, and whose path is short enough.

MPI ends in a segmentation violation if `TMPDIR` is gone, as in a shell that outlived its batch job.
The processes of a study meet at a socket in it, whose path may have no more than about a hundred
bytes.
"""

import os
import tempfile
from pathlib import Path

from bilayer.runtime.terminal import tell

VARIABLES = ("TMPDIR", "TEMP", "TMP")
LONGEST_FOR_SOCKETS = 60
"""Bytes of its path: a socket's has 104 on macOS and 108 on Linux, with 40 for its own name."""
LONGEST = 3000


def take_usable_temporary_folder(longest: int = LONGEST) -> None:
    """Forget a temporary folder that does not serve, for this process and its own, and say so.

    Python's own choice is taken instead: /tmp, /var/tmp or the current folder. If none of these
    serves better, all stays as it is.

    Parameters
    ----------
    longest : int
        Bytes that its path may have.
    """
    given = {name: os.environ[name] for name in VARIABLES if name in os.environ}
    wrong = {name: fault for name, folder in given.items() if (fault := _fault_of(folder, longest))}
    if not wrong:
        return
    for name in wrong:
        del os.environ[name]
    tempfile.tempdir = None  # else it keeps the one that it has found
    try:
        found = tempfile.gettempdir()
    except OSError:
        found = ""
    if not found or _fault_of(found, longest):
        os.environ.update({name: given[name] for name in wrong})
        return
    for name, fault in wrong.items():
        tell(f"bilayer: {name} = {given[name]}: {fault}; {found} is taken")


def _fault_of(folder: str, longest: int) -> str:
    """Return what keeps a folder from being used, or an empty text."""
    if not folder or not Path(folder).is_dir():
        return "is no folder"
    try:
        with tempfile.TemporaryFile(dir=folder):  # root may write everywhere, and not in /proc
            pass
    except OSError:
        return "cannot be written"
    if len(os.fsencode(folder)) > longest:
        return "is too long a path for the sockets of processes"
    return ""
