"""The figures hold what they should, and their files are whole, repeatable and named well."""

import sys
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from made_results import cap_result, small_specimen
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from scipy.spatial.transform import Rotation
from shapes import cap
from sheets import OUTLINES, PATTERNS, trilayer

from bilayer import ComputationError, InputError, generate_mesh, result_mesh
from bilayer.figures import (
    draw_birds_eye,
    draw_comparison,
    draw_distances,
    draw_isometric,
    draw_mesh,
    draw_quality,
    draw_quality_against,
    draw_shape,
    draw_shapes,
    save_figure,
)
from bilayer.figures.branch_changes import branch_changes
from bilayer.figures.mesh import BARE_EDGE, BILAYER_EDGE, edge_regions
from bilayer.figures.result_looks import result_looks
from bilayer.figures.shape import BIRDS_EYE, ISOMETRIC, View, _face_colours, _shaded
from bilayer.figures.style import BARE_COLOUR, KIRIGAMI_COLOUR, print_style
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface
from bilayer.results.comparison import compare, comparison_table
from bilayer.results.released_shapes import released_shapes


@pytest.fixture(scope="module")
def whole():
    return cap_result(solver="fenics", model="mooney-rivlin")


@pytest.fixture(scope="module")
def stopped():
    return cap_result(reached=1.065)


@pytest.mark.parametrize("draw", [draw_isometric, draw_birds_eye, draw_shapes])
def test_a_milestone_taken_out_of_a_result_is_drawn(whole, stopped, draw):
    (axes,) = [a for a in visible_axes(draw(whole.sel(prestretch=1.06))) if a.collections][:1]
    assert "λ = 1.06" in axes.get_title()
    draw(whole.sel(prestretch=[1.03, 1.06]))
    draw(stopped.sel(prestretch=1.09))


def test_a_milestone_taken_out_of_each_result_is_compared_and_drawn(whole, stopped):
    one, other = whole.sel(prestretch=1.06), stopped.sel(prestretch=1.06)
    compared = compare(one, other)
    xr.testing.assert_identical(compared, compare(whole, stopped).isel(prestretch=[1]))
    assert comparison_table(compared.isel(prestretch=0)) == comparison_table(compared)
    for figure in (
        draw_quality([one, other]),
        draw_quality_against(other, one),
        draw_comparison(compared.isel(prestretch=0)),
        draw_distances([compared.isel(prestretch=0)]),
    ):
        assert figure.get_axes()


@pytest.mark.parametrize(
    ("draw", "given", "message"),
    [
        (draw_isometric, lambda r: r["position"], "result = DataArray: expected one dataset"),
        (draw_isometric, lambda r: r.drop_vars("prestretch"), "result: has no prestretch"),
        (draw_shapes, lambda r: "shell.nc", "result = str: expected one dataset"),
        (draw_quality, lambda r: r, "results = a dataset: expected a list"),
        (draw_distances, lambda r: r, "comparisons = a dataset: expected a list"),
    ],
)
def test_what_is_no_result_is_told(whole, draw, given, message):
    with pytest.raises(InputError, match=message):
        draw(given(whole))


def visible_axes(figure):
    return [axes for axes in figure.get_axes() if axes.get_visible()]


def texts(axes):
    return [axes.get_title(), *(text.get_text() for text in axes.texts)]


def test_a_trilayer_of_two_patterns_has_a_colour_and_a_name_for_each_set_of_layers():
    sheet = trilayer(OUTLINES["ellipse"], PATTERNS["sectors"], PATTERNS["cross"])
    mesh = generate_mesh(sheet)
    names = ["trilayer", "lower + substrate", "substrate + upper", "bare substrate"]
    figure = draw_mesh(mesh)
    assert sorted(t.get_text() for t in figure.legends[0].get_texts()) == sorted(names)
    region = edge_regions(mesh)
    assert set(region) == {0, 1, 2, 3}
    covered = np.union1d(mesh.faces_of("lower"), mesh.faces_of("upper"))
    beside = {frozenset(edge) for t in mesh.triangles[covered] for edge in combinations(t, 2)}
    bare = [frozenset(edge) not in beside for edge in mesh.edges]
    assert (region == 0).tolist() == bare
    (legend,) = draw_isometric(cap_result(sheet, mesh=mesh)).subfigs[0].legends
    assert sorted(t.get_text() for t in legend.get_texts()) == sorted(names)


def test_an_edge_beside_kirigami_is_a_bilayer_edge(whole):
    mesh = result_mesh(whole)
    covered = {frozenset(edge) for t in mesh.triangles[mesh.region == 1]
               for edge in (t[[0, 1]], t[[1, 2]], t[[2, 0]])}  # fmt: skip
    expected = [frozenset(edge) in covered for edge in mesh.edges]
    assert (edge_regions(mesh) == 1).tolist() == expected
    assert 0 < sum(expected) < len(expected)


