"""The verb `solve`: the released shapes of a specimen, by one of the solvers."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.cli.specimen_arguments import (
    add_case_arguments,
    add_specimen_arguments,
    read_mesh_argument,
    read_specimen_argument,
)
from bilayer.errors import InputError
from bilayer.results.files import check_result_output, open_result
from bilayer.results.report import law_warnings, result_table
from bilayer.results.schema import NOT_MEASURED
from bilayer.runtime.output_file import remove_leftovers
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank, join_mpi
from bilayer.runtime.terminal import say, tell
from bilayer.solvers.registry import SOLVERS, STARTS, settings_class, solve, solver_named
from bilayer.specimen.settings import describe, settings_from, split_solver_settings


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "solve",
        "bilayer solve specimen.toml --solver fenics -o fenics.nc --prestretch 1.03 1.06\n"
        "  mpirun -n 2 bilayer solve specimen.toml --solver fenics -o fenics.nc",
    )  # fmt: skip
    add_specimen_arguments(verb)
    verb.add_argument("--solver", required=True, choices=list(SOLVERS))
    verb.add_argument("--model", help="one of the solver's models, listed below")
    verb.add_argument("-o", "--output", required=True, metavar="FILE.nc")
    verb.add_argument(
        "--resume", action="store_true",
        help="go on from FILE.nc if it is there: it has every milestone that an interrupted or "
        "killed run had reached",
    )  # fmt: skip
    add_case_arguments(verb)
    verb.add_argument(
        "--start", metavar="START",
        help="initial guess: 'shell' = shapes of the morley shell (the default of fenics); "
        "'flat' = none, increase the prestretch from zero (a fine mesh of the shell then starts "
        "from a coarse one, see solver.coarse_triangles); FILE.nc = shapes of another result on "
        "the same mesh",
    )  # fmt: skip
    verb.late_epilog = _describe_settings


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    join_mpi()
    first = is_first_rank()
    if not (first or solver_named(options.solver).parallel):
        return 0  # the first rank computes alone
    output = Path(options.output)
    check_output(options, check_result_output)
    values, overrides = split_solver_settings(options.overrides)
    if "model" in values:
        raise InputError(f"solver.model = {values['model']}: expected as --model, not by --set")
    specimen = read_specimen_argument(options, overrides)
    settings: Any = settings_from(settings_class(options.solver, options.model), values)
    mesh = None if options.mesh is None else read_mesh_argument(options, specimen)
    start = options.start if options.start in (None, *STARTS) else open_result(options.start)
    if options.verbose and first:
        tell(settings)
    if options.resume and first:
        remove_leftovers(output)
    with progress_bar(options.solver, shown=first and not options.quiet) as progress:
        result = solve(
            specimen,
            options.solver,
            settings,
            mesh=mesh,
            start=start,
            progress=progress,
            output=output,
            resume=output if options.resume and output.exists() else None,
        )
    if first and not options.quiet:
        say("\n".join([result_table(result), *law_warnings(result)]))
    return _status_of(result, settings, told=first)


def _describe_settings() -> str:
    lines = ["settings of the solvers, changed by --set solver.NAME=VALUE:"]
    for name in SOLVERS:
        for model, kind in solver_named(name).models.items():
            lines += [f"\n--solver {name} --model {model}", describe(kind)]
    return "\n".join(lines)


def _status_of(result: Any, settings: Any, told: bool) -> int:
    """Return 1 for a run that stopped early, unless stopping is one of the model's results."""
    if told and NOT_MEASURED in result.attrs:
        tell(f"bilayer: not measured: {result.attrs[NOT_MEASURED]}")
    if bool(result["converged"].all()):
        return 0
    if told:
        tell(f"bilayer: stopped early: {result.attrs['stop_reason']}")
    return 0 if getattr(settings, "stopping_is_a_result", False) else 1
