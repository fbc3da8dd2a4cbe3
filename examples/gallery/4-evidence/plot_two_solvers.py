"""
Two solvers, one sheet
======================

The shell and the finite-element model share nothing but the planar mesh. Where they agree, a shape
can be trusted. The square with a cross is 2.7 mm thick, 12 % of its characteristic length: a shell
stands for thin sheets, and the distance shows it.
"""

import sys
from pathlib import Path

import bilayer

EXAMPLES = Path(sys.argv[0]).resolve().parents[2]
specimen = bilayer.read_specimen(EXAMPLES / "square_cross.toml", ["mesh.size='4 mm'"])
specimen = specimen.with_milestones([1.03, 1.06])
mesh = bilayer.generate_mesh(specimen)
solid = bilayer.solve(specimen, "fenics", mesh=mesh)
shell = bilayer.solve(specimen, "dshell", mesh=mesh)

# %%
comparison = bilayer.compare(solid, shell)
share = 100 * comparison["rms_distance_over_radius"]
print(share.to_pandas().round(2))
assert (share < 2.0).all()

# %%
figure = bilayer.draw_comparison(comparison)
bilayer.save_figure(figure, "two_solvers.png")
