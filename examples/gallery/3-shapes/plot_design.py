"""
A sheet for a wanted shape
==========================

``bilayer.design`` goes the other way round: it looks for the sheet that becomes a wanted shape.
Here the prestretch, the thickness of the kirigami layer and the angle of the cutouts are free, and
a hemisphere is wanted. Eight evaluations on a coarse mesh are enough to see it work;
``examples/design_hemisphere.toml`` is a whole search.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import bilayer

sheet = replace(bilayer.paper_specimen().with_milestones([1.06]), mesh=bilayer.MeshSize(0.010))
folder = Path(tempfile.mkdtemp())
(folder / "sheet.toml").write_text(bilayer.specimen_to_toml(sheet))
(folder / "design.toml").write_text(
    """
specimen = "sheet.toml"
target = { shape = "hemisphere" }
search = { evaluations = 8 }

[free]
prestretch = [1.02, 1.3]
"kirigami.thickness" = ["0.5 mm", "2 mm"]
"kirigami.pattern.cutout_angle" = ["5 deg", "30 deg"]
"""
)
outcome = bilayer.design(folder / "design.toml", folder / "dome")

# %%
# The distance from the hemisphere of the sheet's meridian has fallen by a third and more.

before = bilayer.solve(sheet, "dshell")
after = bilayer.solve(outcome.specimen, "dshell")
first, last = (result["hemisphere_distance"].item() for result in (before, after))
print(f"hemisphere distance {first:.2f} before, {last:.2f} after")
assert last < 2 / 3 * first

# %%
figure = bilayer.draw_shapes(after)
bilayer.save_figure(figure, "design.png")
