"""
Stretched more along one direction
==================================

A milestone may be a pair of stretches along x and y. Without cuts, a disc that is stretched along x
alone rolls up along x, into a part of a cylinder.
"""

from dataclasses import replace

import bilayer

specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=None)
specimen = replace(specimen, mesh=bilayer.MeshSize(0.005))
result = bilayer.solve(specimen.with_milestones([(1.02, 1.0), (1.05, 1.0)]), "dshell")

# %%
# Along x the body becomes shorter by rolling up. Along y it keeps its length but for Poisson's
# ratio.

span = 1e3 * result["span"].isel(prestretch=-1)
print(span.to_pandas().round(1))
along_x, along_y = float(span.sel(xyz="x")), float(span.sel(xyz="y"))
assert along_x < 70.0
assert abs(along_y - 80.0) < 3.0

# %%
figure = bilayer.draw_shapes(result)
bilayer.save_figure(figure, "anisotropic.png")
