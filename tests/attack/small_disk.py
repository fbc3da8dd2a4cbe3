"""The command line on a small disk: `python3 -m attack.small_disk KILOBYTES FOLDER WORDS...`.

The files of the current folder are copied to the disk; what is left on it that is hidden is written
to the file `left` beside the folder.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

PRIVATE = 0x44000
"""MS_REC and MS_PRIVATE of mount(2)."""


def main() -> int:
    size, folder, words = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
    here = Path.cwd()
    os.unshare(os.CLONE_NEWNS)
    library = ctypes.CDLL(None, use_errno=True)
    if library.mount(b"none", b"/", None, PRIVATE, None):
        raise OSError(ctypes.get_errno(), "no mount of one's own")
    options = f"size={size}k".encode()
    if library.mount(b"tmpfs", bytes(folder), b"tmpfs", 0, options):
        raise OSError(ctypes.get_errno(), "no small disk")
    for name in ("s.toml", "study.toml"):
        shutil.copy(here / name, folder)
    (folder / "good.nc").symlink_to(here / "good.nc")
    os.chdir(folder)
    done = subprocess.run([sys.executable, "-P", "-m", "bilayer", *words], check=False)
    hidden = [path.name for path in folder.rglob(".*") if path.is_dir()]
    (here / "left").write_text("\n".join(hidden), encoding="utf-8")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
