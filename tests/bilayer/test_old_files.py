"""Files of earlier versions: they read, and give the numbers that were printed when they were made.

`old_files/README.md` says how. docs/stability.md promises it.
"""

from pathlib import Path

import pytest

from bilayer import open_result, read_specimen, result_mesh, result_specimen
from bilayer.cli.main import main
from bilayer.results.caveats import touches_itself
from bilayer.results.schema import SCHEMA_VERSION

FOLDER = Path(__file__).parent / "old_files"
PRINTED = {  # by prestretch: quality, radius mm, rmse mm, height mm, spans mm, hemisphere distance
    "shell_2026-11-22.nc": {
        1.03: (0.664, 83.133, 1.92, 13.57, 76.75, 75.18, 0.781),
        1.06: (0.462, 53.387, 2.21, 19.03, 73.60, 74.05, 0.603),
    },
    "fenics_2026-11-22.nc": {1.02: (0.790, 130.94, 0.54, 6.95, 77.69, 76.59, 0.850)},
}
OF_1_0 = {  # height of the last milestone as printed, mm; a variable and its values there
    "loads_1.0.0.nc": (2.72, "response_poke", (0.0122827, -0.0122827, 0.0)),
    "time_1.0.0.nc": (18.90, "time", (10.0, 60.0, 300.0)),
    "contact_1.0.0.nc": (30.09, "contact_force", (0.0, 0.0298655)),
}
EACH = pytest.mark.parametrize("name", PRINTED)


def test_every_schema_has_a_file():
    schemas = {int(open_result(FOLDER / name).attrs["schema_version"]) for name in PRINTED}
    assert schemas == set(range(1, SCHEMA_VERSION + 1))


@EACH
def test_an_old_result_has_the_numbers_that_were_printed(name):
    result = open_result(FOLDER / name)
    assert result["prestretch"].values.tolist() == list(PRINTED[name])
    for stretch, printed in PRINTED[name].items():
        shape = result.sel(prestretch=stretch)
        quality, radius, rmse, height, span_x, span_y, hemisphere = printed
        assert float(shape["quality"]) == pytest.approx(quality, abs=6e-4)
        assert float(shape["hemisphere_distance"]) == pytest.approx(hemisphere, abs=6e-4)
        assert 1e3 * float(shape["sphere_radius"]) == pytest.approx(radius, abs=6e-3)
        for measure, value in (("sphere_rmse", rmse), ("height", height)):
            assert 1e3 * float(shape[measure]) == pytest.approx(value, abs=6e-3)
        assert 1e3 * shape["span"].values[:2] == pytest.approx([span_x, span_y], abs=6e-3)
    assert not touches_itself(result).any()


@EACH
def test_an_old_result_can_be_used(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = str(FOLDER / name)
    result = open_result(path)
    assert result_mesh(result).triangles.shape == (result.sizes["face"], 3)
    assert main(["info", path]) == 0
    assert f"{len(PRINTED[name])} of {len(PRINTED[name])} reached" in capsys.readouterr().out
    assert main(["compare", path, path]) == 0
    assert main(["plot", path, "-o", "shape.png"]) == 0
    assert main(["convert", path, "-o", "shape.vtu"]) == 0


@pytest.mark.parametrize("name", OF_1_0)
def test_a_result_of_version_1_0_has_its_numbers_and_can_be_used(name, tmp_path, capsys):
    path = FOLDER / name
    result = open_result(path)
    height, variable, values = OF_1_0[name]
    assert result.attrs["versions"].startswith("bilayer-shells 1.0.0")
    assert 1e3 * float(result["height"][-1]) == pytest.approx(height, abs=6e-3)
    assert result[variable].values[-len(values) :] == pytest.approx(values, rel=1e-5, abs=1e-9)
    assert main(["info", str(path), "--json"]) == 0
    assert '"milestones"' in capsys.readouterr().out
    assert main(["plot", str(path), "-o", str(tmp_path / "shape.png")]) == 0
    assert main(["view", str(path), "-o", str(tmp_path / "shape.html"), "--no-open"]) == 0


@EACH
def test_an_old_specimen_file_is_the_one_of_the_result(name):
    specimen = read_specimen(FOLDER / "specimen_2026-11-22.toml")
    made = result_specimen(open_result(FOLDER / name))
    assert (made.layers, made.outline) == (specimen.layers, specimen.outline)
