"""
Against CalculiX
================

CalculiX is a finite-element program that shares no code, element or constraint with this one.
``bilayer export`` writes decks for it, and ``bilayer import`` reads its shapes. The files
``deck.*`` beside this example are what CalculiX 2.20 made of the paper's specimen on a mesh of
8 mm.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import bilayer

HERE = Path(sys.argv[0]).resolve().parent
folder = Path(tempfile.mkdtemp())
(folder / "specimen.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
command = [
    *(sys.executable, "-m", "bilayer", "import", HERE / "deck.frd", "specimen.toml"),
    *("--mesh-size", "8 mm", "--prestretch", "1.03", "-o", "ccx.nc"),
]
subprocess.run(command, cwd=folder, check=True)
theirs = bilayer.open_result(folder / "ccx.nc")

# %%
# The finite-element model on the same planar mesh:

ours = bilayer.solve(bilayer.result_specimen(theirs), "fenics", mesh=bilayer.result_mesh(theirs))
comparison = bilayer.compare(ours, theirs)
share = 100 * comparison["rms_distance_over_radius"].item()
print(f"rms distance {share:.2f} % of the radius")
assert share < 1.0

# %%
figure = bilayer.draw_isometric(theirs)
bilayer.save_figure(figure, "calculix.png")
