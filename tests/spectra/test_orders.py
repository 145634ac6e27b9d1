"""Order tracking, against run-ups whose orders have known amplitudes and phases."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import Channel, ChannelUse, recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.runs import process_recording
from shakerproc.spectra.tones.orders import rotation
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.processing import (
    Distribution,
    Octaves,
    Orders,
    ThresholdCrop,
    Waterfall,
)

RATE = 4096.0
TIME = np.arange(int(20.0 * RATE)) / RATE
START, SLOPE = 10.0, 2.0  # rev/s and rev/s²: 600 to 3000 rev/min in 20 s
ANGLE = START * TIME + 0.5 * SLOPE * TIME**2
SPEED = 60.0 * (START + SLOPE * TIME)


def tachometer(pulses=1, *, noise=0.0):
    """Square pulses of 5 V, half of each tooth, rising at whole teeth."""
    square = np.where((ANGLE * pulses + 1e-9) % 1.0 < 0.5, 5.0, 0.0)
    return square + noise * np.random.default_rng(4).standard_normal(TIME.size)


def analysis_of(response, asked, kind, pulses=1):
    channels = (
        Channel("tachometer", "V", "tachometer", "V", "response"),
        Channel("bearing", "m/s^2", "bearing", "m/s^2", "response"),
    )
    test = Test(1, excitation="random", from_hz=5.0, to_hz=900.0, processing=asked)
    rows = np.array([tachometer(pulses), response])
    recording = recording_of_arrays("run", channels, rows, RATE)
    found = process_recording(recording, test).analyses
    return next(one for one in found if one.kind == kind)


def orders_of(response, pulses=1, **how):
    asked = Orders(pulses_per_revolution=pulses, **how)
    return analysis_of(response, Processing(crop=None, orders=asked), "orders", pulses)


def test_pulses_give_the_speed_of_the_run_up():
    found = rotation(tachometer(noise=0.1), RATE, 1)
    expected = np.sqrt(START**2 + 2.0 * SLOPE * np.arange(found.pulses.times.size + 1)) - START
    offset = 0 if found.pulses.times[0] < 0.05 else 1  # the first edge is the first sample's
    assert_allclose(
        found.pulses.times,
        expected[offset:][: found.pulses.times.size] / SLOPE,
        atol=1.0 / RATE,
    )
    assert found.revolutions == pytest.approx(ANGLE[-1], abs=2.0)


@pytest.mark.parametrize("pulses", [1, 4])
def test_orders_of_a_run_up_have_their_amplitudes_and_phases(pulses):
    rising = 1e-3 * SPEED  # grows with speed
    # the first edge that is seen ends the first tooth: angles are counted from there
    turned = ANGLE - 1.0 / pulses
    response = (
        3.0 * np.cos(2.0 * np.pi * turned + 0.5)
        + rising * np.cos(2.0 * np.pi * 2.5 * turned - 1.0)
        + 0.2 * np.cos(2.0 * np.pi * 3.0 * turned)
        + 7.0
    )
    found = orders_of(response, pulses, track=(1.0, 2.5, 3.0)).columns
    time, speed = found["time_s"], found["speed_rev_per_min"]
    assert_allclose(speed, np.interp(time, TIME, SPEED), rtol=5e-3)
    g = 9.80665
    assert_allclose(found["order_1_bearing_amplitude_g"] * g, 3.0, rtol=1e-4)
    assert_allclose(found["order_2.5_bearing_amplitude_g"] * g, 1e-3 * speed, rtol=4e-3)
    assert_allclose(found["order_3_bearing_amplitude_g"] * g, 0.2, atol=1e-3)
    assert_allclose(found["order_1_bearing_phase_deg"], np.degrees(0.5), atol=1.0)
    assert_allclose(found["order_2.5_bearing_phase_deg"], np.degrees(-1.0), atol=2.5)


def test_a_fixed_tone_is_an_order_only_where_it_crosses_it():
    found = orders_of(2.0 * np.cos(2.0 * np.pi * 60.0 * TIME), track=(1.0, 2.0))
    row = next(r for r in found.summary if r["order"] == "2" and r["channel"] == "bearing")
    assert row["speed_rev_per_min"] == pytest.approx(1800.0, rel=0.03)  # 60 Hz = 2 * 30 rev/s
    amplitude = found.columns["order_2_bearing_amplitude_g"] * 9.80665
    far = np.abs(found.columns["speed_rev_per_min"] - 1800.0) > 600.0
    assert amplitude.max() > 1.0
    assert amplitude[far].max() < 0.02


def test_a_tachometer_that_rests_is_refused():
    with pytest.raises(SpectrumError, match="0 pulses between 5 and 5"):
        rotation(np.full(1000, 5.0), RATE, 1)


def shaft_with(edges):
    """Pulses of 5 V and 20 samples from each of some times on."""
    samples = np.zeros(TIME.size)
    for edge in edges:
        samples[int(edge * RATE) : int(edge * RATE) + 20] = 5.0
    return samples


EDGES = (np.sqrt(START**2 + 2.0 * SLOPE * np.arange(1, 590)) - START) / SLOPE


@pytest.mark.parametrize(
    ("edges", "missing", "extra"),
    [
        (np.delete(EDGES, 100), [EDGES[99]], []),
        (np.delete(EDGES, [100, 101, 300]), [EDGES[99], EDGES[299]], []),
        (np.sort([*EDGES, 10.01]), [], [10.01]),
        (np.sort([*np.delete(EDGES, 100), 10.01]), [EDGES[99]], [10.01]),
    ],
)
def test_missing_and_extra_pulses_are_found_and_turn_the_shaft_no_further(
    edges, missing, extra
):
    whole, found = rotation(shaft_with(EDGES), RATE, 1), rotation(shaft_with(edges), RATE, 1)
    assert_allclose(found.pulses.missing, missing, atol=2.0 / RATE)
    assert_allclose(found.pulses.extra, extra, atol=2.0 / RATE)
    assert found.revolutions == whole.revolutions == EDGES.size - 1
    assert_allclose(found.angle(TIME[2000:-2000]), whole.angle(TIME[2000:-2000]), atol=0.01)


def test_irregular_pulses_are_told_with_channel_and_time_and_half_of_them_refused():
    channels = (
        Channel("tacho", "V", "tacho", "V", "tachometer"),
        Channel("bearing", "m/s^2", "bearing", "m/s^2", "response"),
    )
    asked = Processing(crop=None, orders=Orders("tacho"))
    test = Test(1, excitation="random", from_hz=5.0, to_hz=900.0, processing=asked)
    noise = np.random.default_rng(5).standard_normal(TIME.size)

    def orders_told(samples):
        recording = recording_of_arrays("run", channels, np.array([samples, noise]), RATE)
        return process_recording(recording, test).analyses[0].sentences

    edges = np.sort([*np.delete(EDGES, 100), 10.01])
    told = " ".join(orders_told(shaft_with(edges)))
    assert f"Tachometer tacho: pulses missing at {EDGES[99]:.3f}"[:-1] in told
    assert "Tachometer tacho: extra pulses at 10.0" in told
    assert "missing" not in " ".join(orders_told(shaft_with(EDGES)))
    gone = np.delete(EDGES, np.arange(5, 580, 5))
    with pytest.raises(SpectrumError, match="tachometer tacho: 115 gaps and 0 extra among"):
        orders_told(shaft_with(gone))


def test_one_spike_does_not_move_the_trigger_level():
    samples = tachometer()
    samples[5000] = 400.0
    assert_allclose(
        rotation(samples, RATE, 1).pulses.times,
        rotation(tachometer(), RATE, 1).pulses.times,
        atol=1e-12,
    )


def test_a_run_of_more_stretches_than_are_fitted_says_so_and_covers_the_whole_run():
    found = orders_of(np.zeros(TIME.size), pulses=4, revolutions=2.0)
    assert not any("stretches" in line for line in found.sentences)
    samples = np.where(np.arange(40000) % 8 < 4, 5.0, 0.0)  # 5000 revolutions
    rate = 1000.0
    channels = (
        Channel("tachometer", "V", "t", "V", "tachometer"),
        Channel("b", "m/s^2", "b", "m/s^2", "response"),
    )
    rows = np.array([samples, np.random.default_rng(5).standard_normal(40000)])
    test = Test(
        1, excitation="random", from_hz=5.0, to_hz=400.0,
        processing=Processing(crop=None, orders=Orders(revolutions=4.0)),
    )  # fmt: skip
    found = process_recording(recording_of_arrays("run", channels, rows, rate), test)
    orders = found.analyses[0]
    assert "2000 of 2498 stretches of 4 revolutions" in " ".join(orders.sentences)
    time = orders.columns["time_s"]
    assert time.size == 2000
    assert time[0] < 0.05
    assert time[-1] > 39.9
    assert_allclose(np.diff(time), np.diff(time)[0], rtol=1e-3)


def test_a_waterfall_shows_a_fixed_tone_everywhere_and_an_order_on_a_line_over_speed():
    response = 5.0 * np.cos(2.0 * np.pi * 400.0 * TIME) + np.cos(2.0 * np.pi * 3.0 * ANGLE)
    asked = Processing(crop=None, orders=Orders(), waterfall=Waterfall(spectra=20))
    found = analysis_of(response, asked, "waterfall").columns
    speed = found["speed_rev_per_min"].reshape(20, -1)
    frequency = found["frequency_hz"].reshape(20, -1)
    amplitude = found["amplitude_bearing_g"].reshape(20, -1) * 9.80665
    assert_allclose(amplitude[frequency == 400.0], 5.0, rtol=0.01)
    assert_allclose(
        speed[:, 0], np.interp(found["time_s"].reshape(20, -1)[:, 0], TIME, SPEED), rtol=0.01
    )
    low = frequency[0] < 300.0
    ridge = frequency[0][low][np.argmax(amplitude[:, low], axis=1)]
    assert_allclose(ridge, 3.0 * speed[:, 0] / 60.0, atol=8.0)  # half a step of speed and a bin


def with_tachometer(role, asked):
    channels = (
        Channel("tacho", "V", "tacho", "V", role),
        Channel("base", "m/s^2", "base", "m/s^2", "control"),
        Channel("bearing", "m/s^2", "bearing", "m/s^2", "response"),
    )
    uses = tuple(ChannelUse(c.name, c.role) for c in channels)
    test = Test(
        1, excitation="random", from_hz=5.0, to_hz=900.0, processing=asked, channels=uses
    )
    base = np.random.default_rng(5).standard_normal(TIME.size)
    rows = np.array([tachometer(), base, 0.1 * base])  # 5 V of pulses beside 0.1 m/s^2
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


def test_a_tachometer_is_no_response():
    asked = Processing(
        crop=None,
        orders=Orders(tachometer="tacho"),
        octaves=Octaves(),
        distribution=Distribution(),
    )
    found = with_tachometer("tachometer", asked)
    assert [c.name for c in found.channels] == ["base", "bearing"]
    assert found.channels[found.averages.loudest].name == "bearing"
    assert (
        len(found.averages.psd)
        == len(found.averages.bounds.low)
        == found.averages.statistics.rms.size
        == 2
    )
    assert not found.recorded.unused
    for one in found.analyses:
        assert {row["channel"] for row in one.summary} == {"base", "bearing"}
    orders = next(one for one in found.analyses if one.kind == "orders")
    expected = orders_of(np.zeros(TIME.size))
    assert_allclose(
        orders.columns["speed_rev_per_min"], expected.columns["speed_rev_per_min"], rtol=1e-6
    )


def test_a_tachometer_of_which_nothing_is_asked_is_named_as_unused():
    found = with_tachometer("tachometer", Processing(crop=None))
    assert [(c.name, c.why) for c in found.recorded.unused] == [
        ("tacho", "a tachometer, of which no orders are asked for")
    ]


def test_a_crop_may_look_at_the_row_behind_a_tachometer():
    found = with_tachometer("tachometer", Processing(crop=ThresholdCrop("bearing", 0.01)))
    assert found.channels[found.crop_channel].name == "bearing"
