"""The gate of every output: nothing is lost or replaced that must not be, and nothing computed."""

import os
import shutil
import socket
import stat
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import netCDF4
import pytest
from made_results import cap_result, small_specimen

from bilayer import InputError, open_result, specimen_to_toml, write_planar_mesh, write_result
from bilayer.cli.main import main
from bilayer.mesh.generation import generate_mesh
from bilayer.results.files import check_result_output
from bilayer.runtime.output_file import check_writable, remove_leftovers, whole_file

STUDY = """
specimen = "s.toml"
solver = ["dshell"]

[vary]
"cut.cutout_angle" = [0.2, 0.3]
"""
CSV = "stretch,stress (MPa)\n1.0,0.0\n1.1,0.1\n1.2,0.18\n1.3,0.25\n1.4,0.31\n"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    specimen = small_specimen((1.03, 1.06))
    mesh = generate_mesh(specimen)
    (folder / "s.toml").write_text(specimen_to_toml(specimen))
    (folder / "study.toml").write_text(STUDY)
    (folder / "test.csv").write_text(CSV)
    write_result(cap_result(specimen, mesh=mesh), folder / "r.nc")
    write_planar_mesh(mesh, folder / "m.msh")
    return folder


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """A folder of its own with one file of each kind, in which the command runs."""
    for file in files.iterdir():
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


SOLVE = ["solve", "s.toml", "--solver", "dshell"]
VERBS = {
    "solve": (SOLVE, ".nc"),
    "solve on a mesh": ([*SOLVE, "--mesh", "m.msh"], ".nc"),
    "rerun": (["rerun", "r.nc"], ".nc"),
    "import": (["import", "d.frd", "s.toml"], ".nc"),
    "mesh": (["mesh", "s.toml"], ".msh"),
    "plot": (["plot", "r.nc"], ".png"),
    "compare": (["compare", "r.nc", "r.nc"], ".png"),
    "convert": (["convert", "r.nc"], ".vtu"),
    "export": (["export", "s.toml", "--prestretch", "1.03"], ".inp"),
    "cut": (["cut", "s.toml", "--layer", "kirigami"], ".svg"),
    "fit": (["fit", "test.csv"], ".png"),
    "plot-study": (["plot-study", "study", "--x", "prestretch"], ".png"),
}


def refusal(words, output, capsys):
    """Return the one line by which a verb refuses an output."""
    try:
        assert main([*words, "-o", str(output)]) == 2
    except SystemExit as end:  # of the parser
        assert end.code == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    return lines[0]


def state_of(folder):
    """Return what is in a folder: kind, time and content of each file."""
    found = {}
    for path in folder.rglob("*"):
        info = path.lstat()
        content = path.read_bytes() if stat.S_ISREG(info.st_mode) else os.fspath(path)
        found[path.name] = (stat.S_IFMT(info.st_mode), content)
    return found


@pytest.mark.parametrize("verb", VERBS)
def test_what_is_no_file_is_never_replaced(folder, capsys, verb):
    words, ending = VERBS[verb]
    os.mkfifo(folder / f"fifo{ending}")
    (folder / f"null{ending}").symlink_to("/dev/null")
    (folder / f"folder{ending}").mkdir()
    (folder / f"loop{ending}").symlink_to(f"loop{ending}")
    (folder / f"nowhere{ending}").symlink_to("none/file")
    server = socket.socket(socket.AF_UNIX)
    server.bind(f"socket{ending}")
    before = state_of(folder)
    for name, kind in {
        "fifo": "is a pipe, expected a file name",
        "null": "is a device, expected a file name",
        "socket": "is a socket, expected a file name",
        "folder": "is a folder, expected a file name",
        "loop": "cannot be made (Too many levels of symbolic links)",
        "nowhere": "the folder",
        "none/file": "the folder none does not exist",
        "x" * 300: "cannot be made (File name too long)",
    }.items():
        assert f": {kind}" in refusal(words, f"{name}{ending}", capsys)
    server.close()
    assert state_of(folder) == before


@pytest.mark.parametrize("verb", [*VERBS, "study"])
def test_an_empty_name_is_refused(folder, capsys, verb):
    words, _ = VERBS.get(verb, (["study", "study.toml"], ""))
    before = state_of(folder)
    assert "argument -o/--output: '': expected a word" in refusal(words, "", capsys)
    assert state_of(folder) == before


@pytest.mark.parametrize("verb", VERBS)
def test_the_name_of_a_folder_is_refused(folder, capsys, verb):
    words, ending = VERBS[verb]
    before = state_of(folder)
    assert "ends as a folder, expected a file name" in refusal(words, f"a{ending}/", capsys)
    assert "expected" in refusal(words, " ", capsys)
    assert state_of(folder) == before


@pytest.mark.parametrize("verb", VERBS)
def test_an_ending_of_something_else_is_refused(folder, capsys, verb):
    words, _ = VERBS[verb]
    before = state_of(folder)
    for name in ("a.txt", "a"):
        assert "expected" in refusal(words, name, capsys)
    assert state_of(folder) == before


