"""`python -m bilayer`: the command line."""

import sys

from bilayer.command_line import main

sys.exit(main())
