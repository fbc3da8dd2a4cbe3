"""CalculiX itself, where it is installed, on small decks."""

import shutil
import subprocess
from pathlib import Path

import pytest
from hexagon import hexagon_mesh, hexagon_specimen

from bilayer.calculix.deck import DeckSettings, write_decks
from bilayer.calculix.files import read_run_record
from bilayer.calculix.result import import_calculix

KEPT = Path(__file__).parent / "calculix"
CCX = Path(__file__).parents[2] / "scripts" / "ccx"
WHERE = subprocess.run([CCX, "--where"], capture_output=True, text=True, check=True).stdout
pytestmark = pytest.mark.skipif(
    "not built yet" in WHERE, reason="no CalculiX here yet: scripts/ccx -v makes it"
)


def run_ccx(deck):
    """Run a deck in its folder."""
    subprocess.run(
        [CCX, "-i", deck.stem], cwd=deck.parent, check=False, timeout=120, capture_output=True
    )


def test_two_natural_meshes_tied_together_are_the_bonded_body(tmp_path):
    """The numbers that the two blocks were found to give; nodes 6 and 10 are the tied pair."""
    deck = shutil.copy(KEPT / "two_natural_meshes.inp", tmp_path)
    run_ccx(Path(deck))
    rows = [line.split() for line in (tmp_path / "two_natural_meshes.dat").read_text().splitlines()]
    last = {row[0]: float(row[1]) for row in rows if len(row) == 4 and row[0].isdigit()}
    assert last["10"] == pytest.approx(-0.02682110, abs=1e-7)
    assert last["6"] == pytest.approx(0.08638645, abs=1e-7)


def test_the_kept_run_comes_out_again(tmp_path):
    specimen, mesh = hexagon_specimen(), hexagon_mesh()
    (deck,) = write_decks(specimen, mesh, tmp_path / "deck.inp", DeckSettings(element="wedge"))
    run_ccx(deck)
    kept, new = (
        import_calculix([path], specimen, mesh)["position"].values
        for path in (KEPT / "hexagon_1.06.frd", deck.with_suffix(".frd"))
    )
    assert new == pytest.approx(kept, abs=1e-6)


def test_a_deck_that_cannot_be_solved_is_read_as_such(tmp_path):
    specimen, mesh = hexagon_specimen((1.3,)), hexagon_mesh()
    large = DeckSettings(
        element="wedge", first_increment=0.5, smallest_increment=0.5, largest_increment=0.5
    )
    (deck,) = write_decks(specimen, mesh, tmp_path / "deck.inp", large)
    run_ccx(deck)
    assert read_run_record(deck).failed_increment == 1
    result = import_calculix([deck.with_suffix(".frd")], specimen, mesh)
    assert "gave up in increment 1 at c = 0" in result.attrs["stop_reason"]
