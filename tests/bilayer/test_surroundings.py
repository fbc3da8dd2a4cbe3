"""The user's variables, folders and settings of other programs have no say."""

import os
import pwd
import resource
import subprocess
import sys
import tempfile
import warnings
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from bilayer import open_result
from bilayer.cli.main import main
from bilayer.runtime.surroundings import keep_surroundings_out
from bilayer.runtime.temporary_folder import LONGEST_FOR_SOCKETS, take_usable_temporary_folder
from bilayer.specimen.toml import template

ROOT = Path(__file__).parents[2]

ODD = {
    "PETSC_OPTIONS": "-help -dshell_mat_mumps_icntl_4 3 -log_view",
    "PYTHONWARNINGS": "error",
    "PYTHONOPTIMIZE": "2",
    "OMP_NUM_THREADS": "a few",
    "COLUMNS": "0",
    "TERM": "",
    "LC_ALL": "xx_YY.nonsense",
    "MPLBACKEND": "module://matplotlib_inline.backend_inline",
    "MATPLOTLIBRC": "/nowhere/matplotlibrc",
    "HDF5_DRIVER": "nonsense",
    "HDF5_USE_FILE_LOCKING": "perhaps",
    "TQDM_MININTERVAL": "soon",
    "TMPDIR": "/gone",
    "HOME": "/proc",
    "XDG_CACHE_HOME": "nonsense",
}


def command(*words, cwd, **variables):
    """Run the command line with some variables of the environment set."""
    own = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    return subprocess.run(
        [sys.executable, "-P", "-m", "bilayer", *words],
        cwd=cwd, env=own, capture_output=True, text=True, timeout=120,
    )  # fmt: skip


def test_odd_surroundings_change_no_number_and_stop_no_figure(tmp_path, monkeypatch):
    (tmp_path / "s.toml").write_text(template())
    solve = [
        "solve",
        "s.toml",
        "--solver",
        "dshell",
        "--mesh-size",
        "0.012",
        "--prestretch",
        "1.03",
    ]
    (tmp_path / ".petscrc").write_text("-help\n-nonsense\n")
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nnonsense: 3\n")
    odd = command(*solve, "-o", "odd.nc", cwd=tmp_path, **ODD)
    told = "bilayer: TMPDIR = /gone: is no folder; /tmp is taken\n"
    assert (odd.returncode, odd.stderr) == (0, told)
    at_home = ODD | {"HOME": os.environ["HOME"]}  # where matplotlib has its list of fonts
    drawn = command("plot", "odd.nc", "-o", "odd.svg", cwd=tmp_path, **at_home)
    assert (drawn.returncode, drawn.stderr) == (0, told)
    monkeypatch.chdir(tmp_path)
    assert main([*solve, "-o", "usual.nc"]) == main(["plot", "odd.nc", "-o", "usual.svg"]) == 0
    usual, other = (open_result(name) for name in ("usual.nc", "odd.nc"))
    assert np.array_equal(usual["position"].values, other["position"].values)
    assert (tmp_path / "odd.svg").read_bytes() == (tmp_path / "usual.svg").read_bytes()


def test_variables_that_have_no_say_are_hidden_and_good_ones_stay(monkeypatch):
    for name, value in ODD.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "4")
    with warnings.catch_warnings():
        keep_surroundings_out()
    for name in ("PETSC_OPTIONS", "PYTHONWARNINGS", "MPLBACKEND", "HDF5_DRIVER", "COLUMNS",
                 "HDF5_USE_FILE_LOCKING", "TQDM_MININTERVAL", "OMP_NUM_THREADS"):  # fmt: skip
        assert name not in os.environ
    assert os.environ["OPENBLAS_NUM_THREADS"] == "4"
    assert os.environ["HOME"] == "/proc"


@pytest.fixture
def own_temporary_folder(monkeypatch):
    """Forget what Python found before, and afterwards what it finds in the test."""
    monkeypatch.setattr(tempfile, "tempdir", None)
    return monkeypatch


