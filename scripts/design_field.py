"""A design with a field of density, and what becomes of it when it is cut out: a table.

The cut files of the design are read back as drawings, and the sheet is meshed anew. The shell
computes both; the row of the finite-element model is the design's last check. A design that is
finished is read from its folder; one that is not goes on.
"""

import argparse
from pathlib import Path

import bilayer
from bilayer.designing.distance import TargetDistance
from bilayer.designing.fields import cut_out, field_layers
from bilayer.designing.height_image import similarity
from bilayer.designing.report import PARTS, write_design
from bilayer.designing.run import DesignOutcome
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.schema import result_mesh

HEADS = (
    "shape", "rms (% of diagonal)", "mean (%)", "largest (%)", "SSIM, of a cap, flat", "triangles",
)  # fmt: skip
CUT_BACK = "cut-and-read-back.toml"


def read_back(outcome: DesignOutcome, folder: Path) -> bilayer.Specimen:
    """Return the design with the drawings of its cut files in place of its fields."""
    stretch = outcome.specimen.prestretch.milestones[-1]
    file = folder / CUT_BACK
    file.write_text(bilayer.specimen_to_toml(cut_out(outcome.specimen)), encoding="utf-8")
    stem = Path(PARTS).stem
    drawings = [
        f"layers.{name}.pattern={{ drawing = '{stem}-{name}.dxf', layer = 'cut', what = 'kept' }}"
        for name in field_layers(outcome.specimen)
    ]
    return bilayer.read_specimen(file, drawings).with_milestones([stretch])


def row(outcome: DesignOutcome, words: str, surface: Surface, mesh: PlanarMesh) -> str:
    """Return the row of a shape."""
    target = outcome.task.target
    away = TargetDistance(target.surface, target.is_size_free).measure_anew(surface)
    seen = similarity(target.surface, surface, flat_surface(mesh))
    shares = [100 * each / target.diagonal for each in (away.rms, away.mean, away.largest)]
    cells = (
        words,
        *(f"{share:.2f}" for share in shares),
        f"{seen.shape:.2f}, {seen.plain_cap:.2f}, {seen.flat:.2f}",
        f"{len(mesh.triangles)}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", help="a design file")
    parser.add_argument("folder", type=Path, help="its folder")
    options = parser.parse_args()
    outcome = bilayer.design(options.design, options.folder)
    write_design(outcome, options.folder)
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    field = outcome.from_flat.shapes[0].position
    print(row(outcome, "field, shell", Surface(field, outcome.mesh.triangles), outcome.mesh))
    cut = bilayer.solve(read_back(outcome, options.folder), "dshell")
    mesh = result_mesh(cut)
    surface = Surface(cut["position"].values[-1], mesh.triangles)
    print(row(outcome, "cut out and read back, shell", surface, mesh), flush=True)
    for check in outcome.checks:
        print(row(outcome, "cut out, finite elements", check.surface, check.mesh))
    if outcome.check_failure:
        print(f"\n{outcome.check_failure}")


if __name__ == "__main__":
    main()
