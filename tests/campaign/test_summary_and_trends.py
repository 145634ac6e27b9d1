import csv
import io
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from pyarrow import parquet
from tests.small_campaign import write_campaign

from shakerproc import files
from shakerproc.campaign import tables, trends
from shakerproc.campaign.tables import write_parquet
from shakerproc.campaign.trends import trend_sentence
from shakerproc.errors import LogError
from shakerproc.runs import (
    process_test,
    read_summary,
    summary_of,
    write_summary,
)
from shakerproc.runs.panels import thinned
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary, SpectrumSummary
from shakerproc.runs.tables import spectra_columns
from shakerproc.testlog import facts_of, read_testlog

SPECTRUM = SpectrumSummary(
    512, 256, 40, "hamming", "none", 4.0, 5.4, 60.0, 0.7, 1.5, (5.0, 800.0)
)


def peak(frequency, height=1.0):
    return PeakSummary(
        frequency, frequency, height, None, None, None, None, None, None, "", 0.9
    )


def run(test, frequency, clearance, *, kind="random", joint="radial", height=1.0, **more):
    channels = tuple(
        ChannelSummary(
            name,
            "response",
            "g",
            "",
            *([None] * 8),
            psd_peaks=(peak(frequency, height * share),),
        )
        for name, share in (("ch3", 1.0), ("ch4", 0.5))
    )
    facts = {
        "joint": joint,
        "clearance_m": clearance,
        "excitation": kind,
        "orientation": "out of plane",
        "level_g": None,
        **more,
    }
    return RunSummary(test, "done", facts, channels=channels, spectrum=SPECTRUM)


FALLING = [run("1", 360.0, 0.0), run("2", 300.0, 5e-5), run("3", 252.0, 1e-4)]


def test_the_sentence_tells_the_fall_with_clearance():
    sentence = trend_sentence(FALLING, "ch3")
    assert "falls from 360 Hz at 0.00 mm to 252 Hz at 0.10 mm" in sentence
    assert "30%" in sentence


def test_the_sentence_tells_when_nothing_moves_by_more_than_a_bin():
    still = [run("1", 360.0, 0.0), run("2", 361.0, 1e-4)]
    assert "stays at 360 Hz" in trend_sentence(still, "ch3")


def test_without_clearances_the_level_is_told():
    runs = [
        run(str(level), 180.0 + 1e4 * level, 1e-4, level_g2_per_hz=level)
        for level in (0.001, 0.005, 0.01)
    ]
    sentence = trend_sentence(runs, "ch3")
    assert "rises from 190 Hz at 0.001 g²/Hz to 280 Hz at 0.01 g²/Hz of level" in sentence
    assert "nonlinear" in sentence


def test_nothing_is_told_of_one_clearance():
    assert trend_sentence([run("1", 360.0, 0.0)], "ch3") == ""


def test_the_channel_of_the_trends_is_the_one_that_moves_most():
    assert trends.trend_channel(FALLING) == "ch3"


def test_a_sine_has_no_main_peak():
    assert trends.main_peak(run("1", 50.0, 0.0, kind="sine"), "ch3") is None


def test_the_thesis_trends_are_there_by_name_and_sorted():
    sweeps = [
        run(f"s{g}", 250.0 + g, 1e-4, kind="sine sweep", level_g=float(g)) for g in (5, 1, 10)
    ]
    requests = {r.name: r for r in trends.standard_trends([*FALLING, *sweeps], thesis=True)}
    level = trends.trend(
        sweeps, requests["figure_5_46_peak_frequency_against_level_radial"], "ch3"
    )
    ((name, points),) = level.series.items()
    assert name == "0.10 mm, out of plane"
    assert [p.x for p in points] == [1.0, 5.0, 10.0]
    clearance = trends.trend(
        FALLING, requests["figure_5_45_peak_frequency_against_clearance_random"], "ch3"
    )
    assert [p.x for p in clearance.series["radial, out of plane"]] == pytest.approx([
        0,
        0.05,
        0.1,
    ])
    assert clearance.x_label == "clearance [mm]"


def test_a_trend_by_columns_that_a_person_names():
    runs = [replace(r, facts={**r.facts, "batch": i % 2}) for i, r in enumerate(FALLING)]
    asked = trends.chosen_trend(runs, "clearance", ["batch"])
    assert set(trends.trend(runs, asked, "ch3").series) == {"0", "1"}
    with pytest.raises(LogError, match=r"no column 'colour' in the log\. It has joint"):
        trends.chosen_trend(runs, "colour", [])


