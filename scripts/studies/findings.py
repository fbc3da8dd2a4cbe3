"""The findings of the studies on the paper's conclusions, each with its numbers.

A point counts if a real specimen can show it: reached, stable, not passing through itself. What
the others would show is unknown, so a conclusion that hangs on them is not decided.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.results.caveats import is_unstable, touches_itself
from studies.merged import WITHOUT

PRESTRETCH = 1.15
"""Prestretch at which the values of a field are listed: between slight bending and curling up."""
PAPER_BEST = 0.1
"""Section VI: "currently the best result I can get is 0.1"."""
PAPER_SHIFT = 0.08
"""Section VII: the shell's quality "is about 0.08 behind that of the FEA results"."""
ABOUT = 0.5
"""Relative tolerance with which the paper's "about" is read."""
STRIPS = "cut.strips"
SOLID = "solid"
"""The model of the finite elements."""
UNKNOWN = ("not computed", "not reached")
"""Why a point has no quality."""
MEASURED = ("quality", "lowest", "highest", "moved")
TOUCHES = "touches itself"
HOLDS, FAILS, OPEN = "holds", "does NOT hold", "CANNOT BE DECIDED"


def points_of(study: xr.Dataset, field: str | None = None) -> pd.DataFrame:
    """Return every point of a study, and whether it is sound.

    Columns: solver, model, prestretch, the field, quality, lowest and highest (it lies between),
    moved (by how much contact has moved it, NaN if that is not known), why (empty if it is sound),
    sound.
    """
    like = study["converged"]
    without = study.get(WITHOUT, like.copy(data=np.full(like.shape, np.nan)))
    judged = study[["quality", "converged"]].assign(
        unstable=like.copy(data=is_unstable(study)),
        touches=like.copy(data=touches_itself(study)),
        moved=abs(study["quality"] - without),
    )
    table = judged.to_dataframe().reset_index()
    against = [
        table["converged"].isna(), table["converged"] != 1, table["unstable"], table["touches"]
    ]  # fmt: skip
    table["why"] = np.select(against, [*UNKNOWN, "unstable", TOUCHES], "")
    table["sound"] = table["why"] == ""
    table["prestretch"] = table["prestretch"].round(9)
    known = ~table["why"].isin(UNKNOWN)
    table["lowest"], table["highest"] = (table["quality"].where(known, end) for end in (0.0, 1.0))
    return table[_columns(field)]


