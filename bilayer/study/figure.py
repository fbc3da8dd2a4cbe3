"""A study as a picture: one quantity over one field, a line for each value of another.

What cannot be taken as it stands is marked: unstable shapes, bodies that touch themselves, and
milestones that were not reached.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bilayer.errors import InputError
from bilayer.figures.branch_changes import branch_changes, line_with_gaps
from bilayer.figures.caveat_marks import mark_caveats
from bilayer.figures.quality import PRESTRETCH_LABEL, QUALITY_LABEL
from bilayer.figures.result_looks import result_looks
from bilayer.figures.style import (
    RESULT_COLOURS,
    RESULT_MARKERS,
    axes_for,
    label_text,
    legend_for,
    new_figure,
    print_style,
)
from bilayer.results.caveats import is_unstable, touches_itself
from bilayer.specimen.units import in_si
from bilayer.validation import finite, nearest, one_of

LABELS = {"quality": QUALITY_LABEL, "prestretch": PRESTRETCH_LABEL}
FIELD_UNITS = {
    "outer_radius": "m", "inner_radius": "m", "cutout_angle": "rad", "thickness": "m", "size": "m",
    "corner_size": "m", "young_modulus": "Pa", "c10": "Pa", "c01": "Pa", "d1": "1/Pa",
    "density": "kg/m³", "acceleration": "m/s²",
}  # fmt: skip
"""Units of the specimen's fields, by the last part of the dotted name."""
SHOWN_UNITS = {"m": (1e3, "mm"), "Pa": (1e-3, "kPa")}
"""Units in which lengths and moduli are drawn, with the factor to them."""
DESCRIBING = ("quality", "hemisphere_distance")
"""Measures of the order of one by which a change of branch is seen."""
NOT_A_NAME = ("identity", "case_file", "xyz")


def draw_study(
    study: xr.Dataset,
    x: str,
    y: str,
    hue: str | None = None,
    chosen: Mapping[str, Any] | None = None,
    ax: Axes | None = None,
    kind: str = "lines",
) -> Figure:
    """Draw a scalar of a study over one of its fields.

    A line has a gap where the shapes change to another branch, and where one was not reached.

    Parameters
    ----------
    study : Dataset
        From `bilayer.open_study`.
    x : str
        A varied field, `prestretch`, `solver` or `model`: along.
    y : str
        A scalar of the results, such as `quality`: up.
    hue : str, optional
        Like `x`: a line for each of its values.
    chosen : mapping, optional
        Values of other fields, those that are drawn.
    ax : Axes, optional
        Where to draw; a new figure if left out.
    kind : {"lines", "panels", "map"}
        All lines in one panel, a panel for each value of `hue`, or a coloured cell for each pair of
        values; the last two where lines of different branches cross.

    Raises
    ------
    InputError
        A name is unknown, or several cases fall on one point of a line: a field is to be chosen.
    """
    table = study_table(study, x, y, hue, chosen or {})
    drawn = _Drawn(study, table, x, y, hue)
    with print_style():
        figure = DRAWINGS[one_of("--as", kind, DRAWINGS)](drawn, ax)
        fixed = {name: value for name, value in (chosen or {}).items() if name not in (x, hue)}
        title = ", ".join(_value_text(name, value) for name, value in fixed.items())
        if title and kind == PANELS:
            figure.suptitle(label_text(title), fontsize=9)
        elif title:
            (ax or figure.axes[0]).set_title(label_text(title))
    return figure


@dataclass(frozen=True)
class _Drawn:
    """What is drawn of a study: the rows of its table, and which columns."""

    study: xr.Dataset
    table: pd.DataFrame
    x: str
    y: str
    hue: str | None

    @property
    def lines(self) -> list[tuple[Any, pd.DataFrame]]:
        """The rows of each value of the hue; all of them without one."""
        return [("", self.table)] if self.hue is None else list(self.table.groupby(self.hue))

    @property
    def x_label(self) -> str:
        return label_text(LABELS.get(self.x, _with_unit(self.x, _field_unit(self.x))))

    @property
    def y_label(self) -> str:
        unit = self.study[self.y].attrs.get("units", "1")
        return label_text(LABELS.get(self.y, _with_unit(self.y, unit)))

    def draw_line(self, axes: Axes, k: int) -> None:
        """Draw the line of one value of the hue."""
        value, line = self.lines[k]
        look = _line_style(k, len(self.lines))
        label = label_text(self.y if self.hue is None else _value_text(self.hue, value))
        if self.hue == "model":
            known = result_looks([f"{line['solver'].iloc[0]} {value}"])[0]
            look, label = known.style, known.name
        axes.plot(*_with_gaps(line, self.x, self.y), label=label, clip_on=False, **look)

    def finish(self, axes: Axes) -> None:
        """Set limits, ticks and grid."""
        if self.y == "quality":
            axes.set_ylim(0, 1)
        if pd.api.types.is_integer_dtype(self.table[self.x]):
            axes.set_xticks(sorted(self.table[self.x].unique()))
        axes.grid(True)
        axes.margins(x=0.05)


