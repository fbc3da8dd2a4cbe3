"""Files from elsewhere that would run code, open the network, or write where nobody asked to."""

from __future__ import annotations

import random
import socket
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import tomli_w

from attack.attempt import Attempt
from attack.result_structure import Content
from attack.toml_text import document

RUN = (
    "-bilayer_pc_type python -bilayer_pc_python_type canary.Canary",
    "-bilayer_ksp_view ascii:canary",
    "-bilayer_ksp_monitor ascii:canary::append",
    "-bilayer_mat_view binary:canary",
    "-bilayer_ksp_view ascii:s.toml",
    "-bilayer_options_file canary.opts",
    "-options_file canary.opts",
    "-options_file_yaml canary.opts",
    "-log_view :canary",
    "-info canary",
    "-on_error_attach_debugger noxterm,gdb",
    "-start_in_debugger",
    "-dll_append ./canary.so",
    "-malloc_dump",
    "-bilayer_snes_monitor_solution draw",
    "-bilayer_pc_factor_mat_solver_type ./canary.so",
    "-bilayer_ksp_monitor_solution socket:127.0.0.1:1",
    "-bilayer_log_view ascii:/tmp/x",
    "-bilayer_ksp_view http://127.0.0.1:1/x",
    "-bilayer_ksp_type preonly -bilayer_ksp_view ascii:canary",
    "$(touch canary)",
    "`touch canary`",
    "@canary.opts",
    "-bilayer_x {a=1} -bilayer_ksp_view :canary",
    "-prefix_push bilayer_ -ksp_view :canary -prefix_pop",
    "-bilayer_ksp_monitor\t:canary",
    "-BILAYER_ksp_view :canary",
    "-bilayer_ksp_rtol 1e-9\n-bilayer_ksp_view :canary",
)
CODE = "import pathlib\npathlib.Path('canary').write_text('x')\nclass Canary: pass\n"


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for number, options in enumerate(RUN):
        yield from _from_result(bench, number, options)
        yield from _from_study(bench, number, options)
    for setting, value in {
        "model": "canary.Canary",
        "profile": "canary:Canary",
        "method": "__import__('canary')",
        "branch": "!!python/object/apply:os.system ['touch canary']",
    }.items():
        yield _result(
            bench,
            f"dshell {setting} = {value}",
            ("rerun", "r.nc", "--quiet"),
            settings=tomli_w.dumps({setting: value}),
            solver="dshell",
        )
    for solver in ("canary", "os", "../canary", "canary.py", "subprocess", "dshell.solver"):
        yield _result(bench, f"solver = {solver}", ("rerun", "r.nc", "--quiet"), solver=solver)
        text = document({"specimen": "s.toml", "solver": solver})
        yield Attempt(
            "trust",
            f"study: solver = {solver}",
            ("study", "study.toml", "-o", "st", "--quiet", "--case", "1"),
            {"s.toml": bench.specimen, "study.toml": text, "canary.py": CODE},
        )
    yield from _network(bench)


def _result(bench: Any, name: str, words: tuple[str, ...], **attrs: str) -> Attempt:
    def make(path: Path) -> None:
        content = Content(bench.result)
        content.attrs |= attrs
        content.write(path)

    files = {
        "r.nc": make,
        "s.toml": bench.specimen,
        "canary.py": CODE,
        "canary.opts": "-bilayer_ksp_view :canary\n",
    }
    return Attempt("trust", f"{words[0]}: {name}", words, files)


def _from_result(bench: Any, number: int, options: str) -> Iterator[Attempt]:
    settings = tomli_w.dumps({"petsc_options": options})
    yield _result(
        bench,
        f"petsc_options {number} {options[:40]!r}",
        ("rerun", "r.nc", "--quiet"),
        settings=settings,
        solver="fenics",
        model="solid",
    )


def _from_study(bench: Any, number: int, options: str) -> Iterator[Attempt]:
    text = document(
        {
            "specimen": "s.toml",
            "solver": "fenics",
            "settings": {"fenics": {"petsc_options": options}},
        }
    )
    varied = document(
        {
            "specimen": "s.toml",
            "solver": "fenics",
            "vary": {"settings.fenics.petsc_options": [options]},
        }
    )
    for name, content in (("set", text), ("varied", varied)):
        yield Attempt(
            "trust",
            f"study: petsc_options {number} {name} {options[:40]!r}",
            ("study", "study.toml", "-o", "st", "--quiet", "--case", "1"),
            {
                "s.toml": bench.specimen,
                "study.toml": content,
                "canary.py": CODE,
                "canary.opts": "-bilayer_ksp_view :canary\n",
            },
        )


@cache
def _listener() -> socket.socket:
    """Return a socket of this machine that somebody may come to."""
    made = socket.create_server(("127.0.0.1", 0))
    made.setblocking(False)
    return made


def _nobody_came(folder: Path, said: str) -> str:
    try:
        visitor, _ = _listener().accept()
    except BlockingIOError:
        return ""
    visitor.close()
    return "the network was opened"


def _network(bench: Any) -> Iterator[Attempt]:
    """Yield addresses in the place of files."""
    port = _listener().getsockname()[1]
    for scheme in ("http", "https", "ftp", "dap4", "dods", "s3"):
        for end in ("x.nc", "x.nc#mode=bytes", "x.nc#mode=dap4", "x.nc#bytes", "x.nc?y"):
            url = f"{scheme}://127.0.0.1:{port}/{end}"
            for words in (("info", url), ("plot", url, "-o", "a.png")):
                yield _at(bench, f"{words[0]} {scheme} {end}", words)
        url = f"{scheme}://127.0.0.1:{port}/x"
        solve = ("solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--quiet")
        for ending in (".nc", ".msh", ".vtu", ".xdmf"):
            yield _at(bench, f"--mesh {scheme} {ending}", (*solve, "--mesh", url + ending))
        yield _at(bench, f"--start {scheme}", (*solve, "--start", f"{url}.nc"))
        yield _at(
            bench,
            f"-o {scheme}",
            ("solve", "s.toml", "--solver", "dshell", "--quiet", "-o", f"{url}.nc"),
        )
        yield _at(bench, f"specimen {scheme}", ("mesh", f"{url}.toml", "-o", "m.vtu"))
    for word in (
        "file:///etc/passwd",
        "file://s.toml",
        "[log]http://127.0.0.1/x.nc",
        "#mode=bytes",
    ):
        yield _at(bench, f"info {word}", ("info", word))


def _at(bench: Any, name: str, words: tuple[str, ...]) -> Attempt:
    return Attempt("trust", name, words, {"s.toml": bench.specimen}, refused_check=_nobody_came)
