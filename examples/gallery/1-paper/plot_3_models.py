"""
Three shells against the finite elements
========================================

Figure 6 of the paper holds its shell against its finite-element model. Here the three shells are
held against the finite-element model on one coarse mesh. ``morley`` is the accurate one. ``paper``
is the shell as the report prints it, with its known errors: it bends too much, and can only serve
as a baseline.
"""

from dataclasses import replace

import bilayer

specimen = bilayer.paper_specimen().with_milestones([1.03, 1.06])
specimen = replace(specimen, mesh=bilayer.MeshSize(0.008))
mesh = bilayer.generate_mesh(specimen)
reference = bilayer.solve(specimen, "fenics", mesh=mesh)

# %%
# Every result of one mesh can be compared with every other: the distance is that of the reference
# surfaces after the best rigid motion.

models = [bilayer.MorleySettings(), bilayer.HingeSettings(), bilayer.PaperSettings()]
shells = [bilayer.solve(specimen, "dshell", model, mesh=mesh) for model in models]
comparisons = [bilayer.compare(reference, shell) for shell in shells]
for comparison in comparisons:
    share = 100 * comparison["rms_distance_over_radius"].sel(prestretch=1.03).item()
    print(f"{comparison.attrs['second']}: {share:.2f} % of the radius at 1.03")

# %%
# The accurate shell is the nearest one, and is within 1 % of the radius.

distances = [float(c["rms_distance_over_radius"].sel(prestretch=1.03)) for c in comparisons]
assert distances[0] == min(distances)
assert distances[0] < 0.01

# %%
figure = bilayer.draw_distances(comparisons)
bilayer.save_figure(figure, "models.png")