def test_a_summary_comes_back_as_it_was_written(tmp_path):
    log = read_testlog(write_campaign(tmp_path, 1))
    test = log.tests[0]
    result = process_test(log, test)
    summary = summary_of(result, "1", facts_of(test), "test_1.tdms", "ab")
    write_summary(tmp_path / "s.json", summary)
    assert read_summary(tmp_path / "s.json") == summary
    spectra = spectra_columns(result)
    assert {"frequency_hz", "psd_ch3_g2_per_hz", "h1_ch3_phase_deg", "excited"} <= set(spectra)
    assert {len(column) for column in spectra.values()} == {257}
    table = list(csv.DictReader(io.StringIO(files.csv_text(tables.peak_columns([summary])))))
    first = next(
        r for r in table if (r["channel"], r["quantity"], r["rank"]) == ("ch3", "psd", "1")
    )
    assert float(first["frequency_hz"]) == summary.channels[2].psd_peaks[0].frequency_hz
    assert first["clearance_m"] == "0.0"


@pytest.mark.parametrize("n", [10, 1000, 4001])
def test_thinning_keeps_the_extremes(n):
    x = np.arange(float(n))
    y = np.random.default_rng(n).standard_normal(n)
    few_x, few_y = thinned(x, y, 200)
    assert few_x.size <= max(200, min(n, 200))
    assert few_y.max() == y.max()
    assert few_y.min() == y.min()
    assert (np.diff(few_x) > 0).all()


def test_a_thinned_nyquist_plot_is_still_the_circle_of_the_resonance():
    """Of an oscillator: a circle of diameter 1 / (2 ζ); most lines lie near its origin."""
    ratio = np.arange(1, 8193) / 360.0
    gain = ratio * 1j / (1.0 - ratio**2 + 0.02j * ratio)  # a mobility, exactly a circle
    x, y = thinned(gain.real, gain.imag, 240)
    assert x.size <= 240
    wanted = int(np.sum(np.abs(ratio - 1.0) < 0.02))  # beyond 80 % of the largest gain apart
    kept = np.hypot(x, y) > 20.0
    assert kept.sum() >= min(wanted, 10)
    assert_allclose(np.hypot(x - 25.0, y), 25.0, rtol=1e-9)
    assert np.hypot(np.diff(x), np.diff(y)).max() < 1.2 * np.abs(np.diff(gain)).max()


@pytest.mark.parametrize(
    "gap", [slice(500, 501), slice(100, 900), slice(0, 3), slice(990, None)]
)
def test_thinning_keeps_a_broken_line_broken(gap):
    x, y = np.arange(1000.0), np.random.default_rng(1).standard_normal(1000)
    y[gap] = np.nan
    few_x, few_y = thinned(x, y, 100)
    assert few_x.size <= 100
    inside = (few_x >= x[gap][0]) & (few_x <= x[gap][-1])
    assert inside.any()
    assert np.isnan(few_y[inside]).all()


def test_names_of_trend_files_are_harmless_and_those_of_the_thesis_carry_their_number():
    runs = [run("1", 300.0, 0.0, joint="../../x"), run("2", 290.0, 5e-5, joint="slot")]
    requests = trends.standard_trends(runs, thesis=True)
    names = [request.name for request in requests]
    plain = [request.name for request in trends.standard_trends(runs)]
    assert not [name for name in plain if "figure" in name or "/" in name or "." in name]
    assert len(set(plain)) == len(set(names)) == len(names)
    assert not [request.title for request in requests if "thesis" in request.title]
    assert not [name for name in names if "/" in name or "." in name]
    assert {name[:11] for name in names if name.startswith("figure")} == {
        "figure_5_45", "figure_5_47", "figure_5_49",
    }  # fmt: skip


def test_a_run_that_was_cut_says_how_much_of_it_is_there():
    cut = replace(run("1", 300.0, 0.0), duration_s=5.0, promised_s=6.126)
    assert cut.status_text == "incomplete, 5.00 of 6.13 s"
    assert run("1", 300.0, 0.0).status_text == "done"
    found = trends.trend([cut, *FALLING[1:]], trends.standard_trends(FALLING)[0], "ch3")
    columns = tables.trend_columns(found, "ch3")
    assert columns["incomplete"] == [True, False, False]
    assert columns["promised_s"] == [6.126, None, None]


@pytest.mark.parametrize(
    ("values", "arrow"),
    [
        (["a", "b"], ["a", "b"]),
        (["a", None, "ä"], ["a", None, "ä"]),
        ([1, 2, None], [1, 2, None]),
        ([1.5, None, 2], [1.5, None, 2.0]),
        ([float("nan"), -0.0, None], [float("nan"), -0.0, None]),
        ([True, None, False], [True, None, False]),
        ([None, None], [None, None]),
        ([], []),
        (["a", 1.5, True], ["a", "1.5", "True"]),
    ],
)
def test_columns_of_parquet_are_those_that_arrow_makes_of_them(tmp_path, values, arrow):
    write_parquet(tmp_path / "a.parquet", {"x": values})
    found = parquet.read_table(tmp_path / "a.parquet")["x"]
    assert found.type == pa.array(arrow).type
    assert str(found.to_pylist()) == str(arrow)
