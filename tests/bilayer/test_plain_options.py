"""PETSc options from a file: only those that choose numbers and methods are used without a word."""

import pytest
from made_results import cap_result, small_specimen
from studies_for_tests import write_study

from bilayer import InputError, read_study, write_result
from bilayer.cli.main import main
from bilayer.solvers.rerun import rerun
from bilayer.specimen.settings import check_plain
from fenics_model.plain_options import not_plain_option
from fenics_model.settings import SolidSettings

pytest.importorskip("dolfinx")

PLAIN = [
    "",
    "-bilayer_snes_monitor",
    "-bilayer_pc_type lu -bilayer_mat_mumps_icntl_14 60",
    "-bilayer_snes_rtol 1e-9\n-bilayer_snes_max_it 40 -bilayer_ksp_rtol .5",
    "-bilayer_snes_lag_jacobian -2",
    "-bilayer_pc_factor_mat_solver_type superlu_dist",
]
OF_CODE = [
    "-bilayer_pc_type python",
    "-bilayer_pc_type lu -bilayer_pc_python_type module.Class",
    "-bilayer_ksp_type python",
    "-bilayer_snes_type python",
    "-bilayer_snes_type shell",
    "-bilayer_snes_linesearch_type shell",
    "-bilayer_ksp_view ascii:PATH",
    "-bilayer_ksp_view :PATH",
    "-bilayer_snes_monitor PATH",
    "-bilayer_ksp_monitor_python module.function",
    "-bilayer_mat_view binary:PATH",
    "-bilayer_mat_mumps_icntl_3 77",
    "-bilayer_mat_mumps_icntl_22 1",
    "-bilayer_mat_mumps_ooc_tmpdir PATH",
    "-bilayer_snes_rtol 1e-9;2",
    "-bilayer_snes_rtol",
    "-bilayer_snes_rtol 1e-9 2",
    "-bilayer_snes_rtol '1e-9'",
    "-options_file PATH",
    "-options_string_yaml x",
    "-prefix_push bilayer_ -pc_type python -prefix_pop",
    "-dll_append PATH",
    "-info PATH",
    "-log_view :PATH",
    "-malloc_dump PATH",
    "-on_error_attach_debugger",
    "stray -bilayer_pc_type lu",
    "-bilayer_pc_typeX lu",
    "-bilayer_snes_rtol @PATH",
    "-bilayer_pc_type python{x}",
    "-bilayer_bilayer_pc_type lu",
    "-BILAYER_pc_type lu",
]


@pytest.mark.parametrize("text", PLAIN)
def test_numbers_and_methods_are_plain(text):
    assert not_plain_option(text) == ""
    check_plain(SolidSettings(petsc_options=text))


@pytest.mark.parametrize("text", OF_CODE)
def test_everything_else_is_not(text):
    assert not_plain_option(text)
    with pytest.raises(InputError, match=r"solver\.petsc_options: .* --trust allows it") as raised:
        check_plain(SolidSettings(petsc_options=text))
    assert not_plain_option(text) in str(raised.value).replace("\\'", "'")


def result_with(options):
    settings = SolidSettings(petsc_options=options)
    specimen = small_specimen((1.01,))
    return cap_result(specimen, solver="fenics", model="solid", settings=settings)


@pytest.mark.parametrize("text", OF_CODE[:8])
def test_a_result_that_brings_code_is_not_run_again(text, tmp_path, capsys):
    """Even where it would fail afterwards: nothing is written, and the line says what it is."""
    text = text.replace("PATH", str(tmp_path / "made"))
    file = tmp_path / "r.nc"
    write_result(result_with(text), file)
    assert main(["rerun", str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("bilayer: error: result file ")
    assert ": solver.petsc_options: '-bilayer_" in error
    assert error.count("\n") == 1
    assert main(["info", str(file)]) == 0
    told = capsys.readouterr().out
    assert "It is not run again as it stands: solver.petsc_options" in told
    assert "bilayer solve" not in told
    assert list(tmp_path.iterdir()) == [file]


def test_trust_hands_them_on(tmp_path):
    """PETSc then refuses the option itself."""
    result = result_with("-bilayer_pc_type nonsense")
    with pytest.raises(InputError, match="--trust allows it"):
        rerun(result)
    with pytest.raises(InputError, match="expected options that this PETSc knows"):
        rerun(result, trust=True)


@pytest.mark.parametrize(
    "varied",
    [
        "[settings.fenics]\npetsc_options = '{0}'\n",
        "[vary]\n'settings.fenics.petsc_options' = ['', '{0}']",
    ],
)
def test_a_study_file_that_brings_code_is_refused(varied, tmp_path, capsys):
    text = 'specimen = "specimen.toml"\nsolver = "fenics"\n'
    file = write_study(tmp_path, text + varied.format("-bilayer_ksp_view ascii:made"))
    assert main(["study", str(file), "-o", str(tmp_path / "out")]) == 2
    assert "'-bilayer_ksp_view ascii:made' could run code" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert len(read_study(file, trust=True).cases) in (1, 2)
    plain = write_study(tmp_path, text + varied.format("-bilayer_pc_type lu"))
    assert len(read_study(plain).cases) in (1, 2)
