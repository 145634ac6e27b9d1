import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from shakerproc.report import style, svg

WIDTH, HEIGHT = 560, 230
X = svg.Axis("x", 0.0, 100.0)
Y = svg.Axis("y", -1.0, 1.0)


def points_of(path):
    """The absolute points of a path of M, l and h0, in pixels."""
    runs = []
    for move in re.findall(r"M(-?\d+) (-?\d+)(?:l([-\d ]*)|h0)", path):
        numbers = [int(n) for n in re.findall(r"-?\d+", move[2] or "")]
        steps = np.reshape(numbers, (-1, 2)) if numbers else np.zeros((0, 2))
        start = np.array([[int(move[0]), int(move[1])]])
        runs.append(np.vstack([start, start + np.cumsum(steps, axis=0)]) / svg.UNIT)
    return runs


def path_of(drawing, css="c0"):
    return re.search(rf'<path class="{css}" d="([^"]*)"', str(drawing)).group(1)


def drawn(x, y, **how):
    return svg.plot([svg.Curve("a", np.array(x), np.array(y), 0)], X, Y, title="t", **how)


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(-1, 1)), min_size=2, max_size=60))
def test_a_path_goes_through_its_points(points):
    x, y = np.array(points).T
    (run,) = points_of(path_of(drawn(x, y)))
    expected_x = 58 + x / 100.0 * (WIDTH - 58 - 18)
    expected_y = 8 + (1.0 - y) / 2.0 * (HEIGHT - 8 - 34)
    ends = [0, -1]
    assert_allclose(run[ends, 0], expected_x[ends], atol=0.5 / svg.UNIT + 1e-9)
    assert_allclose(run[ends, 1], expected_y[ends], atol=0.5 / svg.UNIT + 1e-9)
    for px, py in zip(expected_x, expected_y, strict=True):
        assert np.min(np.hypot(run[:, 0] - px, run[:, 1] - py)) < 1.0 / svg.UNIT


def test_what_is_no_number_breaks_the_line():
    path = path_of(drawn([0.0, 10.0, 20.0, 30.0, 40.0], [0.0, 0.1, np.nan, 0.2, 0.3]))
    assert len(points_of(path)) == 2


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_ticks_are_few_and_inside(low, span):
    axis = svg.Axis("x", low, low + span)
    found = svg.ticks(axis)
    assert 2 <= len(found) <= 8
    assert min(found) >= low - 1e-6 * span
    assert max(found) <= low + span * (1 + 1e-6)


@pytest.mark.parametrize("decades", [1, 2, 5, 9, 14])
def test_logarithmic_ticks_are_powers_of_ten(decades):
    found = svg.ticks(svg.Axis("y", 1e-5, 10.0 ** (decades - 5), logarithmic=True))
    assert_allclose(np.log10(found) % 1.0, 0.0, atol=1e-12)
    assert 1 <= len(found) <= 8


def test_labels_are_inert():
    text = str(
        svg.plot(
            [svg.Curve("<script>alert(1)</script>", np.arange(3.0), np.zeros(3), 0)],
            svg.Axis("<b>", 0.0, 2.0),
            svg.Axis("&", -1.0, 1.0),
            title="</title><script>",
            marks=[svg.Mark(1.0, '"><img>')],
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
