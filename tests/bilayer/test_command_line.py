"""The command `bilayer` as a user meets it: outputs, exit statuses, one-line errors."""

import re
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

from bilayer import open_result
from bilayer.cli.main import main
from bilayer.specimen.toml import template

COARSE = ["--mesh-size", "0.012"]
MORLEY = ["solve", "specimen.toml", "--solver", "dshell", *COARSE]
SHELL = ["solve", "specimen.toml", "--solver", "dshell", "--model", "paper", *COARSE,
         "--set", "solver.total_time=0.1"]  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder with the paper's specimen in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "specimen.toml").write_text(template())
    return tmp_path


@pytest.fixture(scope="module")
def shell_file(tmp_path_factory):
    """A result of the paper's shell on a coarse mesh, two milestones."""
    path = tmp_path_factory.mktemp("shell")
    (path / "specimen.toml").write_text(template())
    words = [str(path / word) if word == "specimen.toml" else word for word in SHELL]
    assert main([*words, "--prestretch", "1.03", "1.06", "-o", str(path / "a.nc")]) == 0
    return path / "a.nc"


def error_of(capsys, words, status=2):
    """Run in this process; return the one line that the user sees."""
    try:
        found = main(words)
    except SystemExit as stop:  # argparse
        found = stop.code
    assert found == status
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1, captured.err
    return lines[0]


def test_init_writes_a_new_file_alone(bilayer_command, tmp_path):
    """On Windows `>` of PowerShell would write UTF-16."""
    assert bilayer_command("init", "-o", "a.toml").returncode == 0
    assert (tmp_path / "a.toml").read_text() == template()
    (tmp_path / "a.toml").write_text("mine")
    refused = bilayer_command("init", "-o", "a.toml")
    assert refused.returncode == 2
    assert refused.stderr == (
        "bilayer: error: output file a.toml: is there already, expected the name of a new file\n"
    )
    assert (tmp_path / "a.toml").read_text() == "mine"
    (tmp_path / "u.toml").write_text(template(), "utf-16")
    read = bilayer_command("solve", "u.toml", "-o", "u.nc")
    assert read.returncode == 2
    assert "(is UTF-16, as `>` of PowerShell writes it, expected UTF-8)" in read.stderr


def test_init_prints_the_template_that_solve_reads(bilayer_command, tmp_path):
    printed = bilayer_command("init")
    assert (printed.returncode, printed.stdout, printed.stderr) == (0, template(), "")
    (tmp_path / "s.toml").write_text(printed.stdout)
    meshed = bilayer_command("mesh", "s.toml", "-o", "mesh.msh", *COARSE)
    assert meshed.returncode == 0, meshed.stderr
    assert re.match(r"\d+ nodes, \d+ triangles, \d+ of them kirigami\n$", meshed.stdout)
    assert {path.name for path in tmp_path.iterdir()} == {"s.toml", "mesh.msh", "mesh.msh.png"}


def test_the_pictures_of_a_mesh_and_of_a_result_of_one_name_are_two(folder):
    assert main(["mesh", "specimen.toml", "-o", "s.msh", "--quiet", *COARSE]) == 0
    assert main([*SHELL, "--prestretch", "1.02", "-o", "s.nc", "--plot", "--quiet"]) == 0
    mesh, shapes = (Path(name).read_bytes() for name in ("s.msh.png", "s.png"))
    assert mesh != shapes


def test_a_closed_pipe_is_no_error(tmp_path):
    piped = f"{sys.executable} -m bilayer init | head -1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", piped], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_solve_writes_a_result_and_prints_its_table(folder, capsys):
    assert main([*SHELL, "--prestretch", "1.03", "1.06,1.05", "-o", "a.nc"]) == 0
    out = capsys.readouterr().out
    assert "quality" in out
    assert "1.06,1.05" in out
    result = open_result("a.nc")
    assert result["prestretch_y"].values.tolist() == [1.03, 1.05]
    assert "size = 0.012" in result.attrs["specimen"]
    assert sorted(path.name for path in folder.iterdir()) == ["a.nc", "specimen.toml"]


