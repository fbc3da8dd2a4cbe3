"""`python -m bilayer`: the command line."""

import sys

from bilayer.cli.main import main

sys.exit(main())
