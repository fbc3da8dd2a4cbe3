"""
A trilayer lotus stays flat
===========================

A stretched substrate between two equal lotus layers (``examples/trilayer_lotus.toml``). What the
upper layer does, the lower one undoes: the flat sheet only shrinks. Nothing is wrong with such a
result.
"""

import sys
from pathlib import Path

import bilayer

EXAMPLES = Path(sys.argv[0]).resolve().parents[2]
specimen = bilayer.read_specimen(EXAMPLES / "trilayer_lotus.toml", ["mesh.size='2.5 mm'"])
flat = bilayer.solve(specimen.with_milestones([1.1, 1.2]), "dshell")
assert float(abs(flat["height"]).max()) < 1e-9
assert float(flat["span"].sel(xyz="x").isel(prestretch=-1)) < 0.040

# %%
# A lower layer of half the thickness breaks the balance.

specimen = specimen.with_layer("lower", thickness=0.8e-3)
result = bilayer.solve(specimen.with_milestones([1.1, 1.2]), "dshell")
height = 1e3 * float(result["height"].isel(prestretch=-1))
print(f"height at 1.2: {height:.2f} mm")
assert height > 1.0

# %%
figure = bilayer.draw_isometric(result)
bilayer.save_figure(figure, "trilayer.png")
