"""Faults of sensors that a fit tells, and those of them that stay in doubt."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.correction import applied_delay, applied_gain
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.result import Finding
from shakerproc.diagnosis.selection.scores import Score

GAIN_TOLERANCE: Final = 0.03
"""Gain error of a sensor from which it is a fault: three times its spread [-]."""

DELAY_TOLERANCE: Final = 40e-6
"""Delay of a channel from which it is a fault: twice its spread [s]."""


def faults_of(found: Found, fit: Fit) -> list[Finding]:
    """Return gains and delays beyond what is usual, with their intervals.

    Those alone whose interval leaves the perfect sensor out, but whatever was taken out of the
    tests is told. Not of a fit to a joint that held: it has none but what imitate that.
    """
    n, n_sensors = fit.hypothesis.size, fit.gain.size
    spread = 1.96 * np.sqrt(np.maximum(np.diag(fit.uncertainty.total), 0.0))
    gains, delays = fit.gain, fit.delay
    if found.corrected:
        gains = gains * applied_gain(found.linear_model)
        delays = delays + applied_delay(found.linear_model)
    if found.late:
        delays = delays + np.array(found.late)
    out = []
    for i, name in enumerate(fit.hypothesis.model.sensors if not found.rigid else ()):
        size, delay = abs(float(gains[i])), float(delays[i])
        own, late = float(spread[n + i]), float(spread[n + n_sensors + i])
        out += _in_the_samples(found, i, name)
        if found.signs and found.signs[i] < 0.0:
            out.append(Finding("sensor_polarity", (name,), {}))
        if abs(size - 1.0) > max(GAIN_TOLERANCE, 0.0 if found.corrected else own):
            value = Estimate(size, size - own, size + own, "1")
            out.append(Finding("sensor_gain", (name,), {"gain": value}))
        taken_out = found.corrected or (found.late and found.late[i] != 0.0)
        if abs(delay) > max(DELAY_TOLERANCE, 0.0 if taken_out else late):
            value = Estimate(delay, delay - late, delay + late, "s")
            out.append(Finding("sensor_delay", (name,), {"delay": value}))
    return out


def doubted(found: Found, chosen: Score, faults: Sequence[Finding]) -> list[Finding]:
    """Return the faults that only a model tells which leaves more than noise.

    They may stand for what is missing in it; not a delay that was seen before all else.
    """
    known = np.isfinite(found.floor_under(chosen)) and not found.is_explained_by(chosen)
    if not known:
        return []
    sensors = found.data.model.sensors
    seen = {name for name, late in zip(sensors, found.late, strict=False) if late}
    return [
        fault
        for fault in faults
        if fault.kind == "sensor_gain"
        or (fault.kind == "sensor_delay" and fault.between[0] not in seen)
    ]


def _in_the_samples(found: Found, sensor: int, name: str) -> list[Finding]:
    """Return the faults of a sensor that show in the samples: clipping, and hum."""
    out = []
    limits = [float(test.limits[sensor]) for test in found.data.tests]
    reached = [limit for limit in limits if np.isfinite(limit)]
    if reached:
        unit = "m/s^2" if found.data.model.sensors[name].measures == "acceleration" else ""
        level = _level(reached, unit)
        out.append(Finding("clipping", (name,), {"level": level}))
    bands = [test.error_band for test in found.data.tests]
    for hum in found.hums:
        if hum.sensor == sensor and any(hum.is_in(band) for band in bands):
            line = Estimate(hum.frequency, hum.frequency, hum.frequency, "Hz")
            out.append(Finding("mains_hum", (name,), {"frequency": line}))
    return out


def _level(reached: Sequence[float], unit: str) -> Estimate:
    """Return the level at which tests are clipped, and between which bounds they say it is.

    No closer than samples of single precision are rounded.
    """
    value = float(np.median(reached))
    rounded = float(np.finfo(np.float32).eps) * value
    return Estimate(value, min(reached) - rounded, max(reached) + rounded, unit)
