"""
Cuts from your own drawing
==========================

An SVG or DXF drawing gives the outline on one layer and the cuts on another
(``examples/own_drawing.toml``, ``examples/petals.svg``). Any drawing program can make one.
"""

import sys
from pathlib import Path

import bilayer

EXAMPLES = Path(sys.argv[0]).resolve().parents[2]
specimen = bilayer.read_specimen(EXAMPLES / "own_drawing.toml", ["mesh.size='5 mm'"])
figure = bilayer.draw_mesh(bilayer.generate_mesh(specimen))

# %%
# The picture of the mesh shows what was understood: look at it before you solve.

result = bilayer.solve(specimen, "dshell")
height = 1e3 * result["height"].sel(prestretch=1.03).item()
print(f"height at 1.03: {height:.1f} mm")
assert 18.0 < height < 20.0

# %%
shapes = bilayer.draw_isometric(result)
bilayer.save_figure(shapes, "own_drawing.png")
