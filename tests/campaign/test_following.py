"""Trends follow one mode: of three masses on springs, whose modes scipy computes."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from tests.campaign.test_summary_and_trends import SPECTRUM

from shakerproc.campaign import trends
from shakerproc.campaign.trends import trend_sentence
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary

NAMES = ("bracket", "coupon", "tip")
MASSES = np.diag([0.25, 0.12, 0.03])


def modes(joint):
    """Return frequencies [Hz] and shapes of base - bracket - coupon - tip on springs."""
    k1, k3 = 3.2e6, 4.55e5
    stiffness = np.array([[k1 + joint, -joint, 0], [-joint, joint + k3, -k3], [0, -k3, k3]])
    squared, shapes = scipy.linalg.eigh(stiffness, MASSES)
    return np.sqrt(squared) / (2.0 * np.pi), shapes.T


def run_of(name, joint, tallest, *, level, sensors=NAMES, seen=(0, 1, 2)):
    """Return a run whose tip has a peak at each mode that is seen, one of them the tallest."""
    frequency, shapes = modes(joint)
    ranked = sorted(seen, key=lambda mode: (mode != tallest, mode))
    peaks = tuple(
        PeakSummary(
            frequency[m], frequency[m], 9.0 - rank, None, None, None, None, None, None, "", 0.9,
            shape={
                n: (shapes[m][NAMES.index(n)] / shapes[m][2], 0.0)
                for n in sensors
            },
        )
        for rank, m in enumerate(ranked)
    )  # fmt: skip
    facts = {"excitation": "random", "joint": "radial", "level_g2_per_hz": level}
    tip = ChannelSummary("tip", "response", "g", "tip", *([None] * 8), psd_peaks=peaks)
    return RunSummary(name, "done", facts, channels=(tip,), spectrum=SPECTRUM)


LEVELS = ((1.9e5, 0.001), (2.3e5, 0.004), (2.7e5, 0.016), (3.1e5, 0.03))


@pytest.mark.parametrize("sensors", [NAMES, ("tip",)])
def test_a_trend_follows_the_first_mode_where_the_third_makes_the_tallest_peak(sensors):
    runs = [
        run_of(str(i), joint, 2 if i == 2 else 0, level=level, sensors=sensors)
        for i, (joint, level) in enumerate(LEVELS)
    ]
    found = trends.peaks_of(runs, "tip")
    assert [one.frequency_hz for one in found] == [modes(joint)[0][0] for joint, _ in LEVELS]
    first, third = modes(LEVELS[0][0])[0][0], modes(LEVELS[2][0])[0][2]
    request = next(r for r in trends.standard_trends(runs) if r.x == "level_g2_per_hz")
    caption = trends.trend(runs, request, "tip").caption
    assert f"{third:.4g} Hz in test 2" in caption
    assert ("by shape" if len(sensors) > 1 else "by continuity") in caption
    assert f"from {first:.0f} Hz at 0.001" in trend_sentence(runs, "tip")


def test_the_first_sentence_says_where_the_tallest_peak_is_of_another_mode():
    runs = [
        run_of(str(i), joint, 2 if i == 3 else 0, level=level)
        for i, (joint, level) in enumerate(LEVELS)
    ]
    told = trend_sentence(runs, "tip")
    frequency = modes(LEVELS[3][0])[0]
    assert f"to {frequency[0]:.0f} Hz at 0.03" in told
    assert f"Another mode makes the tallest peak: {frequency[2]:.4g} Hz in test 3." in told


def test_a_run_without_a_peak_of_the_mode_takes_no_part():
    runs = [
        run_of("0", 1.9e5, 0, level=0.001),
        run_of("1", 2.3e5, 0, level=0.004),
        run_of("2", 2.7e5, 2, level=0.016, seen=(1, 2)),
    ]
    assert trends.peaks_of(runs, "tip")[2].frequency_hz is None
    assert (
        "(no peak of the mode there)"
        in trends.trend(
            runs,
            next(r for r in trends.standard_trends(runs) if r.x == "level_g2_per_hz"),
            "tip",
        ).caption
    )


def test_a_step_that_may_lead_to_another_mode_is_told_where_shapes_cannot_tell():
    """Of one sensor: from 173 Hz (and 586 Hz) to 343 Hz (and 645 Hz) is more than half-way."""
    joint = 1.2e6
    runs = [
        run_of("0", 1.9e5, 0, level=0.001, sensors=("tip",)),
        run_of("1", 1.9e5, 0, level=0.002, sensors=("tip",)),
        run_of("2", joint, 0, level=0.016, sensors=("tip",)),
    ]
    first, second = modes(1.9e5)[0][:2]
    assert modes(joint)[0][0] > np.sqrt(first * second)
    request = next(r for r in trends.standard_trends(runs) if r.x == "level_g2_per_hz")
    caption = trends.trend(runs, request, "tip").caption
    assert "From test 1 to 2 it moves further than half-way" in caption
    assert trend_sentence(runs, "tip").endswith("whether test 0 and test 2 show one mode.")


def test_two_peaks_of_one_shape_in_one_run_are_one_mode():
    """A sweep whose resonance jumps has two peaks beside each other."""
    run = run_of("0", 1.9e5, 0, level=0.001)
    tip = run.channels[0]
    twin = PeakSummary(
        *(1.03 * tip.psd_peaks[0].frequency_hz,) * 2, 5.0, None, None, None, None, None, None,
        "", 0.9, shape=tip.psd_peaks[0].shape,
    )  # fmt: skip
    tip = replace(tip, psd_peaks=(tip.psd_peaks[0], twin, *tip.psd_peaks[1:]))
    jumped = replace(run, test="1", channels=(tip,))
    other = run_of("2", 2.05e5, 0, level=0.016)
    found = trends.peaks_of([run, jumped, other], "tip")
    assert [one.frequency_hz is not None for one in found] == [True, True, True]
    assert found[2].frequency_hz == modes(2.05e5)[0][0]
