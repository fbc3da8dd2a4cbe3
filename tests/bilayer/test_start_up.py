"""What the light verbs load: no library that they do not need."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

import bilayer
from bilayer.cli.verbs import VERBS

ARRAYS = ("numpy",)
DATASETS = ("netCDF4", "pandas", "xarray")
HEAVY = (
    "dask",
    "dshell.release", "fenics_model.release", "dolfinx", "gmsh", "matplotlib", "meshio", "mpi4py",
    "petsc4py", "pint", "scipy.interpolate", "scipy.linalg", "scipy.optimize",
    "scipy.sparse", "scipy.spatial", "tqdm", "ufl",
)  # fmt: skip
"""Libraries, and modules that load many of them."""


def loaded_by(program, *words, folder=None):
    """Return those of the heavy modules that a program loads."""
    end = "import json, sys; print(); print(json.dumps(list(sys.modules)))"
    code = f"{program}\n{end}"
    done = subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=folder, check=True
    )
    modules = set(json.loads(done.stdout.splitlines()[-1]))
    return {name for name in (*HEAVY, *DATASETS, *ARRAYS) if name in modules}


def loaded_by_verb(*words, folder=None):
    program = "from bilayer.__main__ import main\ntry:\n    main()\nexcept SystemExit: pass"
    return loaded_by(program, *words, folder=folder)


def test_the_package_loads_nothing():
    assert loaded_by("import bilayer") == set()


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["no-such-verb"]])
def test_the_bare_command_loads_nothing(words):
    assert loaded_by_verb(*words) == set()


def test_a_template_needs_no_library_of_datasets():
    assert loaded_by_verb("init") <= set(ARRAYS)


@pytest.fixture(scope="module")
def result_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "shell.nc"
    coarse = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.012)).with_milestones([1.03])
    bilayer.write_result(bilayer.solve(coarse, "dshell"), path)
    return path


def test_info_reads_a_result_and_no_more(result_file):
    assert loaded_by_verb("info", str(result_file)) <= {*DATASETS, *ARRAYS}


def test_a_solver_of_shells_draws_nothing(result_file):
    names = "bilayer.solve, bilayer.open_result, bilayer.read_specimen, bilayer.MorleySettings"
    assert loaded_by(f"import bilayer; {names}") <= {*DATASETS, *ARRAYS}


def test_units_are_read_in_a_process_that_spares_xarray_pint(tmp_path):
    (tmp_path / "a.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
    words = ["mesh", "a.toml", "-o", "a.vtu", "--mesh-size", "10 mm", "--quiet"]
    assert "pint" in loaded_by_verb(*words, folder=tmp_path)
    assert (tmp_path / "a.vtu").exists()


def test_the_package_says_what_it_has():
    assert dir(bilayer) == sorted(bilayer.__all__)
    assert all(getattr(bilayer, name) is not None for name in bilayer.__all__)


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_is_there(verb, capsys):
    from bilayer.cli.main import main

    with pytest.raises(SystemExit) as end:
        main([verb, "--help"])
    assert end.value.code == 0
    told = " ".join(capsys.readouterr().out.split())
    assert VERBS[verb] in told
    assert "--verbose" in told
