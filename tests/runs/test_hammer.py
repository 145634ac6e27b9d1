"""A hammer test, simulated in closed form: what is known comes back, bad blows are named."""

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import io
from tests.struck import MODES, RATE, accelerance, half_sine, struck

from shakerproc.data import Channel, ChannelUse, recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.runs import process_recording
from shakerproc.spectra.responses import power_share
from shakerproc.testlog import Hammer, Peaks, Processing, Test, TimeCrop
from shakerproc.testlog.excitation import Amount

CHANNELS = (
    Channel("hammer", "N", "hammer", "N", "force"),
    Channel("near", "m/s^2", "near", "g", "response"),
    Channel("far", "m/s^2", "far", "g", "response"),
)
G = 9.80665
GOOD = tuple((0.5 + 2.0 * k, 100.0 + 20.0 * k) for k in range(6))


def processed(rows, hammer=None, crop=None, channels=CHANNELS, uses=()):
    test = Test(
        1,
        channels=uses,
        excitation="hammer",
        from_hz=20.0,
        to_hz=350.0,
        processing=Processing(crop=crop, hammer=hammer or Hammer()),
    )
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


def found(result, kind):
    (one,) = [one for one in result.analyses if one.kind == kind]
    return one


@pytest.fixture(scope="module")
def good():
    return struck(GOOD, 12.5, noise=(0.05, 0.005))


def test_response_functions_are_those_of_the_structure(good):
    one = found(processed(good, Hammer(length=1.9)), "response_functions")
    frequency = one.columns["frequency_hz"]
    inside = (frequency > 20.0) & (frequency < 350.0)
    for sensor, name in enumerate(("near", "far")):
        truth = accelerance(frequency, sensor)[inside]
        gain = one.columns[f"h1_{name}_over_hammer_magnitude_g_per_N"][inside] * G
        phase = np.radians(one.columns[f"h1_{name}_over_hammer_phase_deg"][inside])
        error = np.abs(gain * np.exp(1j * phase) - truth)
        assert np.median(error / np.abs(truth)) < 0.01
        assert error.max() < 0.02 * np.abs(truth).max()
        assert np.median(one.columns[f"coherence_{name}_over_hammer"][inside]) > 0.999


@pytest.mark.parametrize(
    "hammer",
    [
        Hammer(length=1.9),
        Hammer(length=1.9, force_window=0.01),
        Hammer(length=0.5, force_window=0.01, exponential=Amount(0.01, "1")),
        Hammer(length=1.0, exponential=Amount(0.15, "s"), trigger=Amount(40.0, "N")),
    ],
)
def test_frequency_and_damping_come_back_whatever_the_windows(good, hammer):
    rows = found(processed(good, hammer), "resonances").summary
    for name in ("near", "far"):
        peaks = [row for row in rows if row["function"] == f"{name} / hammer"]
        for row, (frequency, zeta, *_) in zip(peaks[:2], MODES, strict=True):
            assert row["natural_frequency_hz"] == pytest.approx(frequency, rel=5e-4)
            assert row["damping_percent"] == pytest.approx(100.0 * zeta, rel=0.02)


def test_what_the_exponential_window_adds_is_told(good):
    result = processed(good, Hammer(length=0.5, exponential=Amount(0.2, "s")))
    row = found(result, "resonances").summary[0]
    assert row["added_by_window_percent"] == pytest.approx(
        100 / (2 * np.pi * 62.0 * 0.2), rel=1e-3
    )
    (told,) = [text for text in found(result, "blows").sentences if "exponential" in text]
    assert "time constant 0.2 s" in told