def _draw_lines(drawn: _Drawn, ax: Axes | None) -> Figure:
    """Draw all lines into one panel."""
    figure, axes = axes_for(ax, 5.2, 4.0)
    for k in range(len(drawn.lines)):
        drawn.draw_line(axes, k)
    _mark(axes, drawn.table, drawn.x, drawn.y)
    axes.set_xlabel(drawn.x_label)
    axes.set_ylabel(drawn.y_label)
    drawn.finish(axes)
    legend_for(figure, ax, axes, 3)
    return figure


def _draw_panels(drawn: _Drawn, ax: Axes | None) -> Figure:
    """Draw a panel for each line, all with the same axes: small multiples."""
    if drawn.hue is None or ax is not None:
        raise InputError("--as panels: expected a --hue, and no axes: it draws several")
    columns = min(len(drawn.lines), PANELS_IN_A_ROW)
    rows = -(-len(drawn.lines) // columns)
    figure = new_figure(1.9 * columns + 0.6, 1.7 * rows + 0.6)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for k, (value, line) in enumerate(drawn.lines):
        axes = panels.flat[k]
        drawn.draw_line(axes, k)
        _mark(axes, line, drawn.x, drawn.y)
        drawn.finish(axes)
        axes.set_title(label_text(_value_text(drawn.hue, value)))
    for axes in panels.flat[len(drawn.lines) :]:
        axes.set_visible(False)
    named = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels.flat]
    marks = {name: handle for pairs in named for handle, name in pairs if name in MARKS}
    if marks:
        figure.legend(marks.values(), marks.keys(), loc="outside upper right", ncols=3)
    figure.supxlabel(drawn.x_label, fontsize=9)
    figure.supylabel(drawn.y_label, fontsize=9)
    return figure


def _draw_map(drawn: _Drawn, ax: Axes | None) -> Figure:
    """Draw a coloured cell for each pair of values."""
    if drawn.hue is None:
        raise InputError("--as map: expected a --hue, the field of the vertical axis")
    cells = drawn.table.pivot(index=drawn.hue, columns=drawn.x, values=drawn.y)
    width, height = (0.62 * count + 2.0 for count in cells.shape[::-1])
    figure, axes = axes_for(ax, width, height)
    image = axes.imshow(cells.to_numpy(dtype=float), cmap="viridis", origin="lower", aspect="auto")
    figure.colorbar(image, ax=axes, label=drawn.y_label)
    along = {value: place for place, value in enumerate(cells.columns)}
    up = {value: place for place, value in enumerate(cells.index)}
    placed = drawn.table.assign(
        **{drawn.x: drawn.table[drawn.x].map(along), drawn.y: drawn.table[drawn.hue].map(up)}
    )
    axes.set_xticks(list(along.values()), [_tick(value) for value in along])
    axes.set_yticks(list(up.values()), [_value_text(drawn.hue, value) for value in up])
    axes.set_xlabel(drawn.x_label)
    mark_caveats(
        axes, placed[drawn.x], placed[drawn.y], placed["unstable"], placed["touches_itself"]
    )
    missing = placed[placed["converged"] != 1]
    if len(missing):
        axes.plot(missing[drawn.x], missing[drawn.y], "x", color="0.3", label="not reached")
    if axes.get_lines() and ax is None:
        figure.legend(loc="outside upper center", ncols=3)
    return figure


def _tick(value: Any) -> str:
    return label_text(f"{value:g}" if isinstance(value, (int, float)) else value)


PANELS = "panels"
DRAWINGS = {"lines": _draw_lines, PANELS: _draw_panels, "map": _draw_map}
"""By the option `--as`."""
PANELS_IN_A_ROW = 4
MARKS = ("unstable", "touches itself", "not reached")
"""What is against a point, as legends have it."""


def study_table(
    study: xr.Dataset, x: str, y: str, hue: str | None, chosen: Mapping[str, Any]
) -> pd.DataFrame:
    """Return the rows that are drawn, in the units that are drawn; see `draw_study`.

    Returns
    -------
    DataFrame
        Columns `x`, `hue`, `y`, `solver`, `converged`, `unstable`, `touches_itself`, and the
        measures of `DESCRIBING`.
    """
    names = [str(name) for name in study.coords if name not in NOT_A_NAME]
    for option, name in (("x", x), ("hue", hue), *(("select", name) for name in chosen)):
        _check_known(option, name, names)
    scalars = [str(name) for name in study.data_vars if _is_scalar(study[name])]
    if not scalars:
        raise InputError("no case of the study is finished yet: nothing to draw")
    _check_known("y", y, scalars)
    like = study["converged"]
    judged = study[list(dict.fromkeys([y, "converged", *DESCRIBING]))].assign(
        unstable=like.copy(data=is_unstable(study)),
        touches_itself=like.copy(data=touches_itself(study)),
    )
    table = judged.to_dataframe().reset_index()
    for name, value in chosen.items():
        table = table[_is_value(table[name], name, value)]
    table = table[table["converged"].notna()]
    _check_single(table, x, hue, [name for name in names if name in table])
    shown = table.assign(**{x: _scaled(_in_si(table[x], x), _field_unit(x))})
    shown[y] = _scaled(table[y], study[y].attrs.get("units", "1"))
    return shown.sort_values(x)