def bounded(points: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return the points of all fields, with bounds of those that pass through themselves.

    They are taken to be within the largest change that contact has made where it is known, among
    the points of the same solver; if it is known nowhere, they may have any quality.
    """
    moves = _moves(points)
    tables = {}
    for field, table in points.items():
        slack = table["solver"].map(moves).fillna(1.0).where(table["why"] == TOUCHES, 0.0)
        tables[field] = table.assign(
            lowest=(table["lowest"] - slack).clip(lower=0.0),
            highest=(table["highest"] + slack).clip(upper=1.0),
        )
    return tables


def contact_findings(points: Mapping[str, pd.DataFrame]) -> list[str]:
    """Say how far contact has moved the quality of the points that touch themselves without."""
    counts = _together(points).groupby("solver")["moved"].count()
    return [
        f"{solver}: contact moved the quality by at most {move:.3f}, at {counts[solver]} points "
        "that pass through themselves without it; others that do are taken to be within that"
        for solver, move in _moves(points).items()
    ]


def _moves(points: Mapping[str, pd.DataFrame]) -> pd.Series:
    """Return by solver the largest change that contact has made to a quality."""
    return _together(points).groupby("solver")["moved"].max().dropna()


def _together(points: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return solver and move of the points of all fields."""
    columns = ["solver", "moved"]
    there = [table[columns].dropna() for table in points.values()]
    return pd.concat([table for table in there if len(table)] or [there[0]])


def no_points(field: str | None = None) -> pd.DataFrame:
    """Return the table of `points_of` for a study that is not there."""
    return pd.DataFrame(columns=_columns(field)).astype(
        {"sound": bool, **dict.fromkeys(MEASURED, float)}
    )


def _columns(field: str | None) -> list[str]:
    named = [] if field is None else [field]
    return ["solver", "model", "prestretch", *named, *MEASURED, "why", "sound"]


def range_findings(points: pd.DataFrame, field: str) -> list[str]:
    """Say how far the quality moves with one field, and whether it has an optimum."""
    lines = [f"quality over {field}"]
    for solver, of_one in points.groupby("solver"):
        lines.append(f"  {solver}: {_counted(of_one)}")
        at = of_one[np.isclose(of_one["prestretch"], PRESTRETCH)].sort_values(field)
        values = ", ".join(
            f"{row[field]:g}: " + (f"{row['quality']:.3f}" if row["sound"] else f"({row['why']})")
            for _, row in at.iterrows()
        )
        lines.append(f"  {solver}, prestretch {PRESTRETCH}: {values}")
        lines.append(f"  {solver}: {_best(of_one, field)}")
    return [*lines, ""]


def spans_findings(points: Mapping[str, pd.DataFrame]) -> list[str]:
    """List how far the quality moves with each field at each prestretch."""
    lines = [
        "range of the quality over each field, in the intervals of scripts/studies, as the paper "
        "prints none (sound points of all; at most, with all)"
    ]
    for solver in _solvers(points):
        for stretch, spans in _spans(points, solver).items():
            words = "; ".join(f"{name} {span}" for name, span in spans.items())
            lines.append(f"  {solver}, prestretch {stretch:g}: {words}: {_strips_verdict(spans)}")
    return [*lines, ""]


def conclusions(points: Mapping[str, pd.DataFrame], models: pd.DataFrame) -> list[str]:
    """Say of each of the paper's conclusions, in a line for each solver, whether it holds.

    Parameters
    ----------
    points : mapping of str to DataFrame
        The points of the study over each field, see `points_of`.
    models : DataFrame
        Those of the study of all models, which may be empty.
    """
    lines = ["the paper's conclusions"]
    solvers = _solvers(points)
    for solver in solvers:
        claim = "the number of the strips is the most important"
        lines.append(f"  {claim}, {solver}: {most_important(points, solver)}")
    for field, table in points.items():
        if field != STRIPS:
            lines += [
                f"  {field} has an optimum, {solver}: "
                f"{optimum(table[table['solver'] == solver], field)}"
                for solver in solvers
            ]
    for model in sorted(set(models["model"]) - {SOLID}):
        claim = (
            f"the shell is about {PAPER_SHIFT} (by half of it more or less) below the finite "
            "elements (figure 6)"
        )
        lines.append(f"  {claim}, {model}: {shift_verdict(models, model)}")
    return lines


def most_important(points: Mapping[str, pd.DataFrame], solver: str) -> str:
    """Say where the number of strips moves the quality most, the paper's first conclusion.

    Each field's range of the quality is known between that of its sound points and that of all
    its points. Only if these bounds leave no doubt is there a verdict.
    """
    by_verdict: dict[str, list[str]] = {HOLDS: [], FAILS: [], OPEN: []}
    for stretch, spans in _spans(points, solver).items():
        by_verdict[_strips_verdict(spans)].append(f"{stretch:g}")
    said = "; ".join(f"{v} at prestretch {', '.join(at)}" for v, at in by_verdict.items() if at)
    return said or f"{OPEN}, a study is missing"


def optimum(points: pd.DataFrame, field: str) -> str:
    """Say whether the best sound point lies between two that are sound and worse."""
    if not points["sound"].any():
        return f"{OPEN}, no sound point"
    best, row = _best_row(points, field)
    place = row.index.get_loc(best.name)
    near = row.iloc[max(place - 1, 0) : place + 2]
    against = near["why"][~near["sound"]]
    counted = (
        f"{row['sound'].sum()} sound points of {len(row)} at prestretch {best['prestretch']:g}"
    )
    if len(against):
        return f"{OPEN}, a point beside the best: {against.iloc[0]} ({counted})"
    for why in UNKNOWN:
        if (row["why"] == why).any():
            return f"{OPEN}, a point was {why} ({counted})"
    if (row["lowest"] < best["quality"]).any():
        return f"{OPEN}, a point that is not sound may be better ({counted})"
    if place in (0, len(row) - 1):
        return f"{FAILS}, the best, {best[field]:g}, is an end of the interval ({counted})"
    return f"{HOLDS}, {best[field]:g} ({counted})"


def shift_verdict(points: pd.DataFrame, model: str) -> str:
    """Say whether a shell is below the finite elements by about what the paper's was.

    The paper's figure compares what two models say, and its shell knew no contact: the shapes of a
    model that pass through themselves count. What remains of them without is told, too. Not
    decided if a point was not reached.
    """
    sound, computed = _below(points[points["sound"]], model), _below(points, model)
    count = points["prestretch"].nunique()
    if computed.empty:
        return f"{OPEN}, no point of both"
    told = f"{_measured(computed)} ({len(computed)} prestretches of {count})"
    if len(sound) < len(computed):
        only = f"{_measured(sound)}: {_verdict_of(sound)}" if len(sound) else "none"
        told += f"; of the {len(sound)} at which no shape passes through itself {only}"
    if len(computed) < count:
        return f"{OPEN}, a point was not reached, {told}"
    return f"{_verdict_of(computed)}, {told}"


def _measured(below: pd.Series) -> str:
    return f"{below.mean():+.3f} below in the mean, {below.abs().max():.3f} apart at most"


def _verdict_of(below: pd.Series) -> str:
    return _about_the_papers(float(below.mean()))


def _about_the_papers(mean: float) -> str:
    return HOLDS if abs(mean - PAPER_SHIFT) <= ABOUT * PAPER_SHIFT else FAILS


@dataclass(frozen=True)
class Span:
    """The range of the quality over a field, as far as it is known.

    `least` is over the sound points. `most` is over the bounds of all.
    """

    least: float
    most: float
    sound: int
    count: int

    @classmethod
    def of(cls, points: pd.DataFrame) -> "Span":
        sound = points["quality"][points["sound"]]
        least = float(np.ptp(sound)) if len(sound) else 0.0
        most = float(points["highest"].max() - points["lowest"].min()) if len(points) else 1.0
        return cls(least, most, len(sound), len(points))

    def __str__(self) -> str:
        most = "" if self.most == self.least else f"; at most {self.most:.3f}"
        return f"{self.least:.3f} ({self.sound} of {self.count}{most})"


def model_findings(points: pd.DataFrame) -> list[str]:
    """List the quality of every model if it is sound."""
    table = _by_model(points[points["sound"]]).round(3).to_string(na_rep="-")
    return [
        "quality of each model over the prestretch, sound points",
        *("  " + line for line in table.splitlines()),
        "",
    ]


def _counted(points: pd.DataFrame) -> str:
    excluded = points["why"][~points["sound"]].value_counts()
    left = ", ".join(f"{count} {why}" for why, count in excluded.items())
    return f"{points['sound'].sum()} sound points of {len(points)}" + (f" ({left})" if left else "")


def _best_row(points: pd.DataFrame, field: str) -> tuple[pd.Series, pd.DataFrame]:
    """Return the best sound point and all points of its prestretch, along the field."""
    sound = points[points["sound"]]
    best = sound.loc[sound["quality"].idxmin()]
    return best, points[points["prestretch"] == best["prestretch"]].sort_values(field)


def _best(points: pd.DataFrame, field: str) -> str:
    if not points["sound"].any():
        return "no sound point"
    best, _ = _best_row(points, field)
    return (
        f"best {best['quality']:.3f} at {field} = {best[field]:g}, prestretch "
        f"{best['prestretch']:g} (the paper's best: {PAPER_BEST})"
    )


def _solvers(points: Mapping[str, pd.DataFrame]) -> list[str]:
    return sorted({solver for table in points.values() for solver in table["solver"]})


def _spans(points: Mapping[str, pd.DataFrame], solver: str) -> dict[float, dict[str, Span]]:
    """Return the span over each field, at the prestretches that all fields have."""
    of_one = {name: table[table["solver"] == solver] for name, table in points.items()}
    common = set.intersection(*(set(table["prestretch"]) for table in of_one.values()))
    return {
        stretch: {
            name: Span.of(table[table["prestretch"] == stretch]) for name, table in of_one.items()
        }
        for stretch in sorted(common)
    }


def _strips_verdict(spans: Mapping[str, Span]) -> str:
    strips = spans[STRIPS]
    others = [span for name, span in spans.items() if name != STRIPS]
    if strips.least > max(span.most for span in others):
        return HOLDS
    if strips.most < max(span.least for span in others):
        return FAILS
    return OPEN


def _below(points: pd.DataFrame, model: str) -> pd.Series:
    """Return the finite elements' quality less a shell's, if there are both."""
    table = _by_model(points).reindex(columns=[SOLID, model])
    return (table[SOLID] - table[model]).dropna()


def _by_model(points: pd.DataFrame) -> pd.DataFrame:
    return points.pivot_table(index="prestretch", columns="model", values="quality")
