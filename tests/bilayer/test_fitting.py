"""Constants of laws from measurements: known ones come back, published data give known numbers."""

import math

import numpy as np
import pytest

import bilayer
from bilayer.cli.main import main
from bilayer.errors import InputError
from bilayer.fitting.fit import fit, nominal_stress
from bilayer.fitting.laws import FITTED
from bilayer.fitting.measurement import Measurement, read_measurement

STRETCH = np.linspace(1.02, 1.8, 40)
LAWS = {
    "neo-hookean": bilayer.NeoHookean(2e4, 0.0),
    "mooney-rivlin": bilayer.MooneyRivlin(2e4, 1e4),
    "yeoh": bilayer.Yeoh(2e4, -1e3, 500.0),
    "gent": bilayer.Gent(4e4, 6.0),
    "arruda-boyce": bilayer.ArrudaBoyce(4e4, 1.8),
    "ogden-1": bilayer.Ogden((4e4,), (1.4,)),
}
# VHB 4910, uniaxial, 0.01 1/s, up to 1.486: https://github.com/Chongran-Zhao/VHB4910_data, thinned
VHB = """stretch,nominal_stress_kPa
1.0004,0.886
1.0262,4.598
1.0512,7.468
1.0762,9.898
1.1012,11.991
1.1312,14.217
1.1562,15.880
1.1812,17.380
1.2062,18.774
1.2312,20.052
1.2562,21.227
1.2812,22.344
"""


def measured(law, loading="uniaxial", noise=0.0, seed=0, stretch=STRETCH):
    stress = nominal_stress(law, loading, stretch)
    scatter = np.random.default_rng(seed).normal(size=len(stretch))
    return Measurement("made", loading, stretch, stress + noise * stress.max() * scatter)


def values_of(found):
    return [constant.value for constant in found.constants]


