import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from shakerproc.report.figures import axes, style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Filling, Mark, Plot
from shakerproc.runs.panels import OFF, straightened

WIDTH, HEIGHT = 560, 230
X = Axis("x", 0.0, 100.0)
Y = Axis("y", -1.0, 1.0)


def points_of(path):
    """The absolute points of a path of M, l and h0, in pixels."""
    runs = []
    for move in re.findall(r"M(-?\d+) (-?\d+)(?:l([-\d ]*)|h0)", path):
        numbers = [int(n) for n in re.findall(r"-?\d+", move[2] or "")]
        steps = np.reshape(numbers, (-1, 2)) if numbers else np.zeros((0, 2))
        start = np.array([[int(move[0]), int(move[1])]])
        runs.append(np.vstack([start, start + np.cumsum(steps, axis=0)]) / axes.UNIT)
    return runs


def path_of(drawing, css="c0"):
    return re.search(rf'<path class="{css}" d="([^"]*)"', str(drawing)).group(1)


def drawn(x, y, **how):
    curve = Curve("a", np.array(x), np.array(y), 0)
    return to_svg.plot(Plot([curve], X, Y, **how), title="t")


def distance(run, point):
    """How far a point lies from a line of straight pieces."""
    start, way = run[:-1], np.diff(run, axis=0)
    length = np.maximum(np.sum(way**2, axis=1), 1e-30)
    share = np.clip(np.sum((point - start) * way, axis=1) / length, 0.0, 1.0)
    near = np.vstack([start + share[:, np.newaxis] * way, run])
    return np.min(np.hypot(*(near - point).T))


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(-1, 1)), min_size=2, max_size=60))
def test_a_path_goes_through_its_points(points):
    x, y = np.array(points).T
    (run,) = points_of(path_of(drawn(x, y)))
    expected_x = 58 + x / 100.0 * (WIDTH - 58 - 18)
    expected_y = 8 + (1.0 - y) / 2.0 * (HEIGHT - 8 - 34)
    ends = [0, -1]
    assert_allclose(run[ends, 0], expected_x[ends], atol=0.5 / axes.UNIT + 1e-9)
    assert_allclose(run[ends, 1], expected_y[ends], atol=0.5 / axes.UNIT + 1e-9)
    for point in zip(expected_x, expected_y, strict=True):
        assert distance(run, np.array(point)) < (1.0 + OFF) / axes.UNIT  # rounded, straightened


def test_what_is_no_number_breaks_the_line():
    path = path_of(drawn([0.0, 10.0, 20.0, 30.0, 40.0], [0.0, 0.1, np.nan, 0.2, 0.3]))
    assert len(points_of(path)) == 2


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_ticks_are_few_and_inside(low, span):
    axis = Axis("x", low, low + span)
    found = axes.ticks(axis)
    assert 2 <= len(found) <= 8
    assert min(found) >= low - 1e-6 * span
    assert max(found) <= low + span * (1 + 1e-6)


@pytest.mark.parametrize("decades", [1, 2, 5, 9, 14])
def test_logarithmic_ticks_are_powers_of_ten(decades):
    found = axes.ticks(Axis("y", 1e-5, 10.0 ** (decades - 5), logarithmic=True))
    assert_allclose(np.log10(found) % 1.0, 0.0, atol=1e-12)
    assert 1 <= len(found) <= 8


def test_labels_are_inert():
    text = str(
        to_svg.plot(
            Plot(
                [Curve("<script>alert(1)</script>", np.arange(3.0), np.zeros(3), 0)],
                Axis("<b>", 0.0, 2.0),
                Axis("&", -1.0, 1.0),
                marks=[Mark(1.0, '"><img>')],
            ),
            title="</title><script>",
        )
    )
    assert "<script" not in text
    assert "<img" not in text
    assert "<b>" not in text


def test_every_line_differs_in_grey_too():
    dashes = style.DASHES
    assert len({(d, c) for d, c in zip(dashes, style.COLOURS, strict=True)}) == len(dashes)
    assert len(set(dashes[:6])) == 6
    assert style.styles(["control", "control", "response", "force"]) == [6, 7, 0, 1]


LOG = Axis("y", 1e-3, 1.0, logarithmic=True)


