"""The architecture, held by what the modules import: floors, one way, no circle."""

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import bilayer

ROOT = Path(__file__).parents[1]

FLOORS = {
    "bilayer": [
        ["errors"],
        ["validation"],
        ["runtime"],
        ["drawings"],
        ["specimen"],
        ["fitting"],
        ["cutting"],
        ["geometry"],
        ["mesh"],
        ["contact"],
        ["measures"],
        ["results"],
        ["mechanics"],
        ["exports"],
        ["scan"],
        ["solvers"],
        ["landscape"],
        ["calculix"],
        ["figures"],
        ["viewer"],
        ["designing"],
        ["study"],
        ["accessor"],
        ["cli"],
        ["__main__"],
        ["__init__"],
    ],
    "dshell": [
        ["materials"],
        ["energies"],
        ["settings"],
        ["solve"],
        ["models"],
        ["release"],
        ["solver"],
        ["__init__"],
    ],
    "fenics_model": [
        ["plain_options"],
        ["settings"],
        ["api"],
        ["mesh"],
        ["solid"],
        ["contact"],
        ["solve"],
        ["branches"],
        ["path"],
        ["release"],
        ["solver"],
        ["__init__"],
    ],
}
"""From the lowest floor up: a module imports its own floor and those below."""


def modules(package: str) -> Iterator[str]:
    for file in sorted((ROOT / package).rglob("*.py")):
        yield ".".join(file.relative_to(ROOT).with_suffix("").parts)


def imports_of(module: str) -> set[str]:
    """The project's modules that a module imports, also within functions and for types."""
    file = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if is_module(name) else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.split(".")[0] in FLOORS}


def is_module(name: str) -> bool:
    place = ROOT.joinpath(*name.split("."))
    return place.with_suffix(".py").exists() or (place / "__init__.py").exists()


def floor_of(module: str) -> int:
    package, *rest = module.split(".")
    part = rest[0] if rest else "__init__"
    return next(k for k, floor in enumerate(FLOORS[package]) if part in floor)


READS = {
    "open", "read_text", "read_bytes", "loadtxt", "genfromtxt", "fromfile", "read_csv",
    "read_table", "read_excel", "open_dataset", "open_mfdataset", "Dataset", "readfile", "imread",
    "load_mesh",
}  # fmt: skip
"""Names of functions that open a file which they are given by its path."""
OPENERS = {
    "bilayer.runtime.input_file": "the gate itself",
    "bilayer.runtime.terminal": "/dev/null",
    "bilayer.runtime.child_process": "/dev/null",
    "bilayer.runtime.version": "of the installed package",
    "bilayer.runtime.memory": "of the system: the limits of a control group",
    "bilayer.specimen.toml": "of the installed package",
    "bilayer.viewer.page": "of the installed package",
    "bilayer.results.netcdf": "behind the gate",
    "bilayer.results.files": "writes",
    "bilayer.mesh.files": "behind the gate, in a child process",
    "bilayer.drawings.dxf": "behind the gate, in a child process",
    "bilayer.drawings.svg": "behind the gate, in a child process",
    "bilayer.drawings.image": "behind the gate, in a child process",
    "bilayer.study.folder": "its log and locks, whose kind is checked before",
}
"""The modules that call one, and why they may."""


def opening_calls(file: Path) -> set[str]:
    """The names in a module that open files; `xr.Dataset(...)` opens none."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    methods = {
        called.attr
        for called in calls
        if isinstance(called, ast.Attribute)
        and not (isinstance(called.value, ast.Name) and called.value.id in ("xr", "os"))
    }
    functions = {called.id for called in calls if isinstance(called, ast.Name)}
    return (methods & READS) | (functions & {"open"})


@pytest.mark.parametrize("package", FLOORS)
def test_files_are_opened_behind_one_gate(package):
    """A pipe, a device or an address is refused by `bilayer.runtime.input_file` alone."""
    beside = {}
    for module in modules(package):
        found = opening_calls(ROOT.joinpath(*module.split(".")).with_suffix(".py"))
        if found and module not in OPENERS:
            beside[module] = found
    assert beside == {}


@pytest.mark.parametrize("package", FLOORS)
def test_no_import_goes_up(package):
    upward = [
        f"{module} imports {other}"
        for module in modules(package)
        for other in imports_of(module)
        if other.split(".")[0] == package and floor_of(other) > floor_of(module)
    ]
    assert upward == []


def test_no_circle():
    graph = {
        module.removesuffix(".__init__"): imports_of(module) - {module.removesuffix(".__init__")}
        for package in FLOORS
        for module in modules(package)
    }
    lazy = {"bilayer", "bilayer.solvers.registry"}  # they load the solvers when they are asked for
    TopologicalSorter({k: set() if k in lazy else v for k, v in graph.items()}).prepare()


def test_solvers_do_not_know_each_other():
    for one, other in (("dshell", "fenics_model"), ("fenics_model", "dshell")):
        for module in modules(one):
            assert not any(name.split(".")[0] == other for name in imports_of(module)), module


def test_only_the_registry_knows_the_solvers():
    for module in modules("bilayer"):
        if module not in ("bilayer.__init__", "bilayer.solvers.registry"):
            assert all(name.split(".")[0] == "bilayer" for name in imports_of(module)), module


def test_the_face_shows_what_a_user_calls_and_nothing_else():
    assert dir(bilayer) == sorted(bilayer.__all__)
    for name in bilayer.__all__:
        assert getattr(bilayer, name) is not None
