"""From the arrays of a campaign to a bench: noise, faults of the samples, hold-out."""

from dataclasses import dataclass

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose.faults import clipped
from shakerproc.diagnose.prepare import Prepared, shifted, signal_slope, upsample, white_level
from shakerproc.diagnosis.data import TestArrays

LEAD_SECONDS = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """What is known to be wrong with the response sensors of all tests.

    Attributes
    ----------
    gain, delay : (n_sensors,) array
        Gain with sign [-] and delay [s].
    hum : mapping of (test, sensor) to ((frequency, cosine, sine), ...)
        Lines to take away.
    """

    gain: FloatArray
    delay: FloatArray
    hum: dict[tuple[int, int], tuple[tuple[float, float, float], ...]]


def no_correction(n_sensors: int) -> Correction:
    """Return the correction of sound sensors."""
    return Correction(np.ones(n_sensors), np.zeros(n_sensors), {})


def prepare(
    test: TestArrays, index: int, fix: Correction, fine: int
) -> tuple[Prepared, dict[int, float]]:
    """Return a test ready for the observer, and the levels at which sensors are clipped."""
    rate = test.sample_rate
    responses = np.array(test.responses, dtype=float)
    weight = np.ones_like(responses)
    levels: dict[int, float] = {}
    for i, row in enumerate(responses):
        found = clipped(row)
        if found is not None:
            weight[i, found[0]] = 0.0
            levels[i] = found[1]
    t = np.arange(responses.shape[1]) / rate
    for (test_index, sensor), lines in fix.hum.items():
        if test_index == index:
            for frequency, cosine, sine in lines:
                angle = 2.0 * np.pi * frequency * t
                responses[sensor] -= cosine * np.cos(angle) + sine * np.sin(angle)
    for i in range(responses.shape[0]):
        responses[i] /= fix.gain[i]
        if fix.delay[i] != 0.0:
            responses[i] = shifted(
                responses[i], float(fix.delay[i]), slope=False, sample_rate=rate
            )
            weight[i] = _shift_mask(weight[i], fix.delay[i] * rate)
    noise = np.array([white_level(row, rate) for row in responses])
    scale = np.sqrt(np.mean(responses**2, axis=1))
    slope = np.stack([signal_slope(r, s, rate) for r, s in zip(responses, noise, strict=True)])
    base = np.mean(test.controls, axis=0)
    inputs = [white_level(row, rate) for row in test.controls]
    input_noise = float(np.sqrt(np.mean(np.square(inputs)) / len(inputs)))
    return Prepared(
        test.name, rate, responses, slope, weight,
        upsample(base, fine), np.maximum(noise, 1e-5 * scale),
        max(input_noise, 1e-6 * float(np.sqrt(np.mean(base**2)))), test.hold_out,
        int(LEAD_SECONDS * rate),
    ), levels  # fmt: skip


def _shift_mask(weight: FloatArray, samples: float) -> FloatArray:
    """Return a mask moved to earlier samples, widened by one to each side."""
    if np.all(weight == 1.0):
        return weight
    moved = np.roll(weight, -round(samples))
    return moved * np.roll(moved, 1) * np.roll(moved, -1)
