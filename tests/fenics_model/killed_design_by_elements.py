"""A design ended by finite elements, to be killed: `python3 THIS_FILE FOLDER`."""

import sys
from pathlib import Path

from designing_by_elements import task_ended_by_elements

from bilayer import design

if __name__ == "__main__":
    design(task_ended_by_elements(), Path(sys.argv[1]))
