"""Compiled forms: kept where it can be done, and compiled as this project says."""

import os
import tempfile

import pytest

from bilayer.errors import MachineError

pytest.importorskip("dolfinx")

import dolfinx.jit
import ffcx.options
import ufl
from mpi4py import MPI

from fenics_model.api import jit
from fenics_model.api.jit import compiled_form, folder_of_forms


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A current folder, home and temporary folder of its own; what is kept from before is not."""
    for found in (folder_of_forms, dolfinx.jit._load_options, ffcx.options._load_options):
        found.cache_clear()
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    yield tmp_path
    for found in (folder_of_forms, dolfinx.jit._load_options, ffcx.options._load_options):
        found.cache_clear()


def test_forms_are_kept_in_the_users_cache(place, monkeypatch):
    assert folder_of_forms() == place / ".cache" / "fenics" / "bilayer-shells"
    folder_of_forms.cache_clear()
    monkeypatch.setenv("XDG_CACHE_HOME", "nonsense")  # to be ignored, as it is relative
    assert folder_of_forms() == place / ".cache" / "fenics" / "bilayer-shells"


def test_a_home_that_cannot_be_written_leaves_a_folder_of_the_users_own(place, monkeypatch):
    monkeypatch.setenv("HOME", "/proc")
    folder = folder_of_forms()
    assert folder.parent == place / "tmp"
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)  # code of others could be in it
    folder_of_forms.cache_clear()
    with pytest.raises(MachineError, match="not this user's alone; set XDG_CACHE_HOME"):
        folder_of_forms()


def test_where_nothing_can_be_written_one_line_says_what_to_set(place, monkeypatch):
    monkeypatch.setenv("HOME", "/proc")
    monkeypatch.setattr(tempfile, "tempdir", "/proc")
    with pytest.raises(MachineError, match="set XDG_CACHE_HOME"):
        folder_of_forms()


def test_options_in_files_of_the_user_have_no_say(place, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(place))
    mesh = dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 1)
    area = 1.0 * ufl.dx(domain=mesh)
    usual = compiled_form(area)
    kept = sorted(path.name for path in (place / "fenics" / "bilayer-shells").iterdir())
    (place / "ffcx_options.json").write_text('{"epsilon": 0.5, "table_rtol": 0.3}')
    (place / "dolfinx_jit_options.json").write_text(
        '{"cffi_extra_compile_args": ["-Ofast"], "cache_dir": "elsewhere"}'
    )
    for found in (dolfinx.jit._load_options, ffcx.options._load_options):
        found.cache_clear()
    assert dolfinx.fem.assemble_scalar(compiled_form(area)) == pytest.approx(1.0)
    assert dolfinx.fem.assemble_scalar(usual) == pytest.approx(1.0)
    assert sorted(path.name for path in (place / "fenics" / "bilayer-shells").iterdir()) == kept
    assert not os.path.exists("elsewhere")  # noqa: PTH110
    (place / "ffcx_options.json").write_text("no JSON")
    ffcx.options._load_options.cache_clear()
    with pytest.raises(MachineError, match=r"ffcx_options\.json"):
        compiled_form(area)


def test_what_a_killed_process_left_half_compiled_is_compiled_anew(place, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(place))
    mesh = dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 1)
    compiled_form(2.0 * ufl.dx(domain=mesh))
    (source,) = folder_of_forms().glob("libffcx_*.c")
    for other in folder_of_forms().glob("libffcx_*"):
        if other != source:
            other.unlink()
    source.write_text("")  # as FFCx begins; it would wait for ten minutes
    monkeypatch.setitem(jit.JIT_OPTIONS, "timeout", 1)
    again = compiled_form(2.0 * ufl.dx(domain=mesh))
    assert dolfinx.fem.assemble_scalar(again) == pytest.approx(2.0)