@pytest.mark.parametrize("make", [None, "file", "long"])
def test_a_temporary_folder_that_does_not_serve_is_told_and_left(
    tmp_path, own_temporary_folder, capsys, make
):
    folder = tmp_path / ("x" * LONGEST_FOR_SOCKETS)
    if make == "file":
        folder.touch()
    elif make == "long":
        folder.mkdir()
    own_temporary_folder.setenv("TMPDIR", str(folder))
    take_usable_temporary_folder(LONGEST_FOR_SOCKETS)
    assert "TMPDIR" not in os.environ
    assert len(tempfile.gettempdir()) < 20
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f"TMPDIR = {folder}: is " in told


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="no folder that not even root writes in")
def test_a_temporary_folder_that_nobody_can_write_in_is_left(own_temporary_folder, capsys):
    own_temporary_folder.setenv("TMPDIR", "/proc")
    take_usable_temporary_folder()
    assert "TMPDIR" not in os.environ
    assert "TMPDIR = /proc: cannot be written; " in capsys.readouterr().err


def test_an_empty_name_of_a_temporary_folder_is_left(own_temporary_folder, capsys):
    own_temporary_folder.setenv("TMPDIR", "")
    take_usable_temporary_folder()
    assert "TMPDIR" not in os.environ
    assert "TMPDIR = : is no folder; " in capsys.readouterr().err


def test_a_temporary_folder_that_serves_is_kept(tmp_path, own_temporary_folder, capsys):
    own_temporary_folder.setenv("TMPDIR", str(tmp_path))
    take_usable_temporary_folder()
    assert os.environ["TMPDIR"] == str(tmp_path)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline", "svg"])
def test_a_backend_of_the_environment_is_kept_if_it_is_one(backend):
    code = "import bilayer.figures, matplotlib; print(matplotlib.rcParams['backend'])"
    own = os.environ | {"MPLBACKEND": backend, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=own, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    if backend == "svg":  # a notebook's user has the backend of the notebook
        assert done.stdout == "svg\n"


@pytest.mark.skipif(not find_spec("petsc4py"), reason="PETSc is not installed")
def test_petsc_does_not_read_the_users_options(tmp_path):
    (tmp_path / ".petscrc").write_text("-from_a_file 1\n")
    code = (
        "from bilayer.runtime.petsc import start_petsc; start_petsc()\n"
        "from petsc4py import PETSc; import os\n"
        "print(PETSc.Options().getAll(), os.environ['PETSC_OPTIONS'])"
    )
    own = os.environ | {"PETSC_OPTIONS": "-from_a_variable 1", "PYTHONPATH": str(ROOT),
                        "HOME": str(tmp_path)}  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=own, capture_output=True, text=True
    )
    assert "from_a" not in done.stdout.split("}")[0]
    assert done.stdout.endswith("-from_a_variable 1\n")


def test_meshing_leaves_nothing_in_the_home_folder(tmp_path):
    (tmp_path / "home").mkdir()
    code = (
        "import os, bilayer; bilayer.generate_mesh(bilayer.paper_specimen()); "
        "print(os.environ['HOME'])"
    )
    own = os.environ | {"HOME": str(tmp_path / "home"), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=own, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == (f"{tmp_path}/home\n", "")
    assert not list((tmp_path / "home").iterdir())


def test_too_few_open_files_are_told_before_a_verb_begins(bilayer_command):
    done = bilayer_command(
        "init", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (40, 40))
    )
    assert done.returncode == 1
    assert done.stderr == (
        "bilayer: error: only 40 files may be open at once here, 64 are needed: ulimit -n 64\n"
    )


def test_without_a_home_folder_named_the_systems_one_is_taken(monkeypatch):
    monkeypatch.delenv("HOME")
    keep_surroundings_out()
    assert os.environ["HOME"] == pwd.getpwuid(os.getuid()).pw_dir
    monkeypatch.delenv("HOME")
    monkeypatch.setattr(Path, "home", raise_no_home)
    keep_surroundings_out()
    assert os.environ["HOME"] == "/"


def raise_no_home():
    """As `Path.home` in a container whose user has no name."""
    raise RuntimeError("Could not determine home directory.")


@pytest.mark.skipif(not find_spec("mpi4py"), reason="MPI is not installed")
def test_a_process_without_others_opens_no_way_to_them(tmp_path):
    """Where a file may have 10 kB, memory shared by ranks cannot be made; nor is there `xyz`."""
    code = (
        "from bilayer.runtime.ranks import join_mpi; join_mpi(); import os\n"
        "print(os.environ['OMPI_MCA_btl'], 'OMPI_MCA_pml' in os.environ)"
    )
    own = {name: value for name, value in os.environ.items() if not name.startswith("OMPI_MCA")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=own | {"OMPI_MCA_btl": "xyz", "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000)),
        capture_output=True,
        text=True,
    )
    assert (done.stdout, done.stderr) == ("xyz False\n", "")
