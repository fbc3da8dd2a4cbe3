"""
All stable shapes of a sheet
============================

Six strips have several stable shapes at a prestretch of 1.15. ``bilayer.states`` starts from many
shapes, goes downhill from each, and keeps the stable ones that it comes to. Shapes that the
symmetry of the sheet brings onto each other count once. Eight starts are too few to be sure; the
default is 60.
"""

from dataclasses import replace

import bilayer

cuts = bilayer.CutPattern(strips=6, inner_radius=0.008, cutout_angle=0.3)
specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=cuts).with_milestones([1.15])
found = bilayer.states(replace(specimen, mesh=bilayer.MeshSize(0.010)), starts=8)

# %%
# The states come in the order of their energies. Each is stable.

energies = 1e3 * found["energy"].sum("term").values
for energy, times in zip(energies, found["times_found"].values, strict=True):
    print(f"{energy:.3f} mJ, found {times} times")
assert len(energies) >= 3
assert (energies[1:] > energies[:-1]).all()
assert (found["unstable_modes"] == 0).all()

# %%
figure = bilayer.draw_isometric(found)
bilayer.save_figure(figure, "states.png")
