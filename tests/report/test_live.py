"""The numbers beside a drawing, read back by a decoder of its own."""

import html
import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from shakerproc.report.evidence.numbers import CandidateError, ladder
from shakerproc.report.figures import figure, to_svg
from shakerproc.report.figures.axes import WHITE_FROM, shade
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.figures.style import SHADES

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"


def content(drawing):
    return json.loads(
        html.unescape(re.search(r"<data value='([^']*)'>", str(drawing)).group(1))
    )


def decoded(text, places, axis):
    *_, logarithmic, low, high = axis
    if logarithmic == 1:
        low, high = np.log(low), np.log(high)
    top = 64**places - 1
    out = []
    for i in range(0, len(text), places):
        step = 0
        for letter in text[i : i + places]:
            step = 64 * step + LETTERS.index(letter)
        value = np.nan if step == top else low + step / (top - 1) * (high - low)
        out.append(np.exp(value) if logarithmic == 1 else value)
    return np.array(out)


def payload(x, y, **axis):
    curve = Curve("a", np.array(x), np.array(y), 0)
    return content(
        figure.payload(Plot([curve], Axis("x", 0.0, 1.0), Axis("y", 1e-3, 1.0, **axis)))
    )


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=50))
def test_values_come_back_within_a_step(values):
    x = np.sort(np.random.default_rng(1).random(len(values)))
    found = payload(x, values)
    read = decoded(found["c"][0][4], 2, found["y"])
    span = max(values) - min(values) + 3e-5 * max(map(abs, values))
    assert_allclose(read, values, atol=span / 4094 + 1e-11)


@given(st.lists(st.floats(1e-12, 1e6), min_size=2, max_size=50))
def test_logarithms_come_back_within_a_step(values):
    found = payload(np.arange(len(values)), values, logarithmic=True)
    read = decoded(found["c"][0][4], 2, found["y"])
    step = np.log(max(values) / min(values)) / 4094 + 1e-4
    assert_allclose(np.log(read), np.log(values), atol=step)


def test_what_is_no_number_comes_back_as_none():
    found = payload([0.1, 0.2, 0.4], [1.0, np.nan, 3.0])
    assert_allclose(decoded(found["c"][0][4], 2, found["y"]), [1.0, np.nan, 3.0], rtol=1e-3)
    logarithmic = payload([0.1, 0.2, 0.4], [1.0, 0.0, 3.0], logarithmic=True)
    read = decoded(logarithmic["c"][0][4], 2, logarithmic["y"])
    assert_allclose(read, [1.0, np.nan, 3.0], rtol=1e-3)


def test_even_places_take_three_numbers_and_others_come_back():
    assert payload(np.linspace(5.0, 1000.0, 200), np.zeros(200))["c"][0][3] == [
        5.0,
        1000.0,
        200,
    ]
    x = np.geomspace(1.0, 1000.0, 50)
    found = payload(x, np.zeros(50))
    assert_allclose(decoded(found["c"][0][3], 3, found["x"]), x, atol=1000.0 / 262142)


def test_two_curves_of_the_same_places_share_them():
    x = np.geomspace(1.0, 9.0, 5)
    curves = [Curve(name, x, np.arange(5.0), 0) for name in "ab"]
    found = content(figure.payload(Plot(curves, Axis("", 0.0, 9.0), Axis("", 0.0, 5.0))))
    assert found["c"][1][3] == 0


@pytest.mark.parametrize("text", ["'", '"', "'><script>alert(1)</script>", "&#39;", "</data>"])
def test_labels_stay_inside_the_attribute(text):
    curve = Curve(text, np.arange(3.0), np.arange(3.0), 0)
    drawn = str(figure.payload(Plot([curve], Axis(text, 0.0, 1.0), Axis(text, 0.0, 1.0))))
    assert re.fullmatch(r"<data value='[^'<>]*'></data>", drawn)
    assert content(drawn)["c"][0][0] == text


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_shades_darken_with_the_value_and_their_numbers_can_be_read():
    levels = [luminance(colour) for colour in SHADES]
    assert levels == sorted(levels, reverse=True)
    for i, level in enumerate(levels):
        text = 1.0 if i >= WHITE_FROM else luminance("#111111")
        low, high = sorted((text, level))
        assert (high + 0.05) / (low + 0.05) >= 4.5, i
    steps = [shade(10.0**p) for p in np.linspace(-4.0, 1.0, 60)]
    assert steps == sorted(steps)
    assert (steps[0], steps[-1]) == (0, len(SHADES) - 1)


def test_the_ladder_is_logarithmic_and_its_floor_stands_where_it_should():
    rungs = [
        CandidateError("old", 0.5, 0.4),
        CandidateError("new", 0.05, 0.04),
        CandidateError("none", None, float("nan")),
    ]
    drawn = str(ladder(rungs, 0.005, title="t"))
    marks = {
        css: [float(x) for x in re.findall(rf'class="{css}" d="M(\d+) \d+m', drawn)][:2]
        for css in ("p0", "p1")
    }
    floor = float(re.search(r'class="mark" d="M(\d+)', drawn).group(1))
    decade = marks["p1"][0] - marks["p1"][1]
    assert marks["p0"][0] - marks["p0"][1] == pytest.approx(decade, abs=2)
    assert marks["p1"][1] - floor == pytest.approx(decade, abs=2)


def test_a_loop_stays_a_still_figure():
    angle = np.linspace(0.0, 6.0, 50)
    loop = Curve("loop", np.sin(angle), np.cos(angle), 0)
    axis = Axis("", -1.0, 1.0)
    assert not figure.payload(Plot([loop], axis, axis))
    assert "<svg" in to_svg.plot(Plot([loop], axis, axis), title="loop")
    falling = Curve("down", np.linspace(9.0, 1.0, 5), np.arange(5.0), 0)
    assert figure.payload(Plot([falling], axis, axis))


@given(st.lists(st.sampled_from([0.0, 0.25, 0.5, 1.0]), min_size=1, max_size=30))
def test_points_at_one_place_are_all_handed_over(places):
    x, y = np.array(places), np.arange(1.0, len(places) + 1.0)
    curves = [
        Curve("a", x, y, 0, points=True),
        Curve("b", x[::-1], y, 1, dots=True),
    ]
    axis = Axis("", 0.0, 40.0)
    found = content(figure.payload(Plot(curves, axis, axis)))
    for (*_, place, values), curve in zip(found["c"], curves, strict=True):
        at = found["c"][place][3] if isinstance(place, int) else place
        read = np.linspace(*at) if isinstance(at, list) else decoded(at, 3, found["x"])
        assert_allclose(read, curve.x, atol=1e-4)
        assert_allclose(decoded(values, 2, found["y"]), curve.y, atol=0.01)


def test_a_point_without_a_place_breaks_its_line_and_takes_no_other_away():
    curve = Curve("a", np.array([0.0, 1.0, np.nan, 3.0]), np.array([7.0, 2.0, 5.0, 4.0]), 0)
    x_axis, y_axis = Axis("", 0.1, 9.0, logarithmic=True), Axis("", 0.0, 9.0)
    found = content(figure.payload(Plot([curve], x_axis, y_axis)))
    assert_allclose(decoded(found["c"][0][3], 3, found["x"]), [1.0, 1.0, 3.0], rtol=1e-4)
    assert_allclose(decoded(found["c"][0][4], 2, found["y"]), [2.0, np.nan, 4.0], atol=0.01)
