"""A response function between any two channels says its unit and its name."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, ResponseFunction, Test

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
    (one,) = process_recording(recording_of_arrays("run", channels, rows, RATE), test).analyses
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
