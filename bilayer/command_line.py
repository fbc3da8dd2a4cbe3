"""The command `bilayer`: its verbs, and how errors and progress reach a person.

Tables go to stdout, progress and errors to stderr. Exit status 2 is bad input, 1 a computation
that failed or stopped early, 0 success.
"""

import argparse
import contextlib
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from bilayer.comparison import compare, comparison_table
from bilayer.conversion import convert_milestones, convert_result
from bilayer.errors import BilayerError, InputError
from bilayer.figures import draw_comparison, draw_mesh, draw_shapes, save_figure
from bilayer.mesh_generation import generate_mesh
from bilayer.output_file import check_writable
from bilayer.planar_mesh import PlanarMesh, read_planar_mesh, write_planar_mesh
from bilayer.progress import progress_bar
from bilayer.report import provenance, result_table
from bilayer.result import open_result, write_result
from bilayer.settings import describe, settings_from, split_solver_settings
from bilayer.solvers import SOLVERS, settings_kind, solve, solver_package
from bilayer.specimen import Specimen
from bilayer.specimen_file import read_specimen, template
from bilayer.version import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return the exit status.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after `bilayer`; those of the process where left out.
    """
    options = _parser().parse_args(arguments)
    try:
        status = options.run(options)
        sys.stdout.flush()
        return status
    except BilayerError as error:
        return _fail(error, options, 2 if isinstance(error, InputError) else 1)
    except MemoryError as error:
        return _fail(error, options, 1)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader of our stdout has gone, as in `bilayer init | head -3`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # of stdout, as on a full disk
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123  # what is buffered has nowhere to go
        return _fail(error, options, 1)
    except Exception:
        traceback.print_exc()
        _abort_other_ranks()
        return 1


def _fail(error: BaseException, options: argparse.Namespace, status: int) -> int:
    if options.verbose:
        traceback.print_exc()
    if _is_first_rank():
        text = " ".join(str(error).split()) or type(error).__name__
        print(f"bilayer: error: {text}", file=sys.stderr)
    return status


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and whose epilog may be computed when it is asked for."""

    late_epilog: Callable[[], str] | None = None

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")

    def format_help(self) -> str:
        if self.late_epilog is not None:
            self.epilog = f"{self.epilog}\n\n{self.late_epilog()}"
            self.late_epilog = None
        return super().format_help()


def _parser() -> _Parser:
    parser = _Parser(
        prog="bilayer",
        description="The 3D shape that a flat kirigami bilayer takes on release.",
        epilog="example:\n  bilayer init > specimen.toml\n"
        "  bilayer solve specimen.toml --solver dshell -o shell.nc",
    )
    parser.add_argument("--version", action="version", version=f"bilayer {__version__}")
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for add in (_add_init, _add_mesh, _add_solve, _add_compare, _add_plot, _add_convert, _add_info):
        add(verbs)
    return parser


def _add_verb(verbs: Any, run: Callable[[Any], int], name: str, text: str, example: str) -> _Parser:
    verb = verbs.add_parser(name, help=text, description=text, epilog=f"example:\n  {example}")
    verb.add_argument("--quiet", action="store_true", help="no progress, no table")
    verb.add_argument("--verbose", action="store_true", help="settings in use, traces of errors")
    verb.set_defaults(run=run)
    return verb


def _add_init(verbs: Any) -> None:
    _add_verb(
        verbs, _init, "init", "print the paper's specimen as a commented template",
        "bilayer init > specimen.toml",
    )  # fmt: skip


def _init(options: argparse.Namespace) -> int:
    print(template(), end="")
    return 0


def _add_specimen(verb: _Parser) -> None:
    verb.add_argument("specimen", help="the specimen's TOML file")
    verb.add_argument("--mesh-size", metavar="M", help="edge length of the planar mesh, m")
    verb.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="replace one value of the specimen, as in --set substrate.thickness=0.0008",
    )  # fmt: skip