def test_bad_blows_are_rejected_with_the_reason_and_the_rest_is_averaged():
    blows = (*GOOD, (2.55, 40.0), (12.6, 150.0))  # a rebound, and one at the end
    rows = struck(blows, 13.0, noise=(0.05, 0.005))
    rows[1:, round(8.4 * RATE) : round(10.4 * RATE)] = 0.005  # a cable came off
    rows[0] = np.minimum(rows[0], 170.0)
    one = found(processed(rows, Hammer(length=1.9)), "blows")
    reasons = [row["reason"] for row in one.summary]
    assert [row["kept"] for row in one.summary] == [
        True,
        False,
        True,
        True,
        False,
        False,
        False,
    ]
    assert "double hit" in reasons[1]
    assert "no response" in reasons[4]
    assert "overload of hammer" in reasons[5]
    assert "the recording ends" in reasons[6]
    assert one.title == "Blows: 3 of 7 averaged"
    assert_allclose([row["time_s"] for row in one.summary[:2]], [0.5, 2.5], atol=2e-3)


def test_a_blow_outside_the_crop_is_none(good):
    result = processed(good, Hammer(length=1.9), TimeCrop(2.2, None))
    assert found(result, "blows").title == "Blows: 5 of 5 averaged"
    assert found(result, "blows").summary[0]["time_s"] == pytest.approx(2.5, abs=2e-3)


def test_a_hammer_the_wrong_way_round_is_named(good):
    (told,) = found(processed(good * [[-1], [1], [1]]), "blows").problems
    assert "hammer is the wrong way round" in told


def test_a_response_that_is_cut_off_says_what_to_do(good):
    (told,) = found(processed(good, Hammer(length=0.3)), "blows").problems
    assert "exponential: 1 %" in told
    assert not found(
        processed(good, Hammer(length=0.3, exponential=Amount(0.01, "1"))), "blows"
    ).problems


def test_a_channel_that_misses_a_blow_is_named(good):
    rows = good.copy()
    rows[2, round(4.4 * RATE) : round(6.4 * RATE)] = 0.0
    (told,) = found(processed(rows, Hammer(length=1.9)), "blows").problems
    assert "far does not respond to blow 3 although" in told


def test_one_blow_is_enough_and_says_that_its_coherence_tells_nothing():
    result = processed(struck([(0.5, 100.0)], 2.5, noise=(0.05, 0.005)))
    (told,) = found(result, "blows").problems
    assert "one average has no coherence" in told
    rows = [r for r in found(result, "resonances").summary if r["function"] == "near / hammer"]
    assert len(rows) <= 3  # chance is that of the noise before the blow
    for row, (frequency, zeta, *_) in zip(rows, MODES, strict=False):
        assert row["natural_frequency_hz"] == pytest.approx(frequency, rel=1e-3)
        assert row["damping_percent"] == pytest.approx(100.0 * zeta, rel=0.02)


def test_no_pretrigger_is_none_and_one_blow_has_room():
    struck_once = struck([(0.5, 100.0)], 2.5, noise=(0.05, 0.005))
    result = processed(struck_once, Hammer(pretrigger=0.0))
    assert result.over_time.blows.setup.cut.before == 0
    told = found(result, "blows").problems[-1]
    assert told.startswith(
        "0 samples in the quiet half of the pretrigger do not tell the noise"
    )
    assert "pretrigger: 7.9 ms" in told  # 16 samples at 2048 Hz
    rows = found(result, "resonances").summary
    assert [row["function"] for row in rows] == ["near / hammer", "far / hammer"]  # one each


@pytest.mark.parametrize("force_window", [None, 0.004, 0.05])
@pytest.mark.parametrize("exponential", [None, Amount(0.3, "s")])
def test_the_noise_of_one_blow_is_that_before_it_whatever_the_windows(
    force_window, exponential
):
    rows = struck([(0.5, 100.0)], 2.5, noise=(0.05, 0.005))
    hammer = Hammer(pretrigger=0.3, force_window=force_window, exponential=exponential)
    result = processed(rows, hammer)
    assert_allclose(result.over_time.blows.noise, [0.05, 0.005, 0.005], rtol=0.15)
    cut = result.over_time.blows.setup.cut
    only_noise = 0.05 * np.random.default_rng(2).standard_normal((400, cut.length)) * cut.window
    if force_window is not None:
        only_noise[:, : round((0.3 - force_window) * RATE)] = 0.0
        only_noise[:, round((0.3 + force_window) * RATE) :] = 0.0
    power = np.mean(np.abs(np.fft.rfft(only_noise)) ** 2)
    wanted = 2.0 * power / (RATE * np.sum(cut.window**2))
    assert result.over_time.blows.noise_density[0] == pytest.approx(wanted, rel=0.3)