def below(y, x=None, *, y_axis=LOG, css="c0", **how):
    """The drawn pieces of a curve, as values of the axes."""
    places = np.arange(float(len(y))) if x is None else np.array(x)
    x_axis = Axis("x", 0.0, max(1.0, float(places.max())))
    curve = Curve("a", places, np.array(y), 0, **how)
    pieces = points_of(path_of(to_svg.plot(Plot([curve], x_axis, y_axis), title="t"), css))
    wide, high = WIDTH - 58 - 18, HEIGHT - 8 - 34
    return [
        ((piece[:, 0] - 58) / wide * x_axis.high, 1.0 - (piece[:, 1] - 8) / high)
        for piece in pieces
    ]


def test_a_line_that_leaves_the_axis_ends_where_it_crosses_it():
    """From 1e-2 down to 1e-5 over 30: below 1e-3 from 10 on, straight on a logarithmic axis."""
    (down, up) = below([1e-2, 1e-5, 1e-5, 1e-2], [0.0, 30.0, 60.0, 90.0])
    assert_allclose(down[0], [0.0, 10.0], atol=0.1)
    assert_allclose(down[1], [1.0 / 3.0, 0.0], atol=0.01)
    assert_allclose(up[0], [80.0, 90.0], atol=0.1)


def test_a_line_over_the_whole_axis_is_cut_at_both_ends():
    ((x, share),) = below([1e-6, 1e3], [0.0, 90.0])
    assert_allclose(x, [30.0, 60.0], atol=0.1)
    assert_allclose(share, [0.0, 1.0], atol=0.01)


@given(
    st.lists(
        st.sampled_from([0.0, -1.0, np.nan, 1e-300, 1e300]) | st.floats(1e-7, 1e4),
        min_size=2,
        max_size=40,
    )
)
def test_no_drawn_point_lies_where_the_data_are_not(values):
    """Each drawn point lies on the straight line between two neighbours that are numbers."""
    y = np.array(values)
    with np.errstate(all="ignore"):
        wanted = (np.log10(np.where(y > 0.0, y, np.nan)) + 3.0) / 3.0
    step = 1.0 / (axes.UNIT * (HEIGHT - 8 - 34))
    for x, share in below(values) if path_of_or_empty(values) else ():
        assert np.all((share > -step) & (share < 1.0 + step))
        for at, value in zip(x, share, strict=True):
            left = min(int(at), y.size - 2)
            near = range(max(0, left - 1), min(y.size - 1, left + 2))
            gaps = [off_line(at, value, k, wanted) for k in near]
            assert min(gaps) < 2.0 * step


def path_of_or_empty(values):
    curve = Curve("a", np.arange(float(len(values))), np.array(values), 0)
    x_axis = Axis("x", 0.0, max(1.0, len(values) - 1.0))
    return path_of(to_svg.plot(Plot([curve], x_axis, LOG), title="t"))


def off_line(x, share, k, wanted):
    """How far a point lies from the line between rows k and k + 1 [shares of the height]."""
    ends = wanted[k : k + 2]
    if not np.isfinite(ends).all():  # a single number beside none is a point of its own
        return min((abs(share - e) for e in ends if np.isfinite(e)), default=np.inf)
    x_step = (wanted.size - 1.0) / (axes.UNIT * (WIDTH - 58 - 18))
    slope = abs(ends[1] - ends[0])
    on = ends[0] + (x - k) * (ends[1] - ends[0])
    return max(0.0, abs(share - on) - slope * x_step)


def test_marks_and_dots_beyond_an_axis_are_not_drawn_at_its_end():
    for css, how in (("p0", {"points": True}), ("d0", {"dots": True})):
        curve = Curve("a", np.arange(3.0), np.array([1e-5, 1e-2, 10.0]), 0, **how)
        drawing = to_svg.plot(Plot([curve], Axis("x", 0.0, 2.0), LOG), title="t")
        assert path_of(drawing, css).count("M") == 1
    marked = [Mark(200.0, "far"), Mark(50.0, "here")]
    text = str(drawn([0.0, 1.0], [0.0, 1.0], marks=marked))
    shown = text.split("<data", maxsplit=1)[0]
    assert "here" in shown
    assert "far" not in shown