@pytest.mark.parametrize(
    ("loading", "expected"),
    [
        ("uniaxial", lambda s: 2 * (s - s**-2) * (2e4 + 1e4 / s)),
        ("equibiaxial", lambda s: 2 * (s - s**-5) * (2e4 + 1e4 * s**2)),
        ("planar", lambda s: 2 * (s - s**-3) * 3e4),
    ],
)
def test_nominal_stress_is_that_of_the_closed_form(loading, expected):
    got = nominal_stress(LAWS["mooney-rivlin"], loading, STRETCH)
    np.testing.assert_allclose(got, expected(STRETCH), rtol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_constants_come_back_without_noise(name):
    both = [measured(LAWS[name]), measured(LAWS[name], "equibiaxial")]
    found = fit(both, name)
    for m in both:
        got = nominal_stress(found.law, m.loading, m.stretch)
        assert np.abs(got - m.stress).max() < 1e-6 * m.stress.max()
    assert found.rms < 1e-7


@pytest.mark.parametrize("proportional", [False, True])
@pytest.mark.parametrize("name", ["mooney-rivlin", "yeoh"])
def test_constants_lie_within_their_intervals_as_often_as_they_say(name, proportional):
    law, hits = LAWS[name], np.zeros(len(FITTED[name].names))
    truth = [getattr(law, key) for key in FITTED[name].names]
    for seed in range(100):
        m = measured(law)
        size = m.stress if proportional else m.stress.max()
        scatter = 0.01 * size * np.random.default_rng(seed).normal(size=len(m.stress))
        noisy = Measurement(m.name, m.loading, m.stretch, m.stress + scatter)
        found = fit([noisy], name, bounded=False)
        hits += [
            c.interval[0] <= t <= c.interval[1] for c, t in zip(found.constants, truth, strict=True)
        ]
    assert (hits >= 90).all() and (hits <= 99).all(), hits


def test_bounds_hold_the_constants_and_say_what_they_cost():
    law = bilayer.MooneyRivlin(-5e3, 3e4)
    bounded, free = (fit([measured(law)], bounded=b) for b in (True, False))
    assert values_of(free) == pytest.approx([-5e3, 3e4], rel=1e-5)
    assert values_of(bounded)[0] == 0.0 and math.isnan(bounded.constants[0].interval[0])
    assert bounded.rms > free.rms


def test_several_measurements_weigh_the_same():
    soft, stiff = bilayer.NeoHookean(1e4, 0.0), bilayer.NeoHookean(3e4, 0.0)
    few = measured(soft, stretch=STRETCH[::8])
    many = measured(stiff)
    got = values_of(fit([few, many], "neo-hookean"))[0]
    again = measured(soft)
    assert got == pytest.approx(values_of(fit([again, many], "neo-hookean"))[0], rel=0.02)


def test_the_poisson_ratio_gives_the_compressibility():
    found = fit([measured(LAWS["gent"])], "gent", poisson_ratio=0.49)
    assert found.law.poisson_ratio == pytest.approx(0.49)
    assert fit([measured(LAWS["gent"])], "gent").law.d1 == 0.0


@pytest.mark.parametrize(
    ("text", "stretch", "stress"),
    [
        ("stretch,stress\n1.5,2e4\n2,3e4\n", [1.5, 2.0], [2e4, 3e4]),
        ("Strain (%);Stress (MPa)\n50;0,02\n100;0,03\n", [1.5, 2.0], [2e4, 3e4]),
        ("# note\nstrain\ttrue stress [kPa]\n0.5\t30\n1\t60\n", [1.5, 2.0], [2e4, 3e4]),
        ("time lambda sigma_Pa\n0 1.5 2e4\n1 2 3e4\n", [1.5, 2.0], [2e4, 3e4]),
        ("\ufeffStretch,Nominal stress (N/mm2)\n1.5,0.02\n2,0.03\n", [1.5, 2.0], [2e4, 3e4]),
    ],
)
def test_tables_of_testing_machines(tmp_path, text, stretch, stress):
    (tmp_path / "test.csv").write_text(text, encoding="utf-8")
    read = read_measurement(tmp_path / "test.csv")
    np.testing.assert_allclose(read.stretch, stretch)
    np.testing.assert_allclose(read.stress, stress)


def test_a_named_column_of_per_cents_is_a_strain(tmp_path):
    (tmp_path / "test.csv").write_text("Dehnung [%];Spannung [kPa]\n0,0;0\n50,0;20\n")
    names = {"stretch_column": "Dehnung [%]", "stress_column": "Spannung [kPa]"}
    np.testing.assert_allclose(read_measurement(tmp_path / "test.csv", **names).stretch, [1, 1.5])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected a line of names"),
        ("stretch,stress\n", "expected a line of names and lines of numbers"),
        ("stretch,force\n1,2\n", "no column of stretch, force is a stress"),
        ("stretch,stress 1,stress 2\n1,2,3\n", "stress 1 and stress 2 may both be the stress"),
        ("stretch,stress\n1,two\n", r"line 1 of numbers = .*expected 2 numbers"),
        ("stretch,stress\n1,2,3\n", "expected 2 numbers"),
        ("Results\nstretch,stress\n1,2\n", "expected 1 numbers, below one line of names"),
        ("stretch,stress\n-1,2\n", "stretch = -1: expected above 0; a column of strains"),
        ("stretch,stress\n1,nan\n", "finite numbers"),
    ],
)
def test_wrong_tables_are_told(tmp_path, text, words):
    (tmp_path / "test.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_measurement(tmp_path / "test.csv")


def test_the_verb(tmp_path, capsys):
    """The bound of C10 costs nothing here but the split; the table is one of a specimen."""
    file = tmp_path / "vhb.csv"
    file.write_text(VHB)
    words = ["fit", str(file), "--no-bounds", "--name", "vhb", "-o", str(tmp_path / "fit.png")]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "uniaxial, 12 points, stretch 1 to 1.281" in out
    assert '[materials.vhb]\nlaw = "mooney-rivlin"' in out
    assert (tmp_path / "fit.png").stat().st_size > 10_000
    assert main(["fit", str(file), "--law", "all"]) == 0
    table = capsys.readouterr().out
    assert all(name in table for name in FITTED)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "expected at least one file"),
        (["none.csv"], "none.csv: cannot be read"),
        (["zero.csv"], "zero.csv: cannot be read (is a device"),
        (["kgf.csv"], "column 'stress (kgf)': the unit 'kgf', expected Pa"),
        (["vhb.csv", "--up-to", "1.05"], "expected at least 4 points, there are 2"),
        (["vhb.csv", "--poisson-ratio", "0.6"], "poisson_ratio = 0.6"),
        (["vhb.csv", "--stress-column", "stres"], "column 'stres' is not there"),
        (["vhb.csv", "--name", "a b"], "--name = 'a b'"),
    ],
)
def test_wrong_words_are_told(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "vhb.csv").write_text(VHB)
    (tmp_path / "kgf.csv").write_text("stretch,stress (kgf)\n1.1,2\n1.2,3\n")
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    assert main(["fit", *words]) == 2
    assert message in capsys.readouterr().err
