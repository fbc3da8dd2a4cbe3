"""The rows of .frd files as CalculiX writes them on Linux, on Windows, and with a decimal comma."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from bilayer import InputError
from bilayer.calculix.files import read_frd, read_run_record
from bilayer.calculix.frd_rows import read_rows

KEPT = Path(__file__).parent / "calculix"
SPREAD = (1.0, 1e-3, 1e3, 1e-30, 1e120, 1e-250)


def linux(value):
    """As glibc prints %12.5E: exponents of two digits, of three from 1e100 on."""
    return f"{value:12.5E}"


def windows(value):
    """As msvcrt does: exponents of three digits, so a negative value has 13 columns."""
    text = re.sub(r"E([+-])(\d\d)$", r"E\g<1>0\2", f"{value:.5E}")
    return text.rjust(12)


def comma(value):
    return linux(value).replace(".", ",")


def windows_comma(value):
    return windows(value).replace(".", ",")


def fortran(value):
    """As 1PE12.5 of Fortran: without the E where the exponent has three digits."""
    return re.sub(r"E([-+]\d{3})$", r"\1", f"{value:.5E}").rjust(12)


STYLES = [linux, windows, comma, windows_comma, fortran]


def row(node, values, style, columns=10):
    return f" -1{node:{columns}d}" + "".join(map(style, values))


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("columns", [5, 10])
def test_values_of_every_sign_and_size_are_those_that_were_written(style, columns):
    random = np.random.default_rng(5)
    written = random.normal(size=(300, 3)) * random.choice(SPREAD, size=(300, 3))
    written[random.random(written.shape) < 0.1] = 0.0
    lines = [row(node + 1, values, style, columns) for node, values in enumerate(written)]
    numbers, values = read_rows(lines, columns, 1)
    assert numbers.tolist() == list(range(1, 301))
    assert values.tolist() == [[float(f"{v:.5E}") for v in three] for three in written]


@pytest.mark.parametrize("place", [0, 1, 2])
def test_one_negative_value_of_windows_shifts_nothing(place):
    values = [5.28012e-3, 3.06745e-3, 1.25e-3]
    values[place] *= -1
    line = row(7, values, windows)
    assert len(line) == 13 + 37
    assert read_rows([line], 10, 1)[1].tolist() == [values]


def test_rows_are_given_by_ascending_node_and_other_lines_passed_over():
    lines = [" -5  D1          1    2    1    0", *(row(n, [n, 0, 0], linux) for n in (3, 1, 2))]
    numbers, values = read_rows(lines, 10, 1)
    assert numbers.tolist() == [1, 2, 3]
    assert values[:, 0].tolist() == [1.0, 2.0, 3.0]


def test_a_run_that_diverged_holds_no_numbers():
    line = row(1, [1.0, 2.0, 3.0], linux).replace(" 2.00000E+00", "         NAN")
    assert np.isnan(read_rows([line], 10, 1)[1]).tolist() == [[False, True, False]]


BAD = {
    "two values": row(1, [1, 2], linux),
    "four values": row(1, [1, 2, 3, 4], linux),
    "cut off": row(1, [1, 2, 3], linux)[:-1],
    "cut off after E": row(1, [1, 2, 3], linux)[:-3],
    "no point": row(1, [1, 2, 3], linux).replace("1.00000", "1 00000"),
    "two points": row(1, [1, 2, 3], linux).replace("1.00000", "1.0.000"),
    "two digits before the point": row(1, [1, 2, 3], linux).replace(" 1.0", "11.0"),
    "four digits of an exponent": row(1, [1, 2, 3], linux).replace("E+00", "E+0000"),
    "not a number of msvcrt": row(1, [1, 2, 3], linux).replace("1.00000E+00", "1.#QNAN0000"),
    "a short number": row(1, [1, 2, 3], linux, columns=5),
    "a long number": row(123456, [1, 2, 3], linux, columns=14),
    "a text": row(1, [1, 2, 3], linux).replace(" 1.00000E+00", "       hello"),
    "no node": row(1, [1, 2, 3], linux).replace(" -1         1", " -1          "),
}


@pytest.mark.parametrize("line", BAD.values(), ids=BAD)
def test_a_row_of_anything_else_is_named(line):
    with pytest.raises(InputError, match=r"line 12 is .*, expected a node number in 10 columns"):
        read_rows(["", line], 10, 11)


def test_a_node_that_comes_twice_is_named():
    with pytest.raises(InputError, match="node 4 comes twice"):
        read_rows([row(4, [1, 2, 3], linux)] * 2, 10, 1)


@pytest.fixture
def kept(tmp_path):
    for ending in ("frd", "sta", "cvg"):
        shutil.copy(KEPT / f"hexagon_1.06.{ending}", tmp_path / f"deck.{ending}")
    return tmp_path / "deck.frd"


@pytest.mark.parametrize("style", STYLES[1:])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_file_of_another_style_is_that_of_linux(kept, style, ends):
    expected = read_frd(kept)

    def written(line):
        if not re.match(r" -1.{10}[ -]\d\.", line):
            return line
        return row(int(line[3:13]), [float(line[k : k + 12]) for k in (13, 25, 37)], style)

    lines = [written(line) for line in kept.read_text().splitlines()]
    kept.write_bytes((ends.join(lines) + ends).encode())
    found = read_frd(kept)
    assert np.array_equal(found.points, expected.points)
    assert np.array_equal(found.displacements, expected.displacements)
    assert found.is_whole


def test_the_short_form_has_node_numbers_of_five_columns(kept):
    expected = read_frd(kept)
    text = re.sub(r"(?m)^ -1     (.{5}[ -]\d\.)", r" -1\1", kept.read_text())
    kept.write_text(re.sub(r"(?m)^(    2C.*)1$", r"\g<1>0", text))
    assert np.array_equal(read_frd(kept).displacements, expected.displacements)


@pytest.mark.parametrize("kind", ["2", "3"])
def test_binary_numbers_are_refused_by_their_name(kept, kind):
    kept.write_text(re.sub(r"(?m)^(    2C.*)1$", rf"\g<1>{kind}", kept.read_text()))
    with pytest.raises(InputError, match=rf"binary \(format {kind}\), expected a text file"):
        read_frd(kept)


def test_a_version_line_without_a_version_is_none(kept):
    text = re.sub(r"(?m)^    1UVERSION.*$", "    1UVERSION", kept.read_text())
    kept.write_text(text)
    assert read_frd(kept).version == ""


def test_increments_with_a_decimal_comma_are_those_of_linux(kept):
    expected = read_run_record(kept)
    for ending in (".sta", ".cvg"):
        file = kept.with_suffix(ending)
        file.write_text(re.sub(r"(\d)\.(\d)", r"\1,\2", file.read_text()))
    assert read_run_record(kept) == expected
