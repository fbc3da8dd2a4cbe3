"""Reading what CalculiX wrote, on a run of its own that is kept in calculix/."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from hexagon import hexagon_mesh, hexagon_specimen

from bilayer import InputError, open_result, specimen_to_toml, write_planar_mesh
from bilayer.calculix.deck import choose_nodes_under_kirigami
from bilayer.calculix.files import read_frd, read_run_record
from bilayer.calculix.result import import_calculix
from bilayer.cli.main import main
from bilayer.geometry.surface import Surface
from bilayer.results.report import provenance

KEPT = Path(__file__).parent / "calculix"
MILESTONES = (1.03, 1.06, 1.09)


@pytest.fixture
def run(tmp_path):
    """A copy of the kept run, to be spoilt: the path of its .frd file."""
    for ending in ("frd", "sta", "cvg"):
        shutil.copy(KEPT / f"hexagon_1.06.{ending}", tmp_path / f"deck.{ending}")
    return tmp_path / "deck.frd"


@pytest.fixture(scope="module")
def result():
    return import_calculix(
        [KEPT / "hexagon_1.06.frd"], hexagon_specimen(MILESTONES), hexagon_mesh()
    )


def stopped_in_increment(path, increment):
    """Let the kept run have given up in an increment, as CalculiX writes it."""
    kept = path.with_suffix(".sta").read_text().splitlines()
    last = [row for row in kept[2:] if int(row.split()[1]) < increment and "U" not in row]
    c = last[-1].split()[5]
    failed = f"     1  {increment:9d}     1U    9  {c}  {c}  0.450000E-01"
    path.with_suffix(".sta").write_text("\n".join([*kept[:2], *last, failed]) + "\n")
    path.write_text(path.read_text().removesuffix(" 9999\n"))


def test_the_milestone_is_recognised_by_where_the_nodes_are_drawn(result):
    assert result["prestretch"].values.tolist() == [1.06]
    assert result["converged"].values.tolist() == [1]
    assert result.attrs["solver"] == "calculix"
    assert result.attrs["model"] == "wedge"
    assert "CalculiX 2.20" in result.attrs["versions"]
    assert "hexagon_1.06.frd" in result.attrs["settings"]


def test_held_nodes_are_where_they_were_bonded(result):
    mesh = hexagon_mesh()
    a, b, c = choose_nodes_under_kirigami(mesh, 0.0)
    moved = result["position"].values[0] - np.column_stack([mesh.points, 0 * mesh.points[:, 0]])
    assert moved[a] == pytest.approx(0, abs=1e-8)  # 5e-6 of the way of 1.6 mm of the layer's node
    assert moved[b, 1:] == pytest.approx(0, abs=1e-8)
    assert moved[c, 2] == pytest.approx(0, abs=1e-8)
    assert np.abs(moved).max() > 0.005


def test_the_released_hexagon_bends_and_its_bond_shrinks(result):
    """By less than the substrate would alone. Against both solvers: rung 16, on finer meshes.

    On 24 triangles the solvers do not agree about the axis to roll up about.
    """
    mesh = hexagon_mesh()
    bond = Surface(result["position"].values[0], mesh.triangles)
    assert 1.06**-2 < bond.areas.sum() / mesh.areas.sum() < 1
    assert result["height"].item() > 0.01


def test_increments_and_iterations_are_counted(result):
    run = read_run_record(KEPT / "hexagon_1.06.frd")
    assert (run.increments, run.iterations, run.reached) == (21, 136, 1.0)
    assert run.failed_increment is None  # though two attempts failed and were repeated
    assert int(result["load_steps"][0]) == 21
    assert int(result["iterations"][0]) == 136


def test_the_residual_is_that_of_the_last_iteration(run):
    cvg = run.with_suffix(".cvg")
    lines = cvg.read_text().rstrip().splitlines()
    lines[-1] = lines[-1].replace("0.0000E+00", "0.1500E+00", 1)  # per cent
    cvg.write_text("\n".join(lines))
    result = import_calculix([run], hexagon_specimen(), hexagon_mesh())
    assert float(result["residual"][0]) == pytest.approx(0.0015)


def test_a_deck_that_stopped_is_not_converged_and_says_where(run):
    stopped_in_increment(run, 15)
    result = import_calculix([run], hexagon_specimen(), hexagon_mesh())
    assert not result["converged"].values.any()
    assert np.isnan(result["position"].values).all()
    assert "prestretch 1.06: CalculiX gave up in increment 15 at c = 0.75" in provenance(result)


def test_a_run_that_was_killed_is_not_converged(run):
    kept = run.with_suffix(".sta").read_text().splitlines()
    run.with_suffix(".sta").write_text("\n".join(kept[:5]) + "\n")
    result = import_calculix([run], hexagon_specimen(), hexagon_mesh())
    assert "CalculiX was ended at c = 0.15" in result.attrs["stop_reason"]


def test_the_nodes_of_another_mesh_are_refused(run):
    mesh = hexagon_mesh()
    moved = type(mesh)(mesh.points * 1.001, mesh.triangles, mesh.region)
    with pytest.raises(InputError, match=r"deck.frd: its .* nodes lie where no deck"):
        import_calculix([run], hexagon_specimen(), moved)
    with pytest.raises(InputError, match=r"milestones 1.03, 1.09"):
        import_calculix([run], hexagon_specimen((1.03, 1.09)), mesh)


def test_two_files_of_one_prestretch_are_refused(run):
    with pytest.raises(InputError, match=r"1.06 \(wedge\), 1.06 \(wedge\): expected one of each"):
        import_calculix([run, KEPT / "hexagon_1.06.frd"], hexagon_specimen(), hexagon_mesh())


@pytest.mark.parametrize("share", [0.1, 0.3, 0.7])
def test_a_file_that_is_cut_off_is_named(run, share):
    text = run.read_text()
    run.write_text(text[: int(share * len(text))])
    with pytest.raises(InputError, match=r"frd file .*deck.frd: (ends at line|the block at)"):
        read_frd(run)


def test_nodes_that_are_nowhere_or_not_there_are_told(run):
    lines = run.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(" -1"))
    moved = lines[first][:13] + "         NaN" + lines[first][25:]
    run.write_text("\n".join([*lines[:first], moved, *lines[first + 1 :]]))
    with pytest.raises(InputError, match=r"node \d+ lies at .*nan.*, expected finite numbers"):
        read_frd(run)
    run.write_text("\n".join(line for line in lines if not line.startswith(" -1")))
    with pytest.raises(InputError, match="holds no nodes"):
        read_frd(run)


def test_a_file_without_its_last_shape_is_not_converged(run):
    text = run.read_text()
    run.write_text(text[: text.index("    1PSTEP")])
    result = import_calculix([run], hexagon_specimen(), hexagon_mesh())
    assert not result["converged"].values.any()


@pytest.mark.parametrize("ending", [".frd", ".sta", ".cvg"])
def test_a_missing_file_is_named(run, ending):
    run.with_suffix(ending).unlink()
    with pytest.raises(InputError, match=rf"deck\{ending}: cannot be read \(No such file"):
        import_calculix([run], hexagon_specimen(), hexagon_mesh())


@pytest.mark.parametrize("ending", [".frd", ".sta", ".cvg"])
def test_an_empty_file_is_named(run, ending):
    run.with_suffix(ending).write_text("")
    with pytest.raises(InputError, match=rf"deck\{ending}: is empty"):
        import_calculix([run], hexagon_specimen(), hexagon_mesh())


def test_a_file_of_another_kind_is_named(run):
    run.write_text("*NODE\n1, 0., 0., 0.\n")
    with pytest.raises(InputError, match=r"deck.frd: holds no nodes"):
        read_frd(run)


@pytest.fixture
def words(run):
    """The arguments of `bilayer` that import the kept run."""
    specimen, mesh, output = (run.with_name(name) for name in ("s.toml", "mesh.vtu", "ccx.nc"))
    specimen.write_text(specimen_to_toml(hexagon_specimen()))
    write_planar_mesh(hexagon_mesh(), mesh)
    return ["import", str(run), str(specimen), "--mesh", str(mesh), "-o", str(output)]


def test_import_writes_a_result_that_the_other_verbs_read(run, words, capsys):
    assert main(words) == 0
    output = words[-1]
    assert main(["info", output]) == 0
    assert main(["compare", output, output]) == 0
    assert main(["plot", output, "-o", str(run.with_suffix(".png"))]) == 0
    assert run.with_suffix(".png").stat().st_size > 1000
    printed = capsys.readouterr().out
    assert "energy      unknown" in printed
    assert "solver      calculix, model wedge" in printed
    assert float(open_result(output)["height"][0]) > 0.01


def test_import_of_a_deck_that_stopped_is_kept_and_exits_1(run, words, capsys):
    stopped_in_increment(run, 15)
    assert main(words) == 1
    assert "bilayer: stopped early: prestretch 1.06: CalculiX gave up" in capsys.readouterr().err
    assert not open_result(words[-1])["converged"].values.any()


def test_import_of_a_damaged_file_is_one_line_and_exits_2(run, words, capsys):
    run.write_text(run.read_text()[:9000])
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.startswith("bilayer: error: frd file ")
    assert error.count("\n") == 1


def test_export_by_the_command_line_is_the_deck_that_is_kept(words, tmp_path, capsys):
    output = tmp_path / "new.inp"
    assert main(["export", *words[2:5], "-o", str(output), "--set", "solver.element=wedge"]) == 0
    assert capsys.readouterr().out == f"{output}\n"

    def keywords_and_data(path):
        return [line for line in path.read_text().splitlines() if not line.startswith("**")]

    assert keywords_and_data(output) == keywords_and_data(KEPT / "hexagon_1.06.inp")
