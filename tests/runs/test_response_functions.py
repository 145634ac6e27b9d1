"""A response function between any two channels says its unit and its name."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, ResponseFunction, Test, Welch

MASS, RATE = 2.5, 2000.0
UNITS = {"m/s^2": "response", "N": "force", "m": "displacement", "m/s": "velocity"}


def function(of, over, factor=1.0 / MASS):
    """An output that is the input times a factor, and a little noise."""
    rng = np.random.default_rng(1)
    x = rng.standard_normal(100_000)
    rows = np.array([x, factor * x + 1e-4 * rng.standard_normal(x.size)])
    channels = (
        Channel("in", over, "in", over, UNITS[over]),
        Channel("out", of, "out", of, UNITS[of]),
    )
    test = Test(
        1,
        excitation="random",
        from_hz=10.0,
        to_hz=900.0,
        processing=Processing(crop=None, response_functions=(ResponseFunction("in", "out"),)),
    )
    one, *_ = process_recording(recording_of_arrays("run", channels, rows, RATE), test).analyses
    return one.summary[0], one.columns


@pytest.mark.parametrize(
    ("of", "over", "name", "unit", "scale"),
    [
        ("m/s^2", "N", "accelerance", "g/N", 1.0 / 9.80665),
        ("m/s", "N", "mobility", "m/s/N", 1.0),
        ("m", "N", "receptance", "m/N", 1.0),
        ("N", "m/s^2", "apparent mass", "N/g", 9.80665),
        ("N", "m", "dynamic stiffness", "N/m", 1.0),
        ("m/s^2", "m/s^2", "transmissibility", "1", 1.0),
        ("m/s^2", "m", "response function", "g/m", 1.0 / 9.80665),
    ],
)
def test_units_and_names(of, over, name, unit, scale):
    row, columns = function(of, over)
    assert (row["name"], row["unit"]) == (name, unit)
    (header,) = [h for h in columns if h.startswith("h1_out_over_in_magnitude")]
    inside = columns["excited_out_over_in"]
    assert_allclose(columns[header][inside], scale / MASS, rtol=1e-3)
    assert_allclose(columns["h1_out_over_in_phase_deg"][inside], 0.0, atol=0.1)
    assert row["mean_coherence"] > 0.999


def test_headers_say_the_unit():
    _, columns = function("m/s^2", "N")
    assert "h1_out_over_in_magnitude_g_per_N" in columns


def driven_by_a_force(channels, rows, asked=()):
    test = Test(
        1,
        excitation="random",
        from_hz=10.0,
        to_hz=400.0,
        processing=Processing(
            crop=None, welch=Welch(4096, 2048, window="hann"), response_functions=asked
        ),
    )
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


FORCE = Channel("hammer", "N", "hammer", "N", "force")
SENSORS = tuple(Channel(name, "m/s^2", name, "g", "response") for name in ("ch1", "ch2"))


def oscillator(noise=0.0):
    """Force and accelerations of a mass on a spring and a damper; the second is a half.

    Returns
    -------
    (3, n) array and the accelerance [1/kg] as a function of frequency [Hz].
    """
    omega, zeta = 2.0 * np.pi * 100.0, 0.02

    def accelerance(frequency):
        s = 2j * np.pi * frequency
        return s**2 / (s**2 + 2.0 * zeta * omega * s + omega**2) / MASS

    rng = np.random.default_rng(7)
    force = rng.standard_normal(400_000)
    spectrum = np.fft.rfft(force) * accelerance(np.fft.rfftfreq(force.size, 1.0 / RATE))
    response = np.fft.irfft(spectrum, force.size)
    rows = np.array([force, response, 0.5 * response])
    rows[0] += noise * rng.standard_normal(force.size)
    return rows, accelerance


def test_a_lone_force_is_the_input_of_every_response():
    rows, accelerance = oscillator()
    one, *_ = driven_by_a_force((FORCE, *SENSORS), rows).analyses
    assert [row["function"] for row in one.summary] == ["ch1 / hammer", "ch2 / hammer"]
    frequency = one.columns["frequency_hz"]
    far = one.columns["excited_ch1_over_hammer"] & (np.abs(frequency - 100.0) > 15.0)
    truth = accelerance(frequency) / 9.80665
    for kind in ("h1", "h2", "hv"):
        found = one.columns[f"{kind}_ch1_over_hammer_magnitude_g_per_N"]
        assert_allclose(found[far], np.abs(truth)[far], rtol=0.04)
        half = one.columns[f"{kind}_ch2_over_hammer_magnitude_g_per_N"]
        assert_allclose(half[far], 0.5 * found[far], rtol=1e-9)
    phase = np.radians(one.columns["h1_ch1_over_hammer_phase_deg"])
    assert_allclose(np.exp(1j * phase)[far], np.exp(1j * np.angle(truth))[far], atol=0.03)
    assert one.columns["coherence_ch1_over_hammer"][far].min() > 0.98


def test_noise_on_the_force_lowers_h1_and_half_as_much_hv():
    """The force's density grows by 1 + share: H1 falls by it, Hv by its root, H2 stays."""
    rows, accelerance = oscillator(noise=0.5)
    one, *_ = driven_by_a_force((FORCE, *SENSORS), rows).analyses
    frequency = one.columns["frequency_hz"]
    far = (frequency > 150.0) & (frequency < 400.0)
    truth = np.abs(accelerance(frequency)) / 9.80665
    for kind, factor in (("h1", 1.0 / 1.25), ("hv", 1.25**-0.5), ("h2", 1.0)):
        found = one.columns[f"{kind}_ch1_over_hammer_magnitude_g_per_N"]
        assert np.mean(found[far] / truth[far]) == pytest.approx(factor, rel=0.01)