def _specimen(options: argparse.Namespace, overrides: list[str]) -> Specimen:
    if options.mesh_size is not None:
        overrides = [*overrides, f"mesh.size={options.mesh_size}"]
    return read_specimen(options.specimen, overrides)


def _add_mesh(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _mesh, "mesh", "mesh the flat disc; write the mesh, and its picture beside it",
        "bilayer mesh specimen.toml -o mesh.msh",
    )  # fmt: skip
    _add_specimen(verb)
    verb.add_argument(
        "-o", "--output", required=True, help="any format meshio writes, by the ending"
    )


def _mesh(options: argparse.Namespace) -> int:
    output = Path(options.output)
    check_writable(output)
    mesh = generate_mesh(_specimen(options, options.overrides))
    write_planar_mesh(mesh, output)
    save_figure(draw_mesh(mesh), output.with_suffix(".png"))
    if not options.quiet:
        print(
            f"{len(mesh.points)} nodes, {len(mesh.triangles)} triangles, "
            f"{int((mesh.region == 1).sum())} of them kirigami"
        )
    return 0


def _add_solve(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _solve, "solve", "compute the released shapes; write them as NetCDF",
        "bilayer solve specimen.toml --solver fenics -o fenics.nc --prestretch 1.03 1.06\n"
        "  mpirun -n 2 bilayer solve specimen.toml --solver fenics -o fenics.nc",
    )  # fmt: skip
    _add_specimen(verb)
    verb.add_argument("--solver", required=True, choices=list(SOLVERS))
    verb.add_argument("--model", help="one of the solver's models, listed below")
    verb.add_argument("-o", "--output", required=True, metavar="FILE.nc")
    verb.add_argument(
        "--prestretch", nargs="+", metavar="L",
        help="milestones instead of the file's; L, or LX,LY for two directions",
    )  # fmt: skip
    verb.add_argument("--mesh", metavar="FILE", help="a planar mesh instead of a generated one")
    verb.add_argument(
        "--start", metavar="FILE.nc", help="a result on the same mesh whose shape starts the run"
    )
    verb.late_epilog = _describe_settings


def _describe_settings() -> str:
    lines = ["settings of the solvers, changed by --set solver.NAME=VALUE:"]
    for name in SOLVERS:
        for model, kind in solver_package(name).MODELS.items():
            lines += [f"\n--solver {name} --model {model}", describe(kind)]
    return "\n".join(lines)


def _solve(options: argparse.Namespace) -> int:
    _join_mpi()
    first = _is_first_rank()
    if not (first or solver_package(options.solver).PARALLEL):
        return 0  # the first rank computes alone
    check_writable(Path(options.output))
    values, overrides = split_solver_settings(options.overrides)
    specimen = _specimen(options, overrides)
    if options.prestretch is not None:
        specimen = specimen.with_milestones([_milestone(word) for word in options.prestretch])
    settings: Any = settings_from(settings_kind(options.solver, options.model), values)
    mesh = None if options.mesh is None else _mesh_of(specimen, options.mesh)
    start = None if options.start is None else open_result(options.start)
    if options.verbose and first:
        print(settings, file=sys.stderr)
    with progress_bar(options.solver, shown=first and not options.quiet) as progress:
        result = solve(
            specimen, options.solver, settings, mesh=mesh, start=start, progress=progress
        )
    if first:
        write_result(result, options.output)
        if not options.quiet:
            print(result_table(result))
    return _status_of(result, settings, told=first)


def _milestone(word: str) -> Any:
    """Read L or LX,LY."""
    try:
        numbers = tuple(float(part) for part in word.split(","))
    except ValueError:
        raise InputError(f"--prestretch {word}: expected a number, or two as LX,LY") from None
    return numbers[0] if len(numbers) == 1 else numbers


