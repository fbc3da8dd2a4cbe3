"""The verbs of the command line, a module each: `add` its arguments, `run` it."""

from bilayer.cli import (
    compare,
    convert,
    export,
    import_,
    info,
    init,
    mesh,
    plot,
    plot_study,
    rerun,
    solve,
    study,
)

VERBS = (init, mesh, solve, compare, plot, convert, export, import_, info, study, plot_study, rerun)

__all__ = ["VERBS"]