def test_an_area_beyond_the_axis_is_cut_and_one_outside_is_not_drawn():
    x = np.arange(4.0)
    area = Filling("a", x, np.array([-5.0, -0.5, 2.0, 2.0]), np.array([0.5, 0.5, 3, 3]), 0)
    text = str(to_svg.plot(Plot([area], Axis("x", 0.0, 3.0), Y), title="t"))
    (run,) = points_of(path_of(text, "f0").replace("z", ""))
    top, bottom = 8.0, 8.0 + HEIGHT - 8 - 34
    assert run[:, 1].min() >= top
    assert run[:, 1].max() <= bottom
    assert run[:, 0].max() == pytest.approx(58 + 1.6 / 3.0 * (WIDTH - 58 - 18), abs=40.0)


def test_a_straightened_line_keeps_its_ends_and_strays_by_half_a_pixel_at_most():
    rng = np.random.default_rng(8)
    for noise in (0.0, 0.4, 3.0, 40.0):
        x = np.cumsum(rng.integers(0, 4, 400)).astype(float)
        y = np.rint(100.0 * np.sin(x / 60.0) + noise * rng.standard_normal(400))
        few_x, few_y = straightened(x, y)
        assert (few_x[0], few_y[0], few_x[-1], few_y[-1]) == (x[0], y[0], x[-1], y[-1])
        for at, up in zip(x, y, strict=True):
            near = few_y[few_x == at]
            drawn = np.append(near, np.interp(at, few_x, few_y)) if not near.size else near
            assert drawn.min() - OFF - 1e-9 <= up <= drawn.max() + OFF + 1e-9
    assert straightened(np.arange(400.0), 0.3 * np.arange(400.0))[0].size == 2
    assert OFF / axes.UNIT <= 0.5


def test_axes_that_several_figures_have_are_written_once():
    figure = to_svg.plot(Plot([Curve("a", np.arange(3.0), np.arange(3.0), 0)], X, X), title="t")
    other = to_svg.plot(Plot([Curve("a", np.arange(3.0), np.arange(3.0), 0)], X, Y), title="t")
    page = axes.shared(f"{figure}{other}{figure}")
    assert page.count('<g class="axes" id="axes-0">') == page.count('href="#axes-0"') == 1
    assert page.count('id="axes-1"') == 1
    assert page.count("</g>") == 2


def test_the_looks_of_shared_axes_hang_on_nothing_around_them():
    """A browser looks for what stands before a selector's last part within the axes alone."""
    css = (Path(to_svg.__file__).parents[1] / "page" / "templates" / "page.css").read_text(
        "utf-8"
    )
    powers = Axis("x", 1.0, 1e9, logarithmic=True)
    drawn = str(axes.grid(powers, Y, axes.Box(9, 9, 90, 90), 100, {}))
    names = {f".{name}" for name in re.findall(r'class="(\w+)"', drawn)} | {"text", "tspan"}
    rules = [rule.strip() for rule in re.findall(r"[^{}]+(?=\{)", css) if rule.strip()]
    about = [rule for rule in rules if set(re.findall(r"\.?[a-z]+", rule.split()[-1])) & names]
    assert {"text", "text.end", "tspan.up", "path.grid"} <= set(about)
    assert [rule for rule in about if " " in rule] == ["svg.heat text"]  # shares no axes


def test_a_phase_is_broken_where_it_goes_on_at_the_other_end_of_the_circle():
    """Of a straight delay, wrapped: no piece of the line turns back."""
    x = np.linspace(0.0, 100.0, 400)
    wrapped = (-17.0 * x + 180.0) % 360.0 - 180.0
    phase = Axis("phase [°]", -180.0, 180.0, degrees=True)
    figure = str(
        to_svg.plot(Plot([Curve("a", x, wrapped, 0)], X, phase), title="t", height=230)
    )
    turns = int(17.0 * 100.0 / 360.0 + 0.5)
    (line,) = re.findall(r'class="c0" d="([^"]+)"', figure.split("legend", maxsplit=1)[0])
    assert line.count("M") == turns + 1
    for piece in line.split("M")[1:]:
        steps = [int(n) for n in re.findall(r"-?\d+", piece.partition("l")[2])]
        assert min(steps[1::2]) >= 0  # it falls, all the way down, and never goes back up


def test_limits_have_the_colour_of_no_channel():
    channels = {*style.CONTROL_STYLES, *style.RESPONSE_STYLES}
    assert not channels & {style.ALARM_STYLE, style.ABORT_STYLE}
    assert len(set(style.COLOURS)) == len(style.COLOURS) == len(style.DASHES)