INPUTS = [
    (SOLVE, "s.toml"),
    ([*SOLVE, "--mesh", "r.nc"], "r.nc"),
    ([*SOLVE, "--mesh", "m.msh"], "m.msh"),
    ([*SOLVE, "--start", "r.nc"], "r.nc"),
    (["rerun", "r.nc"], "r.nc"),
    (["import", "d.frd", "s.toml"], "s.toml"),
    (["import", "s.toml", "study.toml"], "s.toml"),
    (["mesh", "s.toml"], "s.toml"),
    (["plot", "r.nc"], "r.nc"),
    (["compare", "r.nc", "r.nc"], "r.nc"),
    (["convert", "r.nc"], "r.nc"),
    (["export", "s.toml", "--mesh", "m.msh", "--prestretch", "1.03"], "m.msh"),
    (["cut", "s.toml", "--layer", "kirigami"], "s.toml"),
    (["fit", "test.csv"], "test.csv"),
    (["fit", "--planar", "test.csv"], "test.csv"),
]


@pytest.mark.parametrize(("words", "name"), INPUTS)
def test_no_input_is_overwritten_by_whatever_name(folder, capsys, words, name):
    os.link(folder / name, folder / "hard")
    (folder / "soft").symlink_to(name)
    before = state_of(folder)
    for other in (name, f"./{name}", folder / name, "soft", "hard"):
        line = refusal(words, other, capsys)
        assert "is read as the input" in line or line.startswith("bilayer: error: cut file")
    assert state_of(folder) == before


def test_a_drawing_that_the_specimen_names_is_an_input(folder, capsys):
    (folder / "shape.svg").write_text("<svg/>")
    text = (folder / "s.toml").read_text()
    (folder / "s.toml").write_text(text + '\n[patterns.mine]\ndrawing = "shape.svg"\n')
    line = refusal(["mesh", "s.toml"], "shape.svg", capsys)
    assert "shape.svg: is read as the input shape.svg" in line
    assert (folder / "shape.svg").read_text() == "<svg/>"


def test_a_study_knows_the_specimen_that_its_file_names(folder):
    from argparse import Namespace

    from bilayer.cli.outputs import input_files

    named = input_files(Namespace(study="study.toml", output="a", jobs=None, quiet=True))
    assert {path.name for path in named} == {"study.toml", "s.toml"}


def test_one_of_many_names_is_an_input(folder, capsys):
    write_planar_mesh(generate_mesh(small_specimen()), folder / "r_1.03.vtu")
    shutil.copy("r.nc", "r_1.06.vtu")
    os.link("r_1.06.vtu", "link.nc")
    words = ["convert", "link.nc", "--all"]
    assert "r_1.06.vtu: is read as the input link.nc" in refusal(words, "r.vtu", capsys)
    Path("m.msh").rename("deck_1.06.inp")
    words = ["export", "s.toml", "--mesh", "deck_1.06.inp"]
    assert "deck_1.06.inp: is read as" in refusal(words, "deck.inp", capsys)
    assert not (folder / "deck_1.03.inp").exists()


def test_a_symbolic_link_stays_and_what_it_points_at_is_written(folder):
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "real").write_text("keep")
    (folder / "link.vtu").symlink_to("elsewhere/real")
    (folder / "new.vtu").symlink_to("elsewhere/new")
    for name in ("link.vtu", "new.vtu"):
        assert main(["convert", "r.nc", "-o", name]) == 0
        assert (folder / name).is_symlink()
    assert (folder / "elsewhere" / "real").read_bytes().startswith(b"<?xml")
    assert sorted(path.name for path in (folder / "elsewhere").iterdir()) == ["new", "real"]


def test_the_access_rights_of_an_earlier_file_stay(tmp_path):
    path = tmp_path / "private.txt"
    path.write_text("old")
    path.chmod(0o600)
    with whole_file(path, "text") as partial:
        partial.write_text("new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_what_is_read_only_is_found_before(tmp_path):
    (tmp_path / "a.nc").write_text("keep")
    (tmp_path / "a.nc").chmod(0o400)
    with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
        check_writable(tmp_path / "a.nc")
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match=r"cannot be made \(Permission denied\)"):
        check_writable(tmp_path / "b.nc")


LATIN = os.fsdecode(b"r\xe9sultat")


@pytest.mark.parametrize("name", [f"{LATIN}.nc", f"{LATIN}/a.nc", f"{LATIN}/{LATIN}.nc", "é/é.nc"])
def test_names_that_are_not_in_utf8_are_written_and_read(files, tmp_path, name):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    check_result_output(path)
    write_result(open_result(files / "r.nc"), path)
    assert open_result(path).sizes == open_result(files / "r.nc").sizes
    assert [entry.name for entry in path.parent.iterdir() if entry != tmp_path / LATIN] == [
        path.name
    ]


def test_what_a_killed_process_left_of_such_a_name_goes(tmp_path):
    left = tmp_path / ".written.abcdefgh"
    left.mkdir()
    (left / "written.nc").write_text("x")
    remove_leftovers(tmp_path / f"{LATIN}.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_trial_leaves_nothing_behind_and_replaces_nothing(tmp_path):
    (tmp_path / "a.nc").write_text("keep")
    check_result_output(tmp_path / "a.nc")
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"a.nc": "keep"}


