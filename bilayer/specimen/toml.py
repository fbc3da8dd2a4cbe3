"""The specimen as a TOML file, read and written.

A file has one of two forms: `[cut] [substrate] [kirigami]`, short, for the disc of two layers, and
`[[layers]] [patterns.NAME] [materials.NAME]` for any other sheet. The tables and keys are the
public contract of the project; `template()` is the commented example of the short form.
"""

from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w

from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text
from bilayer.runtime.terminal import Notice, keep_quiet
from bilayer.specimen.drawn import with_drawings
from bilayer.specimen.drawn_reach import check_reach
from bilayer.specimen.long_form import LONG_TABLES, sheet_from_tables, sheet_to_tables
from bilayer.specimen.overrides import with_overrides
from bilayer.specimen.short_form import (
    bilayer_from_tables,
    bilayer_of,
    bilayer_to_tables,
    short_tables,
)
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.tables import as_table
from bilayer.specimen.toml_text import parse_toml
from bilayer.specimen.units import UNITS
from bilayer.validation import nearest

USUAL_SIZES = (1e-4, 1.0)
"""Half of a width or height of a sheet that is taken without a question, m."""


def template() -> str:
    """Return the commented TOML text of the paper's specimen."""
    return files("bilayer.specimen").joinpath("paper.toml").read_text(encoding="utf-8")


def paper_specimen() -> Specimen:
    """Return the paper's specimen (section V), as the template states it.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.paper_specimen().outline
    Disc(radius=0.04)
    """
    return parse_specimen(template())


def read_specimen(
    path: str | Path, overrides: Iterable[str] = (), *, notice: Notice = keep_quiet
) -> Specimen:
    """Read a specimen from a TOML file.

    Parameters
    ----------
    path : path-like
        The file.
    overrides : iterable of str
        `"table.key=value"` texts that replace or add single keys, the value written as in TOML.
    notice : callable
        Called with a line of text if something of the file was left out: small parts of an image,
        what is drawn beyond the sheet.

    Raises
    ------
    InputError
        The file is missing or malformed, a key is unknown, or a value is out of its range.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "a.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
    >>> bilayer.read_specimen(folder / "a.toml", ["mesh.size='6 mm'"]).mesh.size
    0.006
    """
    _check_ending(Path(path))
    text = read_text(path, "specimen file")
    return parse_specimen_file(text, overrides, str(path), Path(path).parent, notice)


OTHER_FILES = {
    (".nc", ".nc4", ".cdf"): "a result, which `bilayer info`, `plot` and `rerun` take",
    (".svg", ".dxf"): 'a drawing, which a specimen file names: pattern = { drawing = "FILE" }',
    (".png", ".jpg", ".jpeg", ".bmp"): 'an image, which one names: pattern = { image = "FILE" }',
    (".msh", ".vtu", ".stl", ".obj", ".ply"): "a mesh, which `--mesh` takes beside a specimen file",
}
"""Files that are taken for a specimen's by mistake, by their endings."""


def _check_ending(path: Path) -> None:
    """Raise InputError if a file has the ending of another kind."""
    for endings, words in OTHER_FILES.items():
        if path.suffix.lower() in endings:
            raise InputError(f"specimen file {path}: expected TOML, not {words}")


def parse_specimen_file(
    text: str,
    overrides: Iterable[str] = (),
    source: str = "specimen text",
    folder: Path | None = None,
    notice: Notice = keep_quiet,
) -> Specimen:
    """Read a specimen from the text of a user's file; see `read_specimen`.

    Drawings that it names lie in `folder`; without one it may name none.

    Unlike `parse_specimen` it asks, by an InputError, whether the unit is meant if a sheet of
    more than a metre or less than 0.1 mm is written without one.
    """
    tables = _tables(text, overrides, source)
    data = with_drawings(tables, folder, notice)
    specimen = specimen_from_tables(data)
    check_reach(tables, specimen, notice)
    x, y, far_x, far_y = specimen.outline.polygon.bounds
    width, height = far_x - x, far_y - y
    smallest, largest = USUAL_SIZES
    usual = 2 * smallest <= min(width, height) and max(width, height) <= 2 * largest
    if not usual and not _has_units(data["specimen"]):
        raise InputError(
            f"specimen: the sheet is {width:g} m wide and {height:g} m high, a bare number is in "
            f"metres: is that meant? expected from {2 * smallest:g} to {2 * largest:g} m, or a "
            'unit with each length, as in "40 mm"'
        )
    _check_thickness(specimen)
    return specimen


def _check_thickness(specimen: Specimen) -> None:
    """Raise InputError if a layer is thicker than the sheet is wide: a forgotten unit, mostly."""
    for layer in specimen.layers:
        if layer.thickness > specimen.characteristic_length:
            raise InputError(
                f"{layer.name}.thickness = {layer.thickness:g} m: expected at most "
                f"{specimen.length_text}; a bare number is in metres"
            )


def parse_specimen(
    text: str, overrides: Iterable[str] = (), source: str = "specimen text"
) -> Specimen:
    """Read a specimen from TOML text; see `read_specimen`.

    Examples
    --------
    >>> import bilayer
    >>> text = bilayer.specimen_to_toml(bilayer.paper_specimen())
    >>> bilayer.parse_specimen(text, ["substrate.thickness='0.8 mm'"]).layer("substrate").thickness
    0.0008
    """
    return specimen_from_tables(with_drawings(_tables(text, overrides, source), None))


def specimen_from_tables(data: Mapping[str, Any]) -> Specimen:
    """Return the specimen of parsed TOML tables; see `read_specimen` for what is raised."""
    short, is_long = short_tables(), "layers" in data
    known: Mapping[str, Any] = LONG_TABLES if is_long else short
    for table, content in data.items():
        if table not in known:
            raise InputError(_why_unknown(table, known, is_long))
        if table != "layers":
            as_table(table, content)
    return sheet_from_tables(data) if is_long else bilayer_from_tables(data)


def specimen_to_toml(specimen: Specimen) -> str:
    """Return the TOML text that reads back as the same specimen, the short form if it can be.

    Materials are written by the constants that they hold, so that no digit is lost.

    Examples
    --------
    >>> import bilayer
    >>> print(bilayer.specimen_to_toml(bilayer.paper_specimen())[:10])
    [specimen]
    """
    bilayer = bilayer_of(specimen)
    if bilayer is None:
        return tomli_w.dumps(sheet_to_tables(specimen))
    return tomli_w.dumps(bilayer_to_tables(specimen, bilayer))


def _tables(text: str, overrides: Iterable[str], source: str) -> dict[str, Any]:
    data = parse_toml(text, source)
    forms = (short_tables(), LONG_TABLES)
    known = {
        table: dict.fromkeys(key for form in forms for key in form.get(table, ()))
        for form in forms
        for table in form
    }
    return with_overrides(data, overrides, known)


def _why_unknown(table: str, known: Iterable[str], is_long: bool) -> str:
    if is_long and table in short_tables():
        return f"[{table}]: not together with [[layers]], expected it as one of them"
    if not is_long and table in LONG_TABLES:
        return f"[{table}]: expected together with [[layers]], of which there are none"
    listed = f"expected [{'], ['.join(known)}]"
    return f"[{table}]: unknown table, {listed}{nearest(table, known)}"


def _has_units(sheet: Mapping[str, Any]) -> bool:
    """Whether every length of the outline is a text."""
    lengths = {**sheet, **sheet.get("outline", {})}
    given = [value for key, value in lengths.items() if UNITS.get(key) == "m"]
    return bool(given) and all(isinstance(value, str) for value in given)
