"""The verb `solve`: the released shapes of a specimen, by one of the solvers or by both."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.cli.outputs import check_output, output_beside
from bilayer.cli.parser import add_json_argument, add_verb
from bilayer.cli.specimen_arguments import (
    add_case_arguments,
    add_specimen_arguments,
    read_mesh_argument,
    read_specimen_argument,
)
from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.results.records import comparison_record, result_record
from bilayer.results.report import describe_lower_states, result_table, table_warnings
from bilayer.results.schema import NOT_MEASURED
from bilayer.runtime.output_file import remove_leftovers
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank, join_mpi
from bilayer.runtime.terminal import say, say_json, tell
from bilayer.runtime.time_limit import read_duration
from bilayer.solvers.registry import SOLVERS, STARTS, settings_class, solve, solver_named
from bilayer.specimen.settings import settings_from, split_solver_settings
from bilayer.specimen.specimen import Specimen

BOTH = "both"
IN_TURN = ("dshell", "fenics")
"""The solvers of "both", the quick one first."""


@dataclass(frozen=True)
class _Run:
    """One solver on the specimen of the command line, and the files that it writes."""

    solver: str
    settings: Any
    output: Path

    @property
    def picture(self) -> Path:
        return self.output.with_suffix(".png")


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "solve",
        "bilayer solve specimen.toml\n"
        "  bilayer solve specimen.toml --solver fenics -o fenics.nc --prestretch 1.03 1.06\n"
        "  bilayer solve specimen.toml --solver both --plot\n"
        "  mpirun -n 2 bilayer solve specimen.toml --solver fenics -o fenics.nc",
    )  # fmt: skip
    add_specimen_arguments(verb)
    verb.add_argument(
        "--solver", choices=[*SOLVERS, BOTH], default="dshell",
        help="'dshell': the discrete shell, seconds (the default); 'fenics': the finite-element "
        "model, minutes; 'both': one after the other, and the comparison",
    )  # fmt: skip
    verb.add_argument(
        "--model", help="one of the solver's models; `bilayer settings` lists them"
    ).completer = lambda **_: [  # type: ignore[attr-defined]
        model for name in SOLVERS for model in solver_named(name).models
    ]
    verb.add_argument(
        "-o", "--output", metavar="FILE.nc",
        help="the result (default: SPECIMEN.nc beside the specimen's file); with --solver both "
        "FILE_dshell.nc and FILE_fenics.nc",
    )  # fmt: skip
    verb.add_argument(
        "--overwrite", action="store_true",
        help="if -o is left out: replace the result that is there",
    )  # fmt: skip
    verb.add_argument(
        "--resume", action="store_true",
        help="go on from FILE.nc if it is there: it has every milestone that an interrupted or "
        "killed run had reached",
    )  # fmt: skip
    verb.add_argument(
        "--plot", action="store_true", help="also draw the shapes: FILE.png beside FILE.nc"
    )
    add_case_arguments(verb)
    verb.add_argument(
        "--limit", metavar="TIME",
        help="most time for a milestone, such as 90s, 5min or 2h; the run ends at one that takes "
        "longer and keeps those before it, --resume goes on",
    )  # fmt: skip
    verb.add_argument(
        "--start", metavar="START",
        help="initial guess: 'shell' = shapes of the morley shell (the default of fenics); "
        "'flat' = none, increase the prestretch from zero (a fine mesh of the shell then starts "
        "from a coarse one, see solver.coarse_triangles); FILE.nc = shapes of another result on "
        "the same mesh",
    )  # fmt: skip
    verb.add_argument(
        "--start-state", type=int, metavar="K",
        help="of --start FILE.nc, a file of `bilayer states`: its state K instead of the lowest",
    )  # fmt: skip
    verb.add_argument(
        "--look-below", type=int, metavar="N",
        help="look for lower states by N starts of the shell at each milestone; the file and "
        "`bilayer info` say how far the lowest lies below",
    )  # fmt: skip
    verb.add_argument(
        "--lowest", type=int, metavar="N",
        help="at each milestone, take the lowest state that the load path and N starts of the "
        "shell find (of dshell; left out: the state that the load path comes to)",
    )  # fmt: skip
    add_json_argument(verb)
    verb.epilog = (
        f"{verb.epilog}\n\n`bilayer settings` lists what --set solver.NAME=VALUE can change."
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    join_mpi()
    first = is_first_rank()
    solvers = IN_TURN if options.solver == BOTH else (options.solver,)
    if not (first or any(solver_named(name).parallel for name in solvers)):
        return 0  # the first rank computes alone
    values, overrides = split_solver_settings(options.overrides)
    if "model" in values:
        raise InputError(f"solver.model = {values['model']}: expected as --model, not by --set")
    specimen = read_specimen_argument(options, overrides)  # a slip in its name is told first
    runs = _planned(options, solvers, values)
    mesh = None if options.mesh is None else read_mesh_argument(options, specimen)
    start = _start_argument(options)
    results, status = [], 0
    for one in runs:
        if first or solver_named(one.solver).parallel:
            results.append(_solved(one, options, specimen, mesh, start))
            status = max(status, _status_of(results[-1], one.settings, told=first))
    if first:
        if options.lowest is not None:
            results = [_take_lowest(runs[0], results[0], options)]
        if options.look_below is not None:
            results = [
                _look_below(one, result, options) for one, result in zip(runs, results, strict=True)
            ]
        _show(results, options)
        if options.plot:
            _draw(runs, results)
    return status


def _planned(
    options: argparse.Namespace, solvers: Sequence[str], values: dict[str, str]
) -> list[_Run]:
    """Return what is to be run; raise InputError unless every output of it can be written."""
    if options.solver == BOTH and (values or options.model or options.start):
        raise InputError(
            "--solver both: expected neither --model, --start nor --set solver.NAME, which are of "
            "one solver"
        )
    if options.lowest is not None and tuple(solvers) != ("dshell",):
        raise InputError(
            f"--lowest {options.lowest}: expected with --solver dshell alone; start the other "
            "solver from its result by --start"
        )
    output = output_beside(options, options.specimen, ".nc")
    names = [output]
    if options.solver == BOTH:
        names = [output.with_stem(f"{output.stem}_{solver}") for solver in solvers]
    check_output(options, check_result_output, names)
    runs = [
        _Run(solver, settings_from(settings_class(solver, options.model), values), name)
        for solver, name in zip(solvers, names, strict=True)
    ]
    if options.plot:
        from bilayer.figures.saving import check_figure_output  # matplotlib takes half a second

        check_output(options, check_figure_output, [one.picture for one in runs])
    return runs


def _solved(
    one: _Run, options: argparse.Namespace, specimen: Specimen, mesh: PlanarMesh | None, start: Any
) -> xr.Dataset:
    first = is_first_rank()
    if options.verbose and first:
        tell(one.settings)
    if options.resume and first:
        remove_leftovers(one.output)
    with progress_bar(one.solver, shown=first and not options.quiet) as progress:
        return solve(
            specimen,
            one.solver,
            one.settings,
            mesh=mesh,
            start=start,
            progress=progress,
            output=one.output,
            resume=one.output if options.resume and one.output.exists() else None,
            limit=None if options.limit is None else read_duration("--limit", options.limit),
        )


def _take_lowest(one: _Run, result: xr.Dataset, options: argparse.Namespace) -> xr.Dataset:
    """Return a result in its lowest states, which is written."""
    from bilayer.landscape.lowest import take_lowest  # what it loads is seldom needed

    with progress_bar("lowest states", shown=not options.quiet) as progress:
        lowest = take_lowest(result, starts=options.lowest, progress=progress)
    write_result(lowest, one.output)
    if not options.quiet:
        tell(f"bilayer: branch: {lowest.attrs['branch']}")
    return lowest


def _look_below(one: _Run, result: xr.Dataset, options: argparse.Namespace) -> xr.Dataset:
    """Return a result that says where a lower state is known, which is written."""
    from bilayer.landscape.lower import look_below  # what it loads is seldom needed

    with progress_bar("look below", shown=not options.quiet) as progress:
        looked = look_below(result, starts=options.look_below, progress=progress)
    write_result(looked, one.output)
    if not options.quiet:
        tell(f"bilayer: {' '.join(describe_lower_states(looked))}")
    return looked


def _show(results: Sequence[xr.Dataset], options: argparse.Namespace) -> None:
    """Print the table of each result, and of the comparison if there are two."""
    if options.json:
        say_json(_record(results))
    elif not options.quiet:
        from bilayer.results.comparison import compare, comparison_table

        for result in results:
            say("\n".join([result_table(result), *table_warnings(result)]))
        if len(results) == 2:
            say(f"\n{comparison_table(compare(*results))}")


def _record(results: Sequence[xr.Dataset]) -> dict[str, Any]:
    from bilayer.results.comparison import compare

    records = [result_record(result) for result in results]
    if len(results) == 1:
        return records[0]
    return {"results": records, "comparison": comparison_record(compare(*results))}


def _draw(runs: Sequence[_Run], results: Sequence[xr.Dataset]) -> None:
    from bilayer.figures import draw_shapes, save_figure  # matplotlib takes half a second

    for one, result in zip(runs, results, strict=True):
        save_figure(draw_shapes(result), one.picture)


def _start_argument(options: argparse.Namespace) -> Any:
    """Return the start by its name, or the result, or one state of it."""
    number = options.start_state
    if options.start in (None, *STARTS):
        if number is not None:
            raise InputError(f"--start-state {number}: expected with --start FILE.nc alone")
        return options.start
    start = open_result(options.start)
    if number is None:
        return start
    count = start.sizes["prestretch"]
    if not 0 <= number < count:
        raise InputError(f"--start-state {number}: expected a number from 0 to {count - 1}")
    return start.isel(prestretch=[number])


def _status_of(result: Any, settings: Any, told: bool) -> int:
    """Return 1 for a run that stopped early, unless stopping is one of the model's results."""
    if told and NOT_MEASURED in result.attrs:
        tell(f"bilayer: not measured: {result.attrs[NOT_MEASURED]}")
    if bool(result["converged"].all()):
        return 0
    if told:
        tell(f"bilayer: stopped early: {result.attrs['stop_reason']}")
    return 0 if getattr(settings, "stopping_is_a_result", False) else 1
