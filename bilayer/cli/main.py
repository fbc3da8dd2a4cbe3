"""The command `bilayer`: its verbs, and the output of errors and progress.

Tables go to stdout, progress and errors to stderr. Exit status 2 is bad input, 1 a computation
that failed or stopped early, 0 success.
"""

import argparse
import errno
import sys
import traceback
from collections.abc import Sequence

from bilayer.cli.completion import complete_words, words_to_complete
from bilayer.cli.interrupted import tell_interruption
from bilayer.cli.outputs import tell_replaced
from bilayer.cli.parser import Parser, main_parser
from bilayer.cli.spared_imports import spare_pint, spared_dask
from bilayer.cli.verbs import VERBS, load_verb
from bilayer.errors import BilayerError, InputError
from bilayer.runtime.ranks import abort_other_ranks, is_first_rank
from bilayer.runtime.surroundings import need_open_files
from bilayer.runtime.terminal import drop_stdout, flush_stdout, tell, tell_lines
from bilayer.runtime.termination import signals_put_off, termination_as_ctrl_c
from bilayer.runtime.version import __version__

OF_A_NAME = (errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EISDIR)
"""Errors of the system that a name has given on the command line."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return the exit status.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after `bilayer`; those of the process if left out.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    options = argparse.Namespace(verbose=False)
    try:
        with termination_as_ctrl_c():
            if (begun := words_to_complete()) is not None:
                return complete_words(_parser(begun))
            options = _parser(words).parse_args(words)
            need_open_files()
            status: int = options.run(options)
            flush_stdout()
            tell_replaced(options)
        return status
    except BilayerError as error:
        return _fail(error, options, 2 if isinstance(error, InputError) else 1)
    except (MemoryError, ImportError) as error:  # of the machine
        return _fail(error, options, 1)
    except KeyboardInterrupt as interrupt:
        return tell_interruption(interrupt)
    except BrokenPipeError:  # the reader of our stdout has gone, as in `bilayer init | head -3`
        drop_stdout()
        return 0
    except OSError as error:
        if error.errno in OF_A_NAME:
            return _fail(error, options, 2)
        drop_stdout()  # as on a full disk
        return _fail(error, options, 1)
    except Exception:
        tell_lines(traceback.format_exc())
        abort_other_ranks()
        return 1


def _fail(error: BaseException, options: argparse.Namespace, status: int) -> int:
    if options.verbose:
        tell_lines(traceback.format_exc())
    if is_first_rank():
        tell(f"bilayer: error: {' '.join(str(error).split()) or type(error).__name__}")
    return status


def _parser(words: Sequence[str]) -> Parser:
    """Return the parser of a command: the verb that it calls has arguments, the others help."""
    called = next((word for word in words if not word.startswith("-")), None)
    parser = main_parser(
        prog="bilayer",
        description="The 3D shape that a flat kirigami bilayer takes on release.",
        epilog="examples:\n  bilayer demo\n  bilayer init > specimen.toml\n"
        "  bilayer solve specimen.toml --plot",
    )
    parser.add_argument("--version", action="version", version=f"bilayer {__version__}")
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for name, text in VERBS.items():
        if name == called:
            with signals_put_off():  # a module that is loaded by half is another error
                with spared_dask(name):
                    verb = load_verb(name)
                spare_pint()
            verb.add(verbs)
        else:
            verbs.add_parser(name, help=text)
    return parser
