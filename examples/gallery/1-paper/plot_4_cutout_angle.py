"""
A study of the cutout angle
===========================

Figure 5a of the paper: how the quality depends on the angle of the cutouts. A study computes many
specimens from one file. It keeps each result when it is finished, so a second start goes on where
the first one ended.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import bilayer

folder = Path(tempfile.mkdtemp())
(folder / "specimen.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
(folder / "study.toml").write_text(
    """
specimen = "specimen.toml"
solver = "dshell"

[vary]
"mesh.size" = [0.007]
"cut.cutout_angle" = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
"prestretch.milestones" = [1.06, 1.12]
"""
)
command = [sys.executable, "-m", "bilayer", "study", "study.toml", "-o", "study", "--quiet"]
subprocess.run(command, cwd=folder, check=True)

# %%
# The whole study is one dataset. Fields that vary are its dimensions.

study = bilayer.open_study(folder / "study")
quality = study["quality"].squeeze("mesh.size")
print(quality.to_pandas().round(3))

# %%
# At 1.12 narrow cutouts keep the disc from becoming a dome: it rolls up instead. From 0.3 rad on it
# comes near a hemisphere.

far = quality.sel(prestretch=1.12)
assert float(far.sel({"cut.cutout_angle": 0.1})) > 0.6
assert float(far.sel({"cut.cutout_angle": 0.4})) < 0.3

# %%
# Domes and rolled sheets are different branches, so no line joins them: nothing between them was
# computed. ``bilayer plot-study`` leaves such gaps by itself.

figure, axes = plt.subplots(figsize=(4.8, 3.6), layout="constrained")
for prestretch in (1.06, 1.12):
    values = quality.sel(prestretch=prestretch)
    angle, domes = values["cut.cutout_angle"], values.where(values < 0.6)
    (line,) = axes.plot(angle, domes, "o-", label=f"prestretch {prestretch}, domes")
    rolled = values.where(values >= 0.6)
    if rolled.notnull().any():
        look = {"color": line.get_color(), "markerfacecolor": "white"}
        axes.plot(angle, rolled, "o--", **look, label=f"prestretch {prestretch}, rolled up")
axes.set(xlabel="cutout angle (rad)", ylabel="quality (0: hemisphere, 1: flat)")
axes.legend()
figure.savefig("cutout_angle.png")
