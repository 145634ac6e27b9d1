"""A free decay as a run: table, figures, flags; and a real one."""

import csv
import re

import numpy as np
import pytest
from scipy import io
from tests.in_process import run
from tests.struck import MODES, RATE, struck

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test, TimeCrop

CHANNELS = (
    Channel("hammer", "N", "hammer", "N", "force"),
    Channel("near", "m/s^2", "near", "g", "response"),
    Channel("far", "m/s^2", "far", "g", "response"),
)
G = 9.80665


def processed(
    rows, channels=CHANNELS, excitation="free decay", crop=None, rate=RATE, band=None
):
    low, high = band or (20.0, 350.0)
    test = Test(
        1,
        excitation=excitation,
        from_hz=low,
        to_hz=high,
        processing=Processing(crop=crop),
    )
    return process_recording(recording_of_arrays("run", channels, rows, rate), test)


def found(result):
    (one,) = [one for one in result.analyses if one.kind == "decays"]
    return one


@pytest.fixture(scope="module")
def struck_once():
    return struck([(0.5, 100.0)], 6.5, noise=(0.05, 0.005))


def test_every_mode_of_a_blow_comes_back_by_both_methods(struck_once):
    one = found(processed(struck_once))
    assert [row["mode"] for row in one.summary] == [1.0, 2.0]
    columns = {name: np.array(values) for name, values in one.columns.items()}
    assert set(columns["method"]) == {"least squares", "peaks and crossings"}
    for number, (frequency, zeta, *_) in enumerate(MODES, 1):
        chosen = columns["mode"] == number
        assert chosen.sum() >= 8
        for quantity, true in (("frequency", frequency), ("damping", 100.0 * zeta)):
            ending = "_hz" if quantity == "frequency" else "_percent"
            held = (columns[f"{quantity}_low{ending}"][chosen] <= true) & (
                true <= columns[f"{quantity}_high{ending}"][chosen]
            )
            assert held.mean() > 0.85
        size = (2.0 * np.pi * columns["frequency_hz"][chosen]) ** 2
        millimetres = 1e3 * columns["amplitude"][chosen] * G / size
        assert columns["displacement_mm"][chosen] == pytest.approx(millimetres)
    assert any("begins at 0.5" in text for text in one.sentences)
    assert sum("no trend of frequency with amplitude; no trend of damping" in text
               for text in one.sentences) == 2  # fmt: skip
    assert len(one.panels) == 4
    assert not one.problems


def test_a_free_decay_has_neither_density_peaks_nor_functions_of_one_average(struck_once):
    result = processed(struck_once)
    assert result.averages.bounds is None
    assert not any(result.averages.psd_peaks)
    assert {one.kind for one in result.analyses} == {"decays"}


def test_without_an_input_the_decay_begins_at_the_largest_motion(struck_once):
    one = found(processed(struck_once[1:2], CHANNELS[1:2]))
    assert len(one.summary) == 2
    assert any(text.startswith("One response only") for text in one.sentences)


def test_what_a_decay_does_not_tell_is_a_flag_and_costs_nothing_else(struck_once):
    driven = struck_once + 30.0 * np.sin(0.3 * np.arange(struck_once.shape[1]))
    result = processed(driven)
    (flag,) = [flag for flag in result.flags if flag.kind == "decays"]
    assert flag.message.startswith("no free part: the input moves to its end")
    short = processed(struck_once, crop=TimeCrop(0.4, 0.65))
    (told, *_) = found(short).problems
    assert "no curve: the decay lasts 0.146 s, and 0.331 s" in told


def test_what_rings_after_a_shock_is_told_and_flags_nothing(struck_once):
    base = (Channel("base", "m/s^2", "base", "g", "control"), *CHANNELS[1:])
    result = processed(struck_once, base, excitation="shock")
    assert len(found(result).summary) == 2
    quiet = struck_once.copy()
    quiet[1:] = 0.005 * np.random.default_rng(1).standard_normal(quiet[1:].shape)
    one = found(processed(quiet, base, excitation="shock"))
    assert one.sentences[0].startswith("no mode stands out of the noise within 20 to 350 Hz")
    assert not one.problems


def test_two_modes_that_beat_are_noted():
    t = np.arange(round(4.0 * RATE)) / RATE
    rows = np.exp(-1.5 * t) * (np.sin(500.0 * t) + 0.5 * np.sin(506.0 * t)) * 100.0
    rows += 0.01 * np.random.default_rng(1).standard_normal(t.size)
    (told,) = found(processed(rows[np.newaxis], CHANNELS[1:2])).problems
    assert re.search(r"the amplitude comes back to .* times what it was\. Another mode", told)


def test_a_batch_writes_decays_and_the_report_draws_them(tmp_path, struck_once):
    np.savez(tmp_path / "one.npz", f=struck_once[0], a=struck_once[1], fs=RATE)
    (tmp_path / "log.yaml").write_text(
        "testlog: 1\nrecordings: .\nchannels:\n  f: {role: force, unit: N}\n"
        "  a: {role: response, unit: m/s^2}\ntests:\n"
        "  - {id: 1, recording: one.npz, excitation: free decay, from: 20 Hz, to: 350 Hz}\n"
    )
    assert run("batch", tmp_path / "log.yaml", "--out", tmp_path / "out", "--no-figures") == 0
    with (tmp_path / "out" / "decays.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["frequency_at_largest_hz"]) for row in rows] == pytest.approx(
        [62.0, 143.0], rel=1e-3
    )
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for text in ("Frequency and damping against amplitude", "Damping of mode 1", "051111"):
        assert text in page


@pytest.mark.shared
def test_the_ring_down_of_a_jointed_structure_is_that_of_its_authors(shared):
    """151.7 to 149.9 Hz and 0.14 to 0.34 %, read by Jin et al. by peaks and fits."""
    data = io.loadmat(shared / "data" / "ringdown_lms" / "Sample_LMS_Data.mat")
    rows = np.array([data[name].ravel() for name in "fx"], dtype=float)
    one = found(processed(rows, CHANNELS[:2], rate=float(data["fs"].item()), band=(80, 1400)))
    assert one.summary[0]["disagree"] <= 0.1 * one.summary[0]["stretches"]
    columns = {name: np.array(values) for name, values in one.columns.items()}
    for method in ("least squares", "peaks and crossings"):
        chosen = (columns["mode"] == 1) & (columns["method"] == method)
        frequency, damping = columns["frequency_hz"][chosen], columns["damping_percent"][chosen]
        assert frequency[0] == pytest.approx(149.9, abs=0.2)
        assert frequency[-3:] == pytest.approx(151.7, abs=0.05)
        assert damping[0] == pytest.approx(0.34, abs=0.02)
        assert damping[-3:] == pytest.approx(0.14, abs=0.01)
        assert (np.diff(frequency[:20]) > 0.0).all()
        assert (np.diff(damping[:20]) < 0.0).all()
