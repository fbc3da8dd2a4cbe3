"""Prony series: their form, their place in a file, and their fit to relaxation tests."""

import numpy as np
import pytest

import bilayer
from bilayer import InputError
from bilayer.cli.main import main
from bilayer.fitting.relaxation import Relaxation, fit_relaxation, read_relaxation
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.toml import parse_specimen, specimen_to_toml

SERIES = PronySeries(((0.4, 0.8), (0.2, 9.0), (0.15, 120.0)))
SHEET = """
[specimen]
name = "sheet"
outer_radius = "20 mm"
[prestretch]
milestones = [1.05]
[[layers]]
name = "substrate"
thickness = "1 mm"
material = "soft"
response = "path"
[[layers]]
name = "kirigami"
thickness = "1 mm"
material = "stiff"
[materials.soft]
law = "neo-hookean"
young_modulus = "60 kPa"
poisson_ratio = 0.5
relaxation = [[0.4, "6 s"], [0.2, "1 min"]]
[materials.stiff]
law = "neo-hookean"
young_modulus = "90 kPa"
poisson_ratio = 0.5
"""


def measured(noise=0.0, ramp=0.0, count=80):
    """The stress of a step or of a linear rise, then held, by fine integration."""
    time = np.concatenate([[0.0], np.geomspace(0.05, 800, count - 1)])
    if ramp == 0:
        stress = SERIES.stress_left(time)
    else:
        rise = (np.arange(4000) + 0.5) / 4000 * ramp
        stress = SERIES.stress_left(time[:, None] + rise).mean(axis=1)
    rng = np.random.default_rng(3)
    return Relaxation("made", time, 5e4 * stress * (1 + noise * rng.normal(size=len(time))))


def test_a_series_decays_from_one_to_its_relaxed_share():
    assert SERIES.stress_left(0.0) == pytest.approx(1.0)
    assert SERIES.stress_left(1e9) == pytest.approx(SERIES.relaxed_share) == pytest.approx(0.25)
    at = 3.0
    terms = 0.4 * np.exp(-at / 0.8) + 0.2 * np.exp(-at / 9) + 0.15 * np.exp(-at / 120)
    assert SERIES.stress_left(at) == pytest.approx(0.25 + terms, rel=1e-14)
    assert (PronySeries().stress_left(np.array([0.0, 5.0])) == 1).all()


def test_a_file_gives_the_relaxation_of_a_material_and_it_comes_back():
    sheet = parse_specimen(SHEET)
    assert sheet.layer("substrate").relaxation.terms == ((0.4, 6.0), (0.2, 60.0))
    assert sheet.layer("kirigami").relaxation.terms == ()
    assert parse_specimen(specimen_to_toml(sheet)) == sheet


def test_a_disc_of_two_layers_that_relaxes_is_written_with_its_relaxation():
    disc = bilayer.paper_specimen().with_layer("substrate", relaxation=SERIES)
    assert parse_specimen(specimen_to_toml(disc)).layer("substrate").relaxation == SERIES


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("0.4", "materials.soft.relaxation = 0.4: expected"),
        ("[[0.4]]", "expected such as"),
        ('[[0.4, "6 m"]]', "expected a time"),
        ("[[0.4, 0]]", "time = 0.* expected"),
        ("[[1.4, 1]]", "share = 1.4: expected from 0 to 1"),
        ("[[0.7, 1], [0.6, 2]]", r"add up to 1\.3, expected at most 1"),
    ],
)
def test_bad_series_are_refused(given, message):
    text = SHEET.replace('[[0.4, "6 s"], [0.2, "1 min"]]', given)
    with pytest.raises(InputError, match=message):
        parse_specimen(text)


@pytest.mark.parametrize("ramp", [0.0, 0.5])
def test_the_series_comes_back_from_its_own_stresses(ramp):
    found = fit_relaxation(measured(ramp=ramp), 3, ramp)
    assert np.array(found.series.terms) == pytest.approx(np.array(SERIES.terms), rel=1e-3)
    assert found.instantaneous == pytest.approx(5e4, rel=1e-3)
    assert found.rms < 1e-6


def test_noise_does_not_make_more_terms_than_there_are():
    found = fit_relaxation(measured(noise=0.005))
    assert len(found.series.terms) == 3
    assert np.array(found.series.terms) == pytest.approx(np.array(SERIES.terms), rel=0.2)
    time = np.geomspace(0.1, 500, 20)
    assert found.stress(time) == pytest.approx(5e4 * SERIES.stress_left(time), rel=0.02)


def vhb_like(path):
    test = measured(noise=0.003)
    rows = [f"{t / 60:.8g};{s / 1e3:.8g}" for t, s in zip(test.time, test.stress, strict=True)]
    path.write_text("time_min;nominal_stress_kPa\n" + "\n".join(rows))
    return path


def test_units_and_columns_of_a_file(tmp_path):
    read = read_relaxation(vhb_like(tmp_path / "a.csv"))
    assert read.time == pytest.approx(measured().time, rel=1e-6)
    assert read.stress[0] == pytest.approx(5e4, rel=0.02)


def test_fit_on_the_command_line(tmp_path, capsys):
    file, figure = vhb_like(tmp_path / "a.csv"), tmp_path / "a.png"
    words = ["fit", "--relaxation", str(file), "--ramp", "0.1 s", "--name", "soft"]
    assert main([*words, "-o", str(figure)]) == 0
    out = capsys.readouterr().out
    assert "[materials.soft]\nrelaxation = [[" in out and "rms 0." in out
    assert figure.stat().st_size > 5000
    table = out[out.index("relaxation = [") :].strip()
    sheet = parse_specimen(SHEET.replace('relaxation = [[0.4, "6 s"], [0.2, "1 min"]]', table))
    assert len(sheet.layer("substrate").relaxation.terms) >= 3
    assert main(["fit", str(file), "--relaxation", str(file)]) == 2
    assert "expected no other tests" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("time", "stress", "message"),
    [
        ([0, 1, 2], [3, 2, 1], "has 3 points"),
        ([0, 1, 2, 2, 3, 4], [9, 8, 7, 6, 5, 4], "times from 0 on that rise"),
        ([0, 1, 2, 3, 4, 5], [9, 8, 7, 6, 5, 0], "stresses above 0"),
    ],
)
def test_bad_tests_are_refused(time, stress, message):
    with pytest.raises(InputError, match=message):
        Relaxation("made", np.array(time, float), np.array(stress, float))