def test_a_force_that_does_not_move_is_no_input_unless_the_log_says_so():
    rows, _ = oscillator()
    rows[0] = 0.0
    assert driven_by_a_force((FORCE, *SENSORS), rows).analyses == ()


def test_what_the_log_asks_for_replaces_what_is_usual():
    rows, _ = oscillator()
    asked = (ResponseFunction("ch1", "ch2"),)
    one, *_ = driven_by_a_force((FORCE, *SENSORS), rows, asked).analyses
    assert [row["function"] for row in one.summary] == ["ch2 / ch1"]


@pytest.mark.shared
def test_a_published_test_driven_by_its_first_channel_gives_its_authors_functions(shared):
    """cued_gc4, by the way of a log whose first channel is a force."""
    time = np.load(shared / "data" / "cued_gc4" / "time_data.npz")
    stored = np.load(shared / "data" / "cued_gc4" / "tf_data.npz")
    channels = (
        FORCE,
        *(Channel(f"ch{i}", "m", f"ch{i}", "m", "response") for i in range(1, 5)),
    )
    test = Test(
        1,
        processing=Processing(
            crop=None,
            detrend="segment mean",
            welch=Welch(12728, 6364, window="periodic hann"),
        ),
    )
    recording = recording_of_arrays("gc4", channels, time["y"].T, 1000.0)
    one, *_ = process_recording(recording, test).analyses
    for i, published in enumerate(stored["y"].T, 1):
        found = one.columns[f"h1_ch{i}_over_hammer_magnitude_m_per_N"]
        assert_allclose(found, np.abs(published), rtol=1e-8, atol=1e-10)


def test_of_many_responses_over_a_force_all_are_told_and_the_first_are_drawn():
    rng = np.random.default_rng(5)
    rows = rng.standard_normal((12, 20_000))
    sensors = [Channel(f"a{i}", "m/s^2", f"a{i}", "m/s^2", "response") for i in range(11)]
    one, *_ = driven_by_a_force((FORCE, *sensors), rows).analyses
    assert len(one.summary) == 11
    assert "first 8 of 11 are drawn" in one.title
    assert (
        len({panel.title.split(",")[0] for panel in one.panels}) == 3 * 8 + 1
    )  # coherence of all


def test_lines_without_input_have_no_response_function_in_any_table():
    """A multisine of every fourth line, in whole periods: elsewhere the input is rounding."""
    rate, segment = 512.0, 512
    excited = np.arange(20, 200, 4)
    spectrum = np.zeros(segment // 2 + 1, dtype=complex)
    spectrum[excited] = np.exp(2j * np.pi * np.random.default_rng(3).random(excited.size))
    control = np.tile(np.fft.irfft(spectrum, segment), 20)
    noise = 1e-3 * control.std() * np.random.default_rng(4).standard_normal(control.size)
    channels = (
        Channel("table", "m/s^2", "table", "g", "control"),
        Channel("ch3", "m/s^2", "ch3", "g", "response"),
    )
    test = Test(
        1,
        excitation="random",
        from_hz=15.0,
        to_hz=200.0,
        processing=Processing(
            crop=None,
            welch=Welch(segment=segment, overlap=0, window="rectangular"),
            response_functions=(ResponseFunction("table", "ch3"),),
        ),
    )
    rows = np.array([control, 2.0 * control + noise])
    result = process_recording(recording_of_arrays("run", channels, rows, rate), test)
    (pair,) = [one.columns for one in result.analyses if one.kind == "response_functions"]
    tables = (
        np.abs(result.averages.against.h1[0]), np.abs(result.averages.against.h2[0]),
        np.abs(result.averages.against.hv[0]), np.sqrt(result.averages.against.psd_ratio[0]),
        *(pair[f"{kind}_ch3_over_table_magnitude"] for kind in ("h1", "h2", "hv")),
        pair["h1_ch3_over_table_low"], pair["h1_ch3_over_table_high"],
    )  # fmt: skip
    for values in tables:
        assert np.flatnonzero(np.isfinite(values)).tolist() == excited.tolist()
        assert_allclose(values[excited], 2.0, rtol=0.01)