def _in_si(column: pd.Series, name: str) -> pd.Series:
    """Return the values of a field as numbers where it has a unit: "10 deg" is 0.1745."""
    unit = _field_unit(name)
    texts = [isinstance(value, str) for value in column]
    if unit == "1" or not any(texts):
        return column
    numbers = in_si(
        "study", {name: list(column)}, {name: unit.replace("³", "^3").replace("²", "^2")}
    )
    return pd.Series(numbers[name], index=column.index, dtype=float)


def _with_gaps(line: pd.DataFrame, x: str, y: str) -> tuple[Any, Any]:
    """Return a line with a gap wherever the shapes change to another branch."""
    if not pd.api.types.is_numeric_dtype(line[x]):
        return line[x], line[y]
    return line_with_gaps(line[x], line[y], branch_changes(line[x], line[list(DESCRIBING)]))


def _check_known(option: str, name: str | None, known: Sequence[str]) -> None:
    if name is not None and name not in known:
        expected = f"expected one of {', '.join(known)}{nearest(name, known)}"
        raise InputError(f"--{option} {name}: not in this study, {expected}")


def _is_scalar(variable: xr.DataArray) -> bool:
    return not {"xyz", "node", "face", "corner"} & set(variable.dims)


def _is_value(column: pd.Series, name: str, value: Any) -> pd.Series:
    if pd.api.types.is_numeric_dtype(column) and isinstance(value, (int, float)):
        number = finite(name, value)
        found = pd.Series(np.isclose(column, number, rtol=1e-9), index=column.index)
    else:
        found = column.astype(str) == str(value)
    if not found.any():
        listed = ", ".join(map(str, column.unique()))
        raise InputError(f"{name} = {value}: not in this study, expected one of {listed}")
    return found


def _check_single(table: pd.DataFrame, x: str, hue: str | None, names: Sequence[str]) -> None:
    """Check that no two rows fall on one point of a line."""
    if table.empty:
        raise InputError("the study has no finished case to draw")
    points = table.groupby([x] if hue is None else [x, hue], dropna=False)
    others = [name for name in names if name not in (x, hue)]
    for name in others:
        if points[name].nunique(dropna=False).max() > 1:
            values = ", ".join(map(str, table[name].unique()))
            raise InputError(
                f"{name} has the values {values}: expected one of them to be chosen "
                f"(--select {name}=VALUE), or the field as --x or --hue"
            )


def _mark(axes: Axes, table: pd.DataFrame, x: str, y: str) -> None:
    """Mark the points that are not the shape of a real specimen."""
    mark_caveats(axes, table[x], table[y], table["unstable"], table["touches_itself"])
    missing = table[table["converged"] != 1]
    if len(missing):
        axes.plot(
            missing[x], np.full(len(missing), 1.03), linestyle="none", marker="v", color="0.4",
            clip_on=False, transform=axes.get_xaxis_transform(), label="not reached",
        )  # fmt: skip


def _line_style(k: int, count: int) -> dict[str, Any]:
    marker = RESULT_MARKERS[k % len(RESULT_MARKERS)]
    if count <= len(RESULT_COLOURS):
        return {"color": RESULT_COLOURS[k], "marker": marker}
    return {"color": mpl.colormaps["viridis"](0.9 * k / (count - 1)), "marker": marker}


def _value_text(name: str, value: Any) -> str:
    if isinstance(value, str):
        return value
    scaled, unit = _shown_unit(_field_unit(name))
    text = f"{scaled * value:g} {unit}".rstrip()
    return f"λ = {text}" if name == "prestretch" else f"{_words(name)} {text}"


def _with_unit(name: str, unit: str) -> str:
    _, shown = _shown_unit(unit)
    return f"{_words(name)} ({shown})" if shown else _words(name)


def _words(name: str) -> str:
    """Return a dotted name as words: "cut.inner_radius" is "inner radius"."""
    table, _, key = name.rpartition(".")
    words = key.replace("_", " ")
    return f"{table} {words}" if table in ("substrate", "kirigami") else words


def _field_unit(name: str) -> str:
    return FIELD_UNITS.get(name.rpartition(".")[2], "1")


def _shown_unit(unit: str) -> tuple[float, str]:
    return SHOWN_UNITS.get(unit, (1.0, "" if unit == "1" else unit))


def _scaled(column: pd.Series, unit: str) -> pd.Series:
    factor, _ = _shown_unit(unit)
    return column if factor == 1.0 else column * factor
