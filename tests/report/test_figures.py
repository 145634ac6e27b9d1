import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from tests.campaign.test_summary_and_trends import FALLING
from tests.runs.test_processing import RANDOM, with_roles
from tests.small_campaign import RATE, samples, write_campaign

from shakerproc.campaign import trends
from shakerproc.report.runs import drawing
from shakerproc.report.runs.analyses import limits
from shakerproc.report.runs.drawing import draw_run, run_figure
from shakerproc.report.runs.figures import IN_FILES
from shakerproc.report.trends import draw_trends, page_figures, trend_figure
from shakerproc.runs import process_recording, process_test, summary_of
from shakerproc.runs.panels import PanelLine, PanelScale
from shakerproc.runs.summarising import unbroken_phase
from shakerproc.runs.tracking import Tracking
from shakerproc.spectra import Sweep
from shakerproc.testlog import facts_of, read_testlog


@pytest.mark.slow
def test_every_figure_of_a_run_is_drawn_and_drawn_alike(tmp_path):
    rows = samples(250.0, seconds=12.0)
    rows[2:] += 30.0 * np.sin(2.0 * np.pi * 50.0 * np.arange(rows.shape[1]) / RATE)
    result = process_recording(with_roles(rows), replace(RANDOM, notch_hz=50.0))
    first = draw_run(result, "Test 1", tmp_path / "a")
    second = draw_run(result, "Test 1", tmp_path / "b")
    names = {path.stem for path in first}
    assert names == set(IN_FILES) - {"sweep", "level"}
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
        with Image.open(one) as image:
            assert image.width == 910
            assert len(image.convert("L").getcolors(256)) > 10


def test_a_trend_is_drawn(tmp_path):
    cut = replace(FALLING[1], promised_s=9.0)
    request = trends.standard_trends(FALLING)[0]
    trend = trends.trend([FALLING[0], cut, FALLING[2]], request, "ch3")
    (path,) = draw_trends([trend], tmp_path)
    with Image.open(path) as image:
        assert image.size == (910, 613)


def test_bars_of_a_trend_on_the_page_reach_as_far_as_half_a_bin():
    """Read back from the path: steps of the drawing against the distance of two points."""
    trend = trends.trend(FALLING, trends.standard_trends(FALLING)[0], "ch3")
    (found,) = page_figures([trend])
    assert "Bars: width of a bin." in found.caption
    text = str(found.drawing)
    (points,) = trend.series.values()
    ends = [
        (float(low), float(high))
        for path in re.findall(r'<path class="bar c\d" d="([^"]*)"', text)
        for low, high in re.findall(r"M\S+ (\d+)h\d+m-\d+ 0V(\d+)m", path)
    ]
    assert len(ends) == len(points)
    middle = [(low + high) / 2.0 for low, high in ends]
    step = (middle[-1] - middle[0]) / (points[-1].frequency_hz - points[0].frequency_hz)
    for (low, high), point in zip(ends, points, strict=True):
        assert abs(high - low) == pytest.approx(abs(step) * point.bin_width_hz, abs=2.5)


def test_a_trend_spells_the_peak_frequency_out():
    request = trends.standard_trends(FALLING)[0]
    figure = trend_figure(trends.trend(FALLING, request, "ch3"))
    assert figure.axes[0].get_ylabel() == "peak frequency [Hz]"
    assert "_" not in request.title


def test_the_phase_is_broken_where_it_wraps():
    phase = unbroken_phase(np.exp(1j * np.radians([80.0, 100.0, -100.0, 179.0, -179.0])))
    assert phase[0] == pytest.approx(80.0)
    assert np.isnan(phase[1])
    assert phase[3:] == pytest.approx([-181.0, -179.0])


def noisy():
    """A run whose responses hold noise: the root of the PSD ratio lies far above |H1|."""
    rows = samples(250.0, damping=0.2)
    rows[2:] += 100.0 * np.random.default_rng(3).standard_normal(rows[2:].shape)
    result = process_recording(with_roles(rows), RANDOM)
    n = 200
    gain = np.ones((4, n), dtype=complex)
    gain[2, 50] = 0.0
    harmonics = np.ones((4, 5, n), dtype=complex)
    harmonics[:, 1:] *= 1e-3
    harmonics[2, 0, 100], harmonics[2, 0, 101] = 1e-7, 0.0
    one = Sweep(
        "up", np.arange(float(n)), np.linspace(10.0, 500.0, n), np.full(n, 4.0), np.ones(n),
        gain, harmonics,
    )  # fmt: skip
    over_time = replace(result.over_time, tracking=Tracking(sweeps=(one,)))
    return replace(result, over_time=over_time, averages=replace(result.averages, loudest=2))


@pytest.mark.parametrize("name", ["psd", "response", "coherence", "psd_and_response", "sweep"])
def test_no_figure_cuts_a_curve_off_or_draws_what_is_no_number(name):
    figure = run_figure(noisy(), name, "Test 1")
    for axes in figure.axes:
        top = axes.get_ylim()[1]
        for line in axes.get_lines():
            y = np.asarray(line.get_ydata(), dtype=float)
            inside = y[np.isfinite(y)]
            assert inside.size == 0 or inside.max() <= top
            assert axes.get_yscale() != "log" or (inside > 0.0).all()


@pytest.mark.parametrize("value", [10.0, 0.37, 2.5e-7])
@pytest.mark.parametrize("logarithmic", [True, False])
def test_a_flat_line_lies_within_its_axis(value, logarithmic):
    line = PanelLine("flat", np.arange(1.0, 4.0), np.full(3, value))
    low, high = limits([line], PanelScale("", logarithmic=logarithmic))
    assert low < value < high


def test_every_mode_of_the_table_is_marked_in_the_response_function(tmp_path):
    log = read_testlog(write_campaign(tmp_path, 1))
    test = log.tests[0]
    run = summary_of(process_test(log, test), "1", facts_of(test), "test_1.tdms", "ab" * 32)
    (gain,) = [d for d in drawing.page_figures(run) if "|H1|" in d.title]
    marks = re.findall(r'<path class="p\d" d="([^"]*)"', str(gain.drawing))
    modes = [peak for channel in run.channels for peak in channel.response_peaks]
    assert len(modes) >= 2
    assert sum(path.count("M") for path in marks) == len(modes)


@pytest.mark.parametrize("name", ["psd", "response", "coherence", "time"])
def test_the_page_and_the_file_show_the_same(tmp_path, name):
    log = read_testlog(write_campaign(tmp_path, 1))
    test = log.tests[0]
    result = process_test(log, test)
    axes = run_figure(result, name, "Test 1").axes
    run = summary_of(result, "1", facts_of(test), "test_1.tdms", "ab" * 32)
    kind = {"response": "gain"}.get(name, name)
    (page,) = [str(d.drawing) for d in drawing.page_figures(run) if d.kind == kind]
    assert f">{axes[0].get_ylabel()}</text>" in page
    assert f">{axes[-1].get_xlabel()}</text>" in page
    names = axes[0].get_legend_handles_labels()[1]
    assert [label for label in names if f"</svg> {label}</span>" not in page] == []
    words = [text.get_text() for text in axes[0].texts if text.get_text().startswith("peak")]
    assert all(f">{word}</text>" in page for word in words)
    assert name != "psd" or words
