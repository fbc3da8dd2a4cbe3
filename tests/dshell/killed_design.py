"""A small design in a process that can be killed: `python3 killed_design.py FOLDER`.

It says "ready" once everything is loaded, before the first shape.
"""

import sys
from pathlib import Path

from designing_task import small_task

from bilayer import design
from bilayer.designing import targets
from bilayer.designing.equilibria import find_shape  # noqa: F401  loads what the search needs

NODES = 150

if __name__ == "__main__":
    targets.NODES = NODES
    task = small_task()
    print("ready", flush=True)
    design(task, Path(sys.argv[1]))