def test_solve_takes_a_mesh_and_settings(folder):
    assert main(["mesh", "specimen.toml", "-o", "m.vtk", *COARSE, "--quiet"]) == 0
    more = ["--mesh", "m.vtk", "--set", "solver.damping_rate=2", "--set", "cut.cutout_angle=0.3"]
    assert main([*SHELL, *more, "--prestretch", "1.03", "-o", "a.nc", "--quiet"]) == 0
    assert "damping_rate = 2.0" in open_result("a.nc").attrs["settings"]


def help_of(verb, capsys):
    with pytest.raises(SystemExit, match="0"):
        main([verb, "--help"])
    return capsys.readouterr().out


def test_help_gives_an_example(capsys):
    for verb in ("init", "mesh", "solve", "compare", "plot", "convert", "info"):
        assert "example:" in help_of(verb, capsys)


def test_compare_plot_convert_and_info(folder, shell_file, capsys):
    assert main(["compare", str(shell_file), str(shell_file), "-o", "c.png"]) == 0
    assert "1.06" in capsys.readouterr().out
    assert main(["plot", str(shell_file), "-o", "s.png"]) == 0
    assert main(["convert", str(shell_file), "-o", "s.vtu", "--prestretch", "1.06"]) == 0
    assert main(["info", str(shell_file)]) == 0
    told = capsys.readouterr().out
    for word in ("dshell", "paper", "versions", "git commit", "2 of 2 reached"):
        assert word in told
    energy = 1e3 * open_result(shell_file)["energy"].values.sum(axis=1)
    assert f"energy      {energy[0]:.5g}, {energy[1]:.5g} mJ" in told
    assert {path.suffix for path in folder.iterdir()} >= {".png", ".vtu"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([*SHELL, "-o", "none/a.nc"], "output file none/a.nc: the folder none does not exist"),
        ([*SHELL, "-o", "a.nc", "--set", "cut.strips=0"], "cut.strips = 0: leave the"),
        ([*SHELL, "-o", "a.nc", "--set", "solver.damping_rat=1"], "did you mean 'damping_rate'"),
        (
            [*SHELL, "-o", "a.nc", "--set", "solver.damping_rate=x"],
            "solver.damping_rate = 'x': expected a num",
        ),
        (
            [*SHELL, "-o", "a.nc", "--set", "kirigami.side=below"],
            "kirigami.side = 'below': the pap",
        ),
        ([*SHELL, "-o", "a.nc", "--set", "solver.tolerance=1"], "tolerance = 1.0: .* less than 1"),
        (
            [*MORLEY, "-o", "a.nc", "--set", "solver.smallest_step=-1"],
            "solver.smallest_step = -1.0: expected a number from 1e-06 to 1",
        ),
        ([*MORLEY, "-o", "a.nc", "--set", "solver.tolerance=nan"], "expected a finite number"),
        (
            [*MORLEY, "-o", "a.nc", "--set", "kirigami.law=rubber"],
            "kirigami.law = 'rubber': expected one of 'mooney-rivlin', 'neo-hookean', 'linear'",
        ),
        ([*SHELL, "b.toml"], r"b\.toml: expected options alone after specimen = specimen\.toml"),
        ([*SHELL, "-o", "a.nc", "--model", "papr"], "model = 'papr': .*did you mean 'paper'"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "-1"], "expected a number greater than 0"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "nan"], "expected a finite number"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "1e20"], "expected stretches from 0.1 to 10"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "1.06] #"], "expected a number, or two as LX,LY"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "1,2,3"], "one number or"),
        ([*SHELL, "-o", "a.nc", "--prestretch", "1,06"], "expected a decimal point"),
        ([*SHELL, "-o", "a.nc", "--set", "solver.model=hinge"], "expected as --model"),
        ([*SHELL, "-o", f"{'a' * 300}.nc"], "cannot be made"),
        ([*SHELL, "-o", "/proc/a.nc"], "cannot be made"),
        ([*SHELL, "-o", "a.nc", "--set", "mesh.corner_size=1e-9"], "triangles would take"),
        ([*SHELL, "-o", "a.nc", "--mesh-size", "1e-300"], "mesh.size = 1e-300 m"),
        (
            [*SHELL, "-o", "a.nc", "--mesh-size", "abc"],
            "mesh.size = 'abc': expected a length, a number in m",
        ),
        ([*SHELL, "-o", "a.nc", "--mesh-size", "1e-6"], "mesh.size = 1e-06 m: about .* GiB"),
        ([*SHELL, "-o", "a.nc", "--mesh", "none.msh"], "mesh file none.msh: cannot be read"),
        ([*SHELL, "-o", "a.nc", "--start", "none.nc"], "result file none.nc: cannot be read"),
        (["solve", "none.toml", "--solver", "dshell", "-o", "a.nc"], "none.toml: cannot be read"),
        (["solve", "specimen.toml", "--solver", "abaqus", "-o", "a.nc"], "invalid choice"),
        (["plot", "a.nc"], "required: -o"),
        (
            ["mesh", "specimen.toml", "-o", "mesh.xyzzy"],
            "mesh file mesh.xyzzy: cannot be written, expected",
        ),
        (["info", "none.nc"], "result file none.nc: cannot be read"),
        (["info", "study.toml"], "study.toml: cannot be read"),
        (["specimen.toml"], r"did you mean 'bilayer solve specimen\.toml'\?"),
        (["a.nc"], r"did you mean 'bilayer info a\.nc'\?"),
        (["solve", "a.nc"], r"specimen file a\.nc: expected TOML, not a result"),
        (["frobnicate"], "invalid choice: 'frobnicate'"),
        ([], "the following arguments are required: VERB"),
    ],
)
def test_bad_input_is_one_line_and_status_2(folder, capsys, words, message):
    assert re.search(message, error_of(capsys, words))
    assert [path.name for path in folder.iterdir()] == ["specimen.toml"]


