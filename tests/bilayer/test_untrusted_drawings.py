"""Drawings and images that are not what they say: refused in one line, whatever reads them."""

import os

import pytest

from bilayer import InputError, read_specimen

SHEET = """
[specimen]
name = "drawn"
outline = {{ shape = "disc", radius = "40 mm" }}
[[layers]]
name = "below"
thickness = "0.5 mm"
material = "soft"
response = "path"
[[layers]]
name = "above"
thickness = "0.5 mm"
material = "soft"
pattern = {{ {given} }}
[materials.soft]
law = "neo-hookean"
young_modulus = "1 MPa"
density = 1000
[prestretch]
milestones = [1.03]
"""
BLOCKS = 24


def svg_of_blocks(path):
    """Some hundred bytes that stand for 2^24 squares."""
    blocks = ['<rect id="b0" width="1" height="1"/>']
    for k in range(1, BLOCKS):
        both = f'<use href="#b{k - 1}"/>' * 2
        blocks.append(f'<g id="b{k}">{both}</g>')
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
        f"<defs>{''.join(blocks)}</defs><use href='#b{BLOCKS - 1}'/></svg>"
    )


def eps_under_another_name(path):
    path.write_text(
        "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n%%EOF\n"
    )


def dxf_cut_off(path):
    path.write_text("0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n")


@pytest.mark.parametrize(
    ("name", "make", "reason"),
    [
        ("a.svg", os.mkfifo, "is a pipe"),
        ("a.dxf", lambda path: path.mkdir(), "is a folder"),
        ("a.png", lambda path: path.symlink_to("/dev/zero"), "is a device"),
        ("a.svg", lambda path: None, "No such file"),
        ("a.svg", lambda path: path.write_bytes(b""), "not an SVG file"),
        ("a.dxf", dxf_cut_off, "cannot be read"),
        ("a.png", eps_under_another_name, "not an image"),
        ("a.eps", eps_under_another_name, "not an image"),
    ],
)
def test_what_is_no_drawing_is_refused(name, make, reason, tmp_path):
    pytest.importorskip("svgelements")
    make(tmp_path / name)
    kind = "image" if name.endswith(("png", "eps")) else "drawing"
    width = ', width = "40 mm"' if kind == "image" else ""
    (tmp_path / "s.toml").write_text(SHEET.format(given=f'{kind} = "{name}"{width}'))
    with pytest.raises(InputError, match=rf"pattern\.{kind} = .*{name}.*{reason}") as raised:
        read_specimen(tmp_path / "s.toml")
    assert "\n" not in str(raised.value)


def test_a_drawing_without_an_end_is_given_up(tmp_path, monkeypatch):
    pytest.importorskip("svgelements")
    monkeypatch.setattr("bilayer.specimen.drawn.SHORTEST_TIME", 1.0)
    svg_of_blocks(tmp_path / "a.svg")
    (tmp_path / "s.toml").write_text(SHEET.format(given='drawing = "a.svg"'))
    with pytest.raises(InputError, match=r"a\.svg: cannot be read \(reading it "):
        read_specimen(tmp_path / "s.toml")