def test_the_mesh_has_each_edge_once_in_its_colour(whole):
    mesh = result_mesh(whole)
    (axes,) = draw_mesh(mesh).get_axes()
    drawn = {
        tuple(lines.get_colors()[0][:3]): len(lines.get_segments())
        for lines in axes.collections
        if isinstance(lines, LineCollection)
    }
    count = int((edge_regions(mesh) == 1).sum())
    assert drawn == {to_rgb(BILAYER_EDGE): count, to_rgb(BARE_EDGE): len(mesh.edges) - count}


@pytest.mark.parametrize("draw", [draw_isometric, draw_birds_eye])
def test_a_panel_for_every_milestone_at_the_same_scale(stopped, draw):
    panels = visible_axes(draw(stopped))
    assert [axes.get_title() for axes in panels] == ["λ = 1.03", "λ = 1.06", "λ = 1.09"]
    assert len({(axes.get_xlim(), axes.get_ylim(), axes.get_aspect()) for axes in panels}) == 1
    assert "stopped at 1.065" in texts(panels[2])
    assert not any("stopped" in text for axes in panels[:2] for text in texts(axes))


def test_a_view_from_above_shows_the_body_frame_in_mm():
    tilted = cap_result(motion=Rotation.from_rotvec([1.0, 0.5, 0.0]).apply)
    axes = visible_axes(draw_birds_eye(tilted))[0]
    (triangles,) = (c for c in axes.collections if isinstance(c, TriMesh))
    corners = triangles.get_datalim(axes.transData).get_points()
    span = 1e3 * tilted["span"].values[0, :2]
    assert np.ptp(corners, axis=0) == pytest.approx(span, rel=1e-6)
    hues = {int(np.argmax(colour[:3])) for colour in triangles.get_facecolor()}
    assert hues == {int(np.argmax(to_rgb(c))) for c in (BARE_COLOUR, KIRIGAMI_COLOUR)}


def test_both_views_of_a_result(whole):
    assert len(visible_axes(draw_shapes(whole))) == 6


def test_a_result_without_shapes_says_so():
    nothing = cap_result(reached=1.01)
    with pytest.raises(InputError, match="holds no shape"):
        draw_shapes(nothing.drop_vars("last_position"))


def test_quality_marks_what_was_not_reached(whole, stopped):
    (axes,) = draw_quality([whole, stopped]).get_axes()
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert lines["fenics mooney-rivlin"].get_ydata().tolist() == whole["quality"].values.tolist()
    assert lines["shell (paper), not reached"].get_xdata().tolist() == [1.09]
    assert "fenics mooney-rivlin, not reached" not in lines


def test_quality_against_quality_names_each_point(whole, stopped):
    (axes,) = draw_quality_against(stopped, whole).get_axes()
    assert [text.get_text() for text in axes.texts] == ["1.03", "1.06"]
    points = next(line for line in axes.get_lines() if "milestone" in line.get_label())
    assert points.get_xdata()[:2] == pytest.approx(whole["quality"].values[:2])
    assert points.get_ydata()[:2] == pytest.approx(stopped["quality"].values[:2])
    assert axes.get_xlabel() == "quality, fenics mooney-rivlin"
    assert axes.get_ylabel() == "quality, shell (paper)"


def test_a_comparison_is_drawn_from_its_dataset(whole):
    comparison = compare(whole, cap_result(motion=lambda x: 1.02 * x))
    distance, quality, height = draw_comparison(comparison).get_axes()
    percent = 100 * comparison["rms_distance_over_radius"].values
    assert distance.get_lines()[0].get_ydata() == pytest.approx(percent)
    assert len(quality.get_lines()) == 2
    assert height.get_lines()[1].get_ydata() == pytest.approx(1e3 * comparison["height"].values[1])


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_the_same_data_give_the_same_bytes(whole, tmp_path, ending):
    for name in ("a", "b"):
        save_figure(draw_quality([whole]), tmp_path / f"{name}.{ending}")
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