def test_a_mistyped_input_is_told_before_an_output_that_is_there(folder, capsys):
    (folder / "specimn.nc").write_text("of an earlier run")
    assert "specimn.toml: cannot be read" in error_of(capsys, ["solve", "specimn.toml"])


def test_what_is_no_result_and_no_scan_is_not_compared(folder, shell_file, capsys):
    message = error_of(capsys, ["compare", str(shell_file), "specimen.toml"])
    assert "expected a result (.nc) or a scan (.stl" in message


def test_two_results_of_one_model_are_told_apart_by_their_files(folder, shell_file, capsys):
    (folder / "copy.nc").write_bytes(shell_file.read_bytes())
    assert main(["compare", str(shell_file), "copy.nc"]) == 0
    assert f"({shell_file.name})    b: dshell paper (copy.nc)" in capsys.readouterr().out


def test_results_of_other_specimens_are_not_compared(folder, shell_file, capsys):
    words = [*SHELL, "--prestretch", "1.03", "-o", "b.nc", "--set", "substrate.thickness=0.002"]
    assert main([*words, "--quiet"]) == 0
    capsys.readouterr()
    assert "substrate" in error_of(capsys, ["compare", str(shell_file), "b.nc"])


def test_a_mesh_of_another_size_is_refused(folder, capsys):
    assert main(["mesh", "specimen.toml", "-o", "m.vtk", *COARSE, "--quiet"]) == 0
    words = [*SHELL, "--mesh", "m.vtk", "-o", "a.nc", "--set", "specimen.outer_radius=0.05"]
    assert "expected specimen.outer_radius = 0.05 m" in error_of(capsys, words)


def test_a_mesh_of_another_cut_is_refused(folder, capsys):
    assert main(["mesh", "specimen.toml", "-o", "m.vtk", *COARSE, "--quiet"]) == 0
    words = [*SHELL, "--mesh", "m.vtk", "-o", "a.nc", "--set", "cut.strips=6"]
    assert "mesh file m.vtk: the layer 'kirigami' " in error_of(capsys, words)


