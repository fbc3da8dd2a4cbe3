"""The tables [obstacles.NAME] of a specimen file."""

from pathlib import Path

import pytest

from bilayer import InputError, PlaneObstacle, SphereObstacle, parse_specimen
from bilayer.specimen.toml import specimen_to_toml, template

TEXT = (Path(__file__).parents[2] / "examples" / "on_a_table.toml").read_text()
BALL = """
[obstacles.ball]
shape = "sphere"
centre = ["20 mm", 0, "-15 mm"]
radius = "10 mm"
"""
WALL = """
[obstacles.wall]
shape = "plane"
point = ["25 mm", 0, 0]
normal = [-2, 0, 0]
"""


def test_a_file_with_obstacles_reads_back_as_the_same():
    specimen = parse_specimen(TEXT + BALL + WALL)
    table, ball, wall = specimen.obstacles
    assert table == PlaneObstacle("table")
    assert ball == SphereObstacle("ball", (0.02, 0.0, -0.015), 0.01)
    assert wall == PlaneObstacle("wall", (0.025, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert parse_specimen(specimen_to_toml(specimen)) == specimen
    assert specimen.is_laid
    assert specimen.is_placed


def test_the_short_form_has_them_too():
    specimen = parse_specimen(template() + BALL)
    assert specimen.obstacles[0].name == "ball"
    assert not specimen.is_laid
    assert parse_specimen(specimen_to_toml(specimen)) == specimen
    assert "[substrate]" in specimen_to_toml(specimen)


def test_one_key_can_be_replaced():
    specimen = parse_specimen(TEXT + BALL, ["obstacles.ball.radius='8 mm'"])
    assert specimen.obstacles[1].radius == 0.008


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"sphere"', '"cube"'), r"obstacles.ball.shape = 'cube': expected .*plane.*sphere"),
        (('shape = "sphere"', ""), r"obstacles.ball.shape: missing, expected 'plane' or 'sphere'"),
        (('radius = "10 mm"', ""), r"obstacles.ball.radius: missing"),
        (('radius = "10 mm"', "radius = -1"), r"obstacles.ball.radius = -1"),
        (('radius = "10 mm"', 'radios = "1 mm"'), r"obstacles.ball.radios: unknown key, .*radius"),
        (('"20 mm", 0, ', '"20 mm", '), r"obstacles.ball.centre = .*expected \[x, y, z\]"),
        (("[-2, 0, 0]", "[0, 0, 0]"), r"obstacles.wall.normal = .*expected not all of them 0"),
        (('point = ["25 mm", 0, 0]', ""), r"obstacles.wall.*point: missing.* not level"),
        (("obstacles.wall", 'obstacles."a b"'), r"obstacles.*'a b'.*expected a name"),
        (('acceleration = "9.81 m/s^2"', "acceleration = 0"), r"obstacles.table: .*by its weight"),
        (("[obstacles.ball]", "[obstacles]\nball = 3\n[obstacles.b]"), r"obstacles.ball = 3"),
    ],
)
def test_what_is_wrong_is_named(change, message):
    text = TEXT.replace("[obstacles.table]             # no", "[obstacles.table] # no")
    if change[0] == "[obstacles.ball]":
        text = text[: text.index("[obstacles.table]")]
        text, wall = text, ""
    else:
        wall = WALL
    whole = text + BALL + wall
    assert change[0] in whole
    with pytest.raises(InputError, match=message):
        parse_specimen(whole.replace(*change))
