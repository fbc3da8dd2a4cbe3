"""Study files of cases that take a fraction of a second: the printed shell, a few time steps."""

from bilayer.specimen.toml import template

QUICK = """
specimen = "specimen.toml"
solver = "dshell"
[settings.dshell]
model = "paper"
total_time = 0.002
"""


def write_study(folder, text):
    """Write a specimen and a study file; return the study file's path."""
    coarse = template().replace("size = 0.003", "size = 0.016")
    two = coarse.replace("[1.03, 1.06, 1.09, 1.12, 1.15, 1.18, 1.21, 1.24]", "[1.03, 1.06]")
    (folder / "specimen.toml").write_text(two)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def log_lines(folder, event):
    """Return the cases of a study's log with this event, one for each line."""
    lines = (folder / "study.log").read_text().splitlines()
    return [line.split("\t")[2] for line in lines if line.split("\t")[1] == event]