def test_a_picture_is_fine_enough_for_print(whole, tmp_path):
    save_figure(draw_mesh(result_mesh(whole)), tmp_path / "mesh.png")
    header = (tmp_path / "mesh.png").read_bytes()[16:24]
    assert int.from_bytes(header[:4], "big") >= 900


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("figure.pgn", r"ending of figure .*'pgn'.*did you mean 'png'"),
        ("figure", "has no ending"),
        ("missing/figure.png", "the folder .* does not exist"),
    ],
)
def test_names_that_cannot_be_written(whole, tmp_path, name, message):
    with pytest.raises(InputError, match=message):
        save_figure(draw_quality([whole]), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_leaves_the_earlier_figure(whole, tmp_path, full_disk):
    path = tmp_path / "figure.png"
    save_figure(draw_quality([whole]), path)
    earlier = path.read_bytes()
    with full_disk(), pytest.raises(ComputationError, match=r"figure .*cannot be written"):
        save_figure(draw_mesh(result_mesh(whole)), path)
    assert path.read_bytes() == earlier
    assert list(tmp_path.iterdir()) == [path]


def test_no_state_of_pyplot_is_touched(whole):
    draw_shapes(whole)
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or pyplot.get_fignums() == []


def test_the_users_own_style_is_kept_and_the_rest_is_for_print(whole):
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 30, "legend.fontsize": 17}):
        draw_quality([whole])
        assert mpl.rcParams["font.size"] == 30
        with print_style():
            assert mpl.rcParams["font.size"] == 30
            assert mpl.rcParams["legend.fontsize"] == 17
            assert mpl.rcParams["xtick.labelsize"] == 8
    assert mpl.rcParams["xtick.labelsize"] != 8


def test_a_pdf_has_fonts_that_journals_take(whole, tmp_path):
    save_figure(draw_quality([whole]), tmp_path / "a.pdf")
    text = (tmp_path / "a.pdf").read_bytes()
    assert b"/CIDFontType2" in text  # TrueType
    assert b"/Type3" not in text


def test_many_milestones_fill_a_grid():
    milestones = tuple(1.02 + 0.02 * k for k in range(6))
    panels = visible_axes(draw_isometric(cap_result(small_specimen(milestones))))
    assert len(panels) == 6


def test_distances_are_drawn_for_every_comparison():
    near, far = cap_result(reached=1.06), cap_result(reached=1.06)
    far["position"] = 1.01 * far["position"]
    comparison = compare(near, far)
    figure = draw_distances([comparison, comparison])
    lines = figure.axes[0].lines
    expected = 100 * comparison["rms_distance_over_radius"].values
    assert len(lines) == 2
    for line in lines:
        np.testing.assert_array_equal(line.get_ydata(), expected)


def test_shapes_with_something_against_them_are_marked(whole):
    doubtful = whole.copy(deep=True)
    doubtful["unstable_modes"][1] = 2
    doubtful["self_contact_gap"][2] = 0.0
    (axes,) = draw_quality([whole, doubtful]).get_axes()
    marks = {line.get_label(): line.get_xdata().tolist() for line in axes.get_lines()[2:]}
    assert marks == {"unstable": [1.06], "touches itself": [1.09]}
    assert [panel.texts[0].get_text() for panel in visible_axes(draw_birds_eye(doubtful))] == [
        "", "unstable", "touches itself",
    ]  # fmt: skip
    table = comparison_table(compare(whole, doubtful))
    assert "unstable" in table and "contact" in table
    assert "unstable" not in comparison_table(compare(whole, whole))


LIKE_MATHEMATICS = ["_shell {}%s", "$\\nonsense_{$ 5 %", r"\$ a$_b$c", "x^2_{\n" + "z" * 10**5]


@pytest.mark.parametrize("name", LIKE_MATHEMATICS, ids=range(len(LIKE_MATHEMATICS)))
def test_a_name_is_drawn_as_it_is_written(tmp_path, name):
    result = cap_result(model=name)
    comparison = compare(result, result)
    comparison.attrs |= {"first": name, "second": f"{name} again"}
    for draw, data in (
        (draw_shapes, result.isel(prestretch=[0])),
        (draw_quality, [result, result]),
        (draw_comparison, comparison),
        (draw_distances, [comparison]),
    ):
        figure = draw(data)
        save_figure(figure, tmp_path / "figure.svg")
        words = [text.get_text() for text in figure.findobj(Text)]
        shown = name[:50].replace("$", r"\$").replace("\n", r"\n")
        assert any(shown in text for text in words)


def test_a_name_that_begins_with_an_underscore_is_in_the_legend():
    comparison = compare(cap_result(), cap_result())
    comparison.attrs["second"] = "_mine"
    (legend,) = draw_distances([comparison]).legends
    assert [text.get_text().strip("\N{ZERO WIDTH SPACE}") for text in legend.texts] == ["_mine"]


def test_the_side_that_is_seen_is_the_one_that_is_lit(whole):
    """An underside is paler than the upper side, never black."""
    mesh = result_mesh(whole)
    flat, colours = flat_surface(mesh), _face_colours(mesh)
    above = _shaded(flat, colours, BIRDS_EYE)
    below = _shaded(flat, colours, View(0.0, -np.pi / 2))
    assert above.shape == (len(mesh.triangles), 3, 3)
    assert (below >= above).all()
    assert below.mean() > 1.1 * above.mean()