SQUARE = np.array([[0.0, 0.04], [-0.04, 0.0], [0.0, -0.04], [0.04, 0.0]])
TWO = [[0, 1, 2], [0, 2, 3]]
BAD_MESHES = {
    "isolated": (np.vstack([SQUARE, [0, 0.01]]), TWO, [1, 1], "node 4 is isolated"),
    "non-manifold": (
        np.vstack([SQUARE, [-0.01, 0]]), [*TWO, [0, 4, 2]], [1, 1, 1],
        r"edge of nodes 0 and 2 belongs to 3 triangles \(0, 1, 2\): expected at most 2",
    ),
    "orientation": (SQUARE, [[0, 1, 2], [0, 3, 2]], [1, 1], "triangle 1 .* runs clockwise"),
    "degenerate": (
        np.vstack([SQUARE, [0.02, 0.02]]), [*TWO, [0, 3, 4]], [1, 1, 1],
        r"triangle 2 \(nodes 0, 3, 4\) is degenerate",
    ),
    "region": (SQUARE, TWO, [1, 7], "triangle 1 has region = 7: expected 0 or 1"),
    "twice": (SQUARE, [*TWO, [1, 2, 0]], [1, 1, 1], "is there again as triangle 2"),
    "nan": (np.vstack([SQUARE[:3], [np.nan, 0]]), TWO, [1, 1], "node 3 lies at .*nan"),
    "pieces": (
        np.vstack([SQUARE / 4 - 0.02, SQUARE / 4 + 0.02]), [*TWO, [4, 5, 6], [4, 6, 7]],
        [1, 1, 1, 1], r"in 2 pieces, triangle 2 \(nodes 4, 5, 6\) shares no edge",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("points", "triangles", "region", "message"), BAD_MESHES.values(),
                         ids=BAD_MESHES)  # fmt: skip
def test_a_bad_mesh_file_is_one_line_and_status_2(
    folder, capsys, points, triangles, region, message
):
    cells = [("triangle", np.array(triangles))]
    data = {"region": [np.array(region, dtype=np.int32)]}
    meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), cells, cell_data=data).write("bad.vtk")
    line = error_of(capsys, [*SHELL, "--mesh", "bad.vtk", "-o", "a.nc"])
    assert re.search(rf"mesh file bad\.vtk: .*{message}", line)
    assert not (folder / "a.nc").exists()


def test_a_start_on_another_mesh_is_one_line_and_status_2(folder, shell_file, capsys):
    words = ["solve", "specimen.toml", "--solver", "dshell", "--mesh-size", "0.015"]
    line = error_of(capsys, [*words, "--start", str(shell_file), "-o", "a.nc"])
    assert re.search(r"start: has \d+ nodes .* expected a result on the planar mesh", line)
    assert not (folder / "a.nc").exists()


def test_verbose_shows_the_trace(bilayer_command):
    assert "Traceback" in bilayer_command("info", "none.nc", "--verbose").stderr


def test_a_run_that_stops_early_keeps_its_file_and_fails_unless_that_is_a_result(
    folder, capsys, monkeypatch
):
    """The printed shell's stopping is one of its results; of any other model it is a failure."""
    words = [*SHELL, "--prestretch", "1.24", "-o", "a.nc", "--set", "solver.max_iterations=1"]
    assert main(words) == 0
    assert "stopped early" in capsys.readouterr().err
    assert open_result("a.nc")["converged"].values.tolist() == [0]
    monkeypatch.setattr("dshell.settings.PaperSettings.stopping_is_a_result", False)
    assert main(words) == 1


def test_what_is_pasted_into_a_value_is_not_taken_for_toml(folder, capsys):
    pasted = "substrate.thickness=0.001\n[gravity]\nacceleration = 3.0"
    assert "substrate.thickness" in error_of(capsys, [*SHELL, "-o", "a.nc", "--set", pasted])


def test_a_full_disk_under_stdout_is_one_line():
    done = subprocess.run(
        [sys.executable, "-m", "bilayer", "init"],
        stdout=open("/dev/full", "w"),  # noqa: SIM115, PTH123
        stderr=subprocess.PIPE,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr == "bilayer: error: [Errno 28] No space left on device\n"