def test_a_trigger_within_the_noise_is_one_line(good):
    with pytest.raises(
        SpectrumError, match=r"0\.2 N lies within the noise .*trigger: 0\.4\d? N"
    ):
        processed(good, Hammer(trigger=Amount(0.2, "N")))


def test_a_share_of_a_weak_blow_stays_above_the_noise():
    rows = struck(GOOD[:2], 4.5, noise=(2.0, 0.005))
    one = found(processed(rows, Hammer(length=1.5)), "blows")
    assert one.title == "Blows: 2 of 2 averaged"


def test_blows_have_neither_peaks_nor_bounds_of_their_density(good):
    result = processed(good, Hammer(length=1.9))
    assert result.averages.psd_peaks == ((), (), ())
    assert result.averages.bounds is None


def test_nothing_that_strikes_is_one_line():
    quiet = struck([], 4.0, noise=(0.05, 0.005))
    with pytest.raises(SpectrumError, match=r"run: no blow found: the largest force"):
        processed(quiet)


def test_no_blow_left_says_how_often_and_why():
    rows = struck([(0.5, 100.0), (0.56, 80.0), (2.5, 100.0), (2.56, 80.0)], 5.0, (0.05, 0.005))
    with pytest.raises(SpectrumError, match="none of 2 blows can be used: double hit"):
        processed(rows)


def test_roles_that_are_exchanged_are_named(good):
    other = (
        replace(CHANNELS[0], role="response"),
        replace(CHANNELS[1], role="force"),
        CHANNELS[2],
    )
    with pytest.raises(SpectrumError, match="near rings like a response and hammer strikes"):
        processed(good, Hammer(length=1.9), channels=other)


def test_a_hammer_test_needs_one_force():
    rows = struck(GOOD, 12.5)
    without = (replace(CHANNELS[0], role="response"), *CHANNELS[1:])
    with pytest.raises(SpectrumError, match="needs one channel with the role force"):
        processed(rows, channels=without)


def test_a_block_shorter_than_what_lies_before_is_refused(good):
    with pytest.raises(SpectrumError, match=r"too short for 0\.1 s before the trigger"):
        processed(good, Hammer(length=0.2, pretrigger=0.1))


def at_the_hammer(sensor_direction=None, hammer_direction=None, position=(0.1, 0.0, 0.0)):
    """What a log says of a sensor at the hammer, and of one elsewhere."""
    return (
        ChannelUse("hammer", "force", position=(0.1, 0.0, 0.0), direction=hammer_direction),
        ChannelUse("near", "response", position=position, direction=sensor_direction),
        ChannelUse("far", "response", position=(0.3, 0.0, 0.0)),
    )


UP, DOWN, ACROSS = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("signs", "directions", "wrong"),
    [
        ((1, 1), (None, None), False),
        ((1, -1), (None, None), True),
        ((1, -1), (UP, DOWN), False),
        ((1, 1), (UP, DOWN), True),
        ((-1, 1), (None, None), False),  # the hammer is, and its blows say so
        ((-1, -1), (None, None), True),
    ],
)
def test_a_sensor_the_wrong_way_round_is_named_at_the_driving_point(
    good, signs, directions, wrong
):
    rows = good * np.array([[signs[0]], [signs[1]], [1]])
    one = found(
        processed(rows, Hammer(length=1.9), uses=at_the_hammer(*directions)), "driving_point"
    )
    assert [row["function"] for row in one.summary] == ["near / hammer"]
    assert abs(one.summary[0]["power_in_percent"]) > 99.0
    assert bool(one.problems) == wrong
    assert all("moves against hammer" in text for text in one.problems)


