"""The spectrogram that a log asks for on the page: its numbers, its picture, its mistakes."""

import base64
import io
import json
import re
import time

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.testing import assert_allclose
from PIL import Image
from tests.report.browser import FOUND, Browser
from tests.report.test_page import report_of

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.report.figures import axes
from shakerproc.report.figures.units import ShownUnits
from shakerproc.report.page.page import Report, html, write_report
from shakerproc.runs import process_recording, summary_of
from shakerproc.testlog import Processing, Test, chosen_units
from shakerproc.testlog.processing import ShownSpectrogram, Welch

RATE, SECONDS, SEGMENT = 2048.0, 40.0, 512
BURST = (300.0, 10.0, 15.0)  # [Hz] [s] [s]
AMPLITUDE = 2.0  # [g]
IN_BURST = 10.0 * np.log10(AMPLITUDE**2 / 2.0 / (1.5 * RATE / SEGMENT))
"""Density of a sine in the middle of its bin under a Hann window [dB re 1 g²/Hz]."""
STEP = 80.0 / 31.0  # [dB]


def recorded(seconds=SECONDS):
    time_s = np.arange(int(seconds * RATE)) / RATE
    tone = AMPLITUDE * np.sin(2.0 * np.pi * BURST[0] * time_s)
    rng = np.random.default_rng(5)
    rows = 1e-3 * rng.standard_normal((2, time_s.size))
    rows[1] += tone * ((time_s >= BURST[1]) & (time_s < BURST[2]))
    roles = {"table": "control", "tip": "response"}
    channels = [Channel(n, "m/s^2", n, "g", role=r) for n, r in roles.items()]
    return recording_of_arrays("a", channels, rows * STANDARD_GRAVITY, RATE)


def summary(asked=ShownSpectrogram(), **how):  # noqa: B008 - frozen
    processing = Processing(crop=None, welch=Welch(SEGMENT, SEGMENT // 2), spectrogram=asked)
    test = Test("1", processing=processing)
    return summary_of(process_recording(recorded(**how), test), "1", {}, "a.tdms", "ab" * 32)


@pytest.fixture(scope="module")
def run():
    return summary()


def picture(page):
    """The picture of the values on a page, as numbers of its colours; low rows first."""
    data = re.search(r'class="plot".*?<image [^>]*base64,([^"]+)"', page, re.DOTALL).group(1)
    return np.array(Image.open(io.BytesIO(base64.b64decode(data))))[::-1]


def test_a_burst_has_its_level_where_and_when_it_is(run):
    kept = run.surface
    steps = np.array([[ord(letter) - ord("A") for letter in row] for row in kept.rows])
    level = kept.low_db + (kept.high_db - kept.low_db) * steps / 31.0
    assert kept.channel == "tip"
    assert level.shape == (80, 160)
    frequency = np.linspace(*kept.frequency_hz, 80)
    at = np.linspace(*kept.time_s, 160)
    width, half = frequency[1], SEGMENT / RATE
    row = level[np.argmax(level.max(axis=1))]
    assert abs(frequency[np.argmax(level.max(axis=1))] - BURST[0]) < width
    inside = (at > BURST[1] + half) & (at < BURST[2] - half)
    outside = (at < BURST[1] - half) | (at > BURST[2] + half)
    assert_allclose(row[inside], IN_BURST, atol=0.5 * STEP + 0.1)
    assert np.all(row[outside] < IN_BURST - 60.0)  # the noise is below -90 dB


def test_the_page_shows_the_levels_in_colours_of_viridis(run):
    page = html(report_of([run]))
    steps = [[ord(letter) - ord("A") for letter in row] for row in run.surface.rows]
    assert np.array_equal(picture(page), steps)
    assert "Density of tip in dB re 1 g²/Hz" in page
    wanted = mpl.colormaps["viridis"](np.linspace(0.0, 1.0, len(axes.COLOURS)))[:, :3]
    assert_allclose([to_rgb(colour) for colour in axes.COLOURS], wanted, atol=0.002)
    assert "<image" not in html(report_of([summary(None)]))


def test_the_levels_follow_the_units_of_the_report(run):
    page = html(Report("A", [run], units=ShownUnits(chosen_units(["SI"]))))
    top = run.surface.high_db + 20.0 * np.log10(STANDARD_GRAVITY)
    assert "Density of tip in dB re 1 (m/s²)²/Hz" in page
    assert f"<span>{top:.0f}</span></p>".replace("-", "−") in page


def test_another_channel_is_asked_for_by_name_and_one_that_is_not_there_is_told():
    assert summary(ShownSpectrogram("table")).surface.channel == "table"
    with pytest.raises(SpectrumError, match=r"no channel 'tp'; the run has table, tip. Name"):
        summary(ShownSpectrogram("tp"))
    short = summary(seconds=0.4)
    assert short.surface is None
    assert "fewer than two segments of 512 samples" in " ".join(short.notes)


@pytest.mark.slow
@pytest.mark.skipif(FOUND is None, reason="no Chromium, Chrome or Edge is installed")
def test_the_level_under_the_pointer_is_read_from_the_picture(run, tmp_path):
    write_report(tmp_path / "report.html", report_of([run]))
    figure = "document.querySelector('#run-1 image').closest('figure')"
    with Browser() as browser:
        browser.open(tmp_path / "report.html")
        browser.run(f"{figure}.scrollIntoView({{behavior: 'instant', block: 'center'}})")
        deadline = time.monotonic() + 20.0
        box = None
        while box is None and time.monotonic() < deadline:
            box = browser.run(
                f"(o => o && JSON.stringify(o.getBoundingClientRect()))"
                f"({figure}.querySelector('.draw.live .u-over'))"
            )
        place = json.loads(box)
        x = place["x"] + 12.5 / 40.0 * place["width"]
        y = place["y"] + (1.0 - 301.0 / run.surface.frequency_hz[1]) * place["height"]
        browser.ask("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="none")
        told = browser.run(f"{figure}.querySelector('.read').textContent").replace("−", "-")
        assert browser.errors == []
    level = float(re.search(r"(-?[\d.]+) dB re 1 g²/Hz", told).group(1))
    assert level == pytest.approx(IN_BURST, abs=0.5 * STEP + 0.1)