def _mesh_of(specimen: Specimen, path: str) -> PlanarMesh:
    """Read a mesh and check that it is as large as the specimen."""
    mesh = read_planar_mesh(path)
    radius = float((mesh.points**2).sum(axis=1).max() ** 0.5)
    if abs(radius - specimen.outer_radius) > 1e-3 * specimen.outer_radius:
        raise InputError(
            f"mesh file {path}: its outermost node lies at {radius:g} m, expected "
            f"specimen.outer_radius = {specimen.outer_radius} m"
        )
    return mesh


def _status_of(result: Any, settings: Any, told: bool) -> int:
    """Return 1 for a run that stopped early, unless stopping is one of the model's results."""
    if bool(result["converged"].all()):
        return 0
    if told:
        print(f"bilayer: stopped early: {result.attrs['stop_reason']}", file=sys.stderr)
    return 0 if getattr(settings, "stopping_is_a_result", False) else 1


def _add_compare(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _compare, "compare", "compare two results on the same planar mesh",
        "bilayer compare fenics.nc shell.nc -o comparison.png",
    )  # fmt: skip
    verb.add_argument("results", nargs=2, metavar="FILE.nc")
    verb.add_argument("-o", "--output", metavar="FIGURE", help="draw it, too")


def _compare(options: argparse.Namespace) -> int:
    first, second = (open_result(path) for path in options.results)
    comparison = compare(first, second)
    if not options.quiet:
        print(comparison_table(comparison))
    if options.output is not None:
        save_figure(draw_comparison(comparison), options.output)
    return 0


def _add_plot(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _plot, "plot", "draw isometric and bird's-eye views per prestretch",
        "bilayer plot fenics.nc -o shape.png",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc")
    verb.add_argument("-o", "--output", required=True, metavar="FIGURE")


def _plot(options: argparse.Namespace) -> int:
    save_figure(draw_shapes(open_result(options.result)), options.output)
    return 0


def _add_convert(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _convert, "convert", "write the shapes for ParaView and others",
        "bilayer convert result.nc -o shape.vtu",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc")
    verb.add_argument(
        "-o", "--output", required=True, help="any format meshio writes, by the ending"
    )
    which = verb.add_mutually_exclusive_group()
    which.add_argument(
        "--prestretch", type=float, metavar="L",
        help="the milestone to write; the last one reached where left out",
    )  # fmt: skip
    which.add_argument(
        "--all", action="store_true", help="every milestone reached: shape_1.03.vtu, ..."
    )
    verb.add_argument("--part", choices=["midsurface", "volume"], default="midsurface")


def _convert(options: argparse.Namespace) -> int:
    result = open_result(options.result)
    if options.all:
        for path in convert_milestones(result, options.output, options.part):
            print(path)
    else:
        convert_result(result, options.output, options.prestretch, options.part)
    return 0


def _add_info(verbs: Any) -> None:
    verb = _add_verb(
        verbs, _info, "info", "say what made a result, and how far it can be trusted",
        "bilayer info fenics.nc",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc")


def _info(options: argparse.Namespace) -> int:
    print(provenance(open_result(options.result)))
    return 0


def _join_mpi() -> None:
    """Start MPI where it is installed, so that only one of several ranks speaks and writes."""
    with contextlib.suppress(ImportError):
        import mpi4py.MPI  # noqa: F401


def _is_first_rank() -> bool:
    """Whether this process is the one that speaks and writes: rank 0, or alone."""
    return _world_rank() == 0


def _world_rank() -> int:
    communicator = _communicator()
    return 0 if communicator is None else communicator.Get_rank()


def _communicator() -> Any:
    """Return COMM_WORLD where MPI is in use in this process, else None."""
    mpi = sys.modules.get("mpi4py.MPI")
    return None if mpi is None else mpi.COMM_WORLD


def _abort_other_ranks() -> None:
    """End the ranks that would wait for ever for one that met an unexpected error."""
    communicator = _communicator()
    if communicator is not None and communicator.Get_size() > 1:
        communicator.Abort(1)