def test_the_exponential_window_leaves_the_driving_point_passive(good):
    """Above its modes it is a mass m: Re Y(s) = Re 1/(m s) at s = sigma + j omega."""
    sigma, hammer = 200.0, Hammer(length=1.0, exponential=Amount(0.005, "s"))
    result = processed(good, hammer, uses=at_the_hammer())
    assert found(result, "driving_point").summary[0]["power_in_percent"] > 99.9
    assert power_share(result.spectra, 0, 1, "m/s^2", (200.0, 350.0)) > 0.999
    two_seconds = processed(good, Hammer(length=1.9)).spectra
    lossless = replace(
        two_seconds,
        matrix=np.array([
            [np.ones(two_seconds.frequency.size), np.full(two_seconds.frequency.size, 0.5)]
        ]),
        decay_rate=sigma,
    )  # F = 1 and A = F / m
    assert power_share(lossless, 0, 1, "m/s^2", (20.0, 350.0)) == pytest.approx(1.0)


def test_a_late_sensor_is_no_driving_point(good):
    rows = good.copy()
    rows[1] = np.roll(good[1], 12)
    (told,) = found(
        processed(rows, Hammer(length=1.9), uses=at_the_hammer()), "driving_point"
    ).problems
    assert "one is late" in told


@pytest.mark.parametrize(
    "uses", [(), at_the_hammer(position=(0.2, 0.0, 0.0)), at_the_hammer(ACROSS, UP)]
)
def test_there_is_no_driving_point_where_the_log_tells_of_none(good, uses):
    result = processed(good, Hammer(length=1.9), uses=uses)
    assert "driving_point" not in {one.kind for one in result.analyses}


def test_where_the_force_falls_is_told(good):
    """A half-sine of 4 ms is 20 dB down first at the frequency where its transform is 0.1."""
    told = " ".join(found(processed(good, Hammer(length=1.9)), "blows").sentences)
    frequency = np.linspace(200.0, 400.0, 2001)
    gain = np.abs(half_sine(frequency, 0.0)) / np.abs(half_sine(np.array([20.0]), 0.0))
    wanted = frequency[np.flatnonzero(gain < 0.1)[0]]
    (said,) = re.findall(r"fallen by 20 dB at (\S+) Hz", told)
    assert float(said) == pytest.approx(wanted, abs=1.0)


@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "rows", "low", "high", "force", "wanted"),
    [
        # one blow on a jointed beam: 151.7 to 149.9 Hz over its decay
        ("ringdown_lms/Sample_LMS_Data.mat", ("f", "x"), 130.0, 170.0, 577.2, (149.9, 151.7)),
        # the last of an analyser's blows, begun at its trigger; 212.11 Hz in its own functions
        (
            "bobcat_analyzer_vibrationtesting/case1.mat",
            ("Time_chan_1", "Time_chan_2"),
            150.0,
            300.0,
            0.086,
            (211.9, 212.3),
        ),
    ],
)
def test_single_blows_of_others_have_their_resonance(
    shared, name, rows, low, high, force, wanted
):
    data = io.loadmat(shared / "data" / name)
    samples = np.array([data[row].ravel() for row in rows], dtype=float)
    rate = float(data["fs" if "fs" in data else "Time_Sample_Rate"].item())
    hammer = Hammer() if "fs" in data else Hammer(pretrigger=0.0)
    test = Test(
        1,
        excitation="hammer",
        from_hz=low,
        to_hz=high,
        processing=Processing(hammer=hammer, peaks=Peaks(count=1)),
    )
    result = process_recording(recording_of_arrays(name, CHANNELS[:2], samples, rate), test)
    (blow,) = found(result, "blows").summary
    assert blow["force_n"] == pytest.approx(force, rel=0.01)
    (peak,) = found(result, "resonances").summary
    assert wanted[0] <= peak["natural_frequency_hz"] <= wanted[1]