NO_LOCKS = (
    "#include <errno.h>\nint flock(int f, int o) { (void)f; (void)o; errno = ENOLCK; return -1; }"
)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs a compiler")
def test_a_file_system_without_locks(tmp_path):
    """It is written there, unless the user asks for locks: then that is told, before computing."""
    (tmp_path / "nolock.c").write_text(NO_LOCKS)
    library = str(tmp_path / "nolock.so")
    command = ["gcc", "-shared", "-fPIC", "-o", library, str(tmp_path / "nolock.c")]
    subprocess.run(command, check=True)
    code = "import sys; from bilayer.results.files import check_result_output as check\n"
    code += "try: check(sys.argv[1])\nexcept ValueError as error: print(error)"
    told = []
    for asked in ({}, {"HDF5_USE_FILE_LOCKING": "TRUE"}):
        environment = {
            **{k: v for k, v in os.environ.items() if k != "HDF5_USE_FILE_LOCKING"},
            "LD_PRELOAD": library,
            "PYTHONPATH": str(Path(__file__).parents[2]),
            **asked,
        }
        done = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "a.nc")],
            env=environment, capture_output=True, text=True, check=True,
        )  # fmt: skip
        told.append(done.stdout)
    assert told[0] == ""
    assert "cannot be locked: No locks available; HDF5_USE_FILE_LOCKING=FALSE does" in told[1]
    assert told[1].count("\n") == 1


def test_the_picture_of_a_mesh_replaces_no_other_picture(folder, capsys):
    words = ["mesh", "s.toml", "-o", "uncut.msh"]
    (folder / "uncut.msh.png").write_bytes(b"an unrelated picture")
    assert main(words) == 0
    assert (
        "uncut.msh.png is there and is no picture of a mesh: not drawn" in capsys.readouterr().err
    )
    assert (folder / "uncut.msh.png").read_bytes() == b"an unrelated picture"
    assert main(["plot", "r.nc", "-o", "uncut.msh.png"]) == 0
    drawn = (folder / "uncut.msh.png").read_bytes()
    assert main(words) == 0
    assert (folder / "uncut.msh.png").read_bytes() == drawn


def test_the_picture_of_a_mesh_is_drawn_anew(folder, capsys):
    words = ["mesh", "s.toml", "-o", "uncut.msh", "--quiet"]
    assert main(words) == 0
    first = (folder / "uncut.msh.png").read_bytes()
    assert main([*words, "--mesh-size", "8 mm"]) == 0
    assert capsys.readouterr().err == ""
    assert (folder / "uncut.msh.png").read_bytes() != first


def test_the_numbers_of_another_file_are_not_replaced_by_a_companion(folder, capsys):
    (folder / "a.h5").write_text("mine")
    line = refusal(["mesh", "s.toml"], "a.xdmf", capsys)
    assert "a.h5 is there, which .xdmf writes too" in line
    assert (folder / "a.h5").read_text() == "mine"
    for _ in range(2):
        assert main(["mesh", "s.toml", "-o", "b.xdmf", "--quiet"]) == 0


def test_a_format_that_leaves_out_the_layers_of_a_shape_says_so(folder, capsys):
    for ending, told in {
        "stl": True,
        "obj": True,
        "inp": True,
        "vtu": False,
        "xdmf": False,
    }.items():
        assert main(["convert", "r.nc", "-o", f"shape.{ending}"]) == 0
        lines = capsys.readouterr().err.splitlines()
        assert (
            f".{ending} holds the shape without which layers lie where" in "".join(lines)
        ) is told
        assert len(lines) == told
    assert main(["convert", "r.nc", "-o", "shape.stl", "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_a_study_in_place_of_a_file_is_refused(folder, capsys):
    for output in ("s.toml", "s.toml/below"):
        assert "study folder" in refusal(["study", "study.toml", "--quiet"], output, capsys)


def test_the_functions_pass_the_same_gate(files, tmp_path):
    from bilayer import convert, draw_mesh, save_figure, solve

    result, null = open_result(files / "r.nc"), tmp_path / "null"
    null.symlink_to("/dev/null")
    coarse = replace(small_specimen((1.03,)), name="x")
    for act in (
        lambda: write_result(result, null),
        lambda: save_figure(draw_mesh(generate_mesh(coarse)), null.with_suffix(".png")),
        lambda: convert(result, null),
        lambda: solve(coarse, "dshell", output=null),
        lambda: solve(coarse, "dshell", output=""),
        lambda: solve(coarse, "dshell", output=tmp_path / "a.txt"),
        lambda: write_planar_mesh(generate_mesh(coarse), ""),
    ):
        (tmp_path / "null.png").unlink(missing_ok=True)
        (tmp_path / "null.png").symlink_to("/dev/null")
        with pytest.raises(InputError):
            act()
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    with netCDF4.Dataset(files / "r.nc"):
        pass
