"""The finite-element model is started from the pass between two states of the shell."""

from pathlib import Path

import pytest

pytest.importorskip("dolfinx")

import bilayer
from bilayer.landscape.confirm_barrier import confirm_barrier, describe_confirmed, is_confirmed

LOTUS = Path(__file__).parents[2] / "examples" / "trilayer_lotus.toml"


@pytest.fixture(scope="module")
def way():
    """The way between the mirror states of a thin trilayer, over the flat shape."""
    sheet = bilayer.read_specimen(LOTUS, ["mesh.size=6 mm"]).with_milestones([1.05])
    for name, thickness in (("lower", 0.2e-3), ("substrate", 0.55e-3), ("upper", 0.2e-3)):
        sheet = sheet.with_layer(name, thickness=thickness)
    return bilayer.barrier(bilayer.states(sheet, starts=6), 0, 1, images=3, rounds=2)


def test_the_pass_of_the_shell_is_one_of_the_solid(way):
    confirmed = confirm_barrier(way)
    up, back = confirmed.attrs["confirmed_barrier"], confirmed.attrs["confirmed_barrier_back"]
    assert confirmed.attrs["confirmed_saddle_modes"] == 1
    assert up == pytest.approx(back, rel=1e-6)
    assert up == pytest.approx(way.attrs["barrier"], rel=0.05)
    assert is_confirmed(confirmed)
    assert describe_confirmed(confirmed).endswith("with 1 unstable mode")


@pytest.mark.parametrize("modes", [0, 3])
def test_an_equilibrium_with_other_modes_confirms_nothing(way, modes):
    found = {"confirmed_barrier": 1e-6, "confirmed_barrier_back": 1e-6, "confirmed_by": "fenics"}
    other = way.assign_attrs(confirmed_saddle_modes=modes, **found)
    assert not is_confirmed(other)
    assert "NOT CONFIRMED: the shell's saddle has 1" in describe_confirmed(other)


def test_a_way_without_a_saddle_cannot_be_confirmed(way):
    with pytest.raises(bilayer.InputError, match="has no saddle"):
        confirm_barrier(way.assign_attrs(saddle_modes=-1))
