"""The command `bilayer`, also as `python -m bilayer`: Ctrl-C is heard from the first moment on."""

import sys

from bilayer.cli.interrupted import tell_interruption
from bilayer.runtime.surroundings import keep_surroundings_out
from bilayer.runtime.temporary_folder import take_usable_temporary_folder
from bilayer.runtime.terminal import open_standard_streams, tell
from bilayer.runtime.termination import signals_put_off, termination_as_ctrl_c


def main() -> int:
    """Run one verb and return the exit status.

    What the command line needs takes a second to load. Ctrl-C and SIGTERM wait until it is there,
    because a module that is loaded by half may turn them into another error.
    """
    open_standard_streams()
    keep_surroundings_out()
    take_usable_temporary_folder()
    try:
        with termination_as_ctrl_c():
            with signals_put_off():
                from bilayer.cli.main import main as run_verb
            return run_verb()
    except KeyboardInterrupt as interrupt:
        return tell_interruption(interrupt)
    except (ImportError, MemoryError, OSError) as error:  # a library is not there, or no memory
        tell(f"bilayer: error: {error or type(error).__name__}")
        return 1


if __name__ == "__main__":
    sys.exit(main())
