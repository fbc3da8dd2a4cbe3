"""
A lotus of ten petals
=====================

A sheet that is described in Python alone: layers from the bottom up, each with a thickness, a law,
a pattern and what the prestretch does to it. Materials and sizes are those of published bistable
sheets.
"""

import math

import bilayer

soft = bilayer.MooneyRivlin(c10=22.06e3, c01=1.656e3, d1=1e-5)
stiff = bilayer.MooneyRivlin(c10=17.88e3, c01=84.45e3, d1=1e-5)
lotus = bilayer.CutPattern(strips=10, inner_radius=0.011, cutout_angle=math.radians(14.4))
specimen = bilayer.Specimen(
    bilayer.Disc(0.020),
    [
        bilayer.Layer("substrate", 1.1e-3, soft, response=bilayer.Response("path")),
        bilayer.Layer("kirigami", 1.6e-3, stiff, pattern=lotus),
    ],
    bilayer.Prestretch([1.05, 1.1, 1.2, 1.3]),
    bilayer.MeshSize(0.0025),
    name="lotus",
)
result = bilayer.solve(specimen, "dshell")

# %%
# Half of the height and more comes with the first tenth of the stretch.

height = 1e3 * result["height"]
print(height.to_pandas().round(2))
assert (height.diff("prestretch") > 0).all()

# %%
figure = bilayer.draw_shapes(result)
bilayer.save_figure(figure, "lotus.png")