def test_shading_is_smooth_over_the_edges_of_triangles(whole):
    """Triangles of one colour have one shade at each node that they share."""
    mesh = result_mesh(whole)
    surface = Surface(cap(mesh.points, 1.0), mesh.triangles)
    shades = _shaded(surface, np.ones((len(mesh.triangles), 3)), ISOMETRIC)[:, :, 0]
    upper = ISOMETRIC.project(surface.area_vectors)[:, 2] >= 0
    low, high = np.full(len(mesh.points), 2.0), np.full(len(mesh.points), -1.0)
    np.minimum.at(low, mesh.triangles[upper], shades[upper])
    np.maximum.at(high, mesh.triangles[upper], shades[upper])
    seen = high > 0
    np.testing.assert_allclose(low[seen], high[seen], atol=1e-12)
    assert np.ptp(shades) > 0.2


def test_a_body_that_opens_upwards_is_not_turned_over():
    bowl = cap_result(motion=lambda x: x * [1, 1, -1])
    apex = {}
    for name, result in {"dome": cap_result(), "bowl": bowl}.items():
        (shape, *_) = released_shapes(result, result_mesh(result))
        points = shape.surface.points
        middle = np.argmin(np.hypot(*points[:, :2].T))
        apex[name] = points[middle, 2] - points[:, 2].mean()
    assert apex["dome"] > 0 > apex["bowl"]
    assert bowl["height"].values == pytest.approx(cap_result()["height"].values)


def test_views_and_milestones_are_chosen(whole):
    panels = visible_axes(draw_shapes(whole, views=["front", (30, 20)], milestones=[1.06, 1.03]))
    assert [axes.get_title() for axes in panels] == 2 * ["λ = 1.03", "λ = 1.06"]
    with pytest.raises(InputError, match=r"prestretch = 1.05: not in the result, expected one of"):
        draw_shapes(whole, milestones=[1.05])
    with pytest.raises(InputError, match=r"view = 'font'.*did you mean 'front'"):
        draw_shapes(whole, views=["font"])


def test_figures_are_drawn_into_the_axes_of_the_user(whole, stopped):
    figure = Figure()
    axes = figure.subplots(2, 2)
    assert draw_quality([whole, stopped], ax=axes[0, 0]) is figure
    draw_quality_against(stopped, whole, ax=axes[0, 1])
    draw_distances([compare(whole, stopped)], ax=axes[1, 0])
    draw_shape(whole, 1.06, "above", ax=axes[1, 1])
    assert all(one.has_data() for one in axes.flat)
    assert axes[1, 1].get_title() == "λ = 1.06"
    assert figure.legends == []


def test_a_solver_and_model_has_one_name_and_colour_in_whatever_company():
    alone = result_looks(["dshell morley"])[0]
    among = result_looks(["fenics solid", "dshell hinge", "dshell morley"])[2]
    twice = result_looks(["dshell morley (a.nc)", "dshell morley (b.nc)"])
    assert alone == among
    assert [look.colour for look in twice] == [alone.colour] * 2
    assert [look.name for look in twice] == ["shell (morley) (a.nc)", "shell (morley) (b.nc)"]
    assert twice[0].line != twice[1].line


def test_no_line_is_joined_across_a_change_of_branch():
    x = np.linspace(0, 1, 9)
    snap = np.where(x < 0.45, 0.9 - 0.1 * x, 0.3 - 0.1 * x)
    assert np.flatnonzero(branch_changes(x, snap)).tolist() == [3]
    root = np.sqrt(np.maximum(x - 0.5, 0))  # a bifurcation: no jump
    assert not branch_changes(x, root).any()
    assert not branch_changes(x, np.full(9, np.nan)).any()
    snapped = cap_result(small_specimen((1.01, 1.02, 1.03, 1.04, 1.05, 1.06)))
    snapped["hemisphere_distance"] = ("prestretch", [0.9, 0.88, 0.86, 0.3, 0.28, 0.26])
    line = draw_quality([snapped]).get_axes()[0].get_lines()[0]
    assert np.flatnonzero(np.isnan(line.get_xdata())).tolist() == [3]


def test_a_curve_has_room_below_the_frame(whole):
    *_, height = draw_comparison(compare(whole, whole)).get_axes()
    assert height.get_ylim()[1] > 1.03 * height.get_lines()[0].get_ydata().max()
    assert height.get_ylim()[0] == 0


@pytest.mark.parametrize(("factor", "length"), [(0.1, 1), (1, 10), (10, 100)])
def test_scale_and_ticks_fit_the_size_of_the_shape(factor, length):
    result = cap_result(small_specimen((1.03,)), motion=lambda x: factor * x)
    side, above = visible_axes(draw_shapes(result))
    assert f"axes: {length} mm" in texts(side)
    assert 3 <= len(above.get_xticks()) <= 9
