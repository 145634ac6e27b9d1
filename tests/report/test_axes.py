"""Numbers along axes, whatever their room; which analyses are printed."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.page.page import EXAMPLE, Report, html

LETTERS = 11.0
"""Height of the letters of an axis [px]."""


def upright_numbers(drawing):
    """Return where the numbers of the upright axis stand [px]."""
    return [int(y) / 4.0 for y in re.findall(r'<text class="end" x="212" y="(\d+)">', drawing)]


def drawn(low, high, height, label="time [s]"):
    rows = np.array([low, high])
    plot = Plot(
        [Curve("", np.arange(2.0), rows, 0)], Axis(label, 0.0, 1.0),
        Axis("[g]", low, high),
    )  # fmt: skip
    return str(to_svg.plot(plot, title="t", height=height))


@given(
    middle=st.floats(-100.0, 100.0),
    half=st.floats(1e-3, 1e3),
    height=st.integers(88, 230),
)
def test_an_upright_axis_has_two_numbers_that_do_not_touch(middle, half, height):
    places = upright_numbers(drawn(middle - half, middle + half, height))
    assert len(places) >= 2
    assert np.min(-np.diff(places)) >= LETTERS


def test_an_axis_without_a_label_has_no_numbers():
    """Of figures above each other the lowest has those of all."""
    below = re.findall(r'<text x="\d+" y="\d+">[\d.]+</text>', drawn(0.0, 1.0, 100, ""))
    assert below == []
    assert len(re.findall(r'<text x="\d+" y="\d+">[\d.]+</text>', drawn(0.0, 1.0, 100))) > 2


@pytest.mark.parametrize(
    ("excitation", "kind", "printed"),
    [
        ("shock", "shock", True),
        ("random", "shock", False),
        ("random", "profile", True),
        ("sine", "dwell", True),
        ("sine on random", "tones", True),
        ("random", "octaves", False),
    ],
)
def test_what_a_test_is_made_for_is_printed(excitation, kind, printed):
    run = replace(
        EXAMPLE,
        facts={**EXAMPLE.facts, "excitation": excitation},
        analyses=(replace(EXAMPLE.analyses[0], kind=kind),),
    )
    page = html(Report("t", (run,), channel="response"))
    (figure,) = re.findall(r"<figure([^>]*)><figcaption><b>Example\.</b>", page)
    assert ("screen" in figure) != printed
    assert ("on the page: Example." in page) != printed
