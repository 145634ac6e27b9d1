"""Joints that held: what hangs on them moves as the place that they hang on."""

from typing import Final

import numpy as np

from shakerproc.comparison.free_run_error import in_band
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.residuals import predict
from shakerproc.diagnosis.estimation.windows import every_test
from shakerproc.diagnosis.hypotheses.joints import Joint, joints_of
from shakerproc.errors import ModelError
from shakerproc.models import BASE

HELD: Final = 1.5
"""Difference of both sides over the noise of both up to which a joint held: noise is known to
some 3 dB [-]."""

LINEARITY: Final = 2e-3
"""Share of an acceleration to which two sensors agree, after one gain [-]."""

VISIBLE: Final = 10.0
"""Difference over the noise that the model as it is must show where it held none [-]."""

GAIN: Final = 0.03
"""Gain by which two sensors may differ: three times the spread of data sheets [-]."""


def rigid_joints(data: DataSet) -> tuple[Joint, ...]:
    """Return the joints whose two sides moved alike in every test, as the model would not.

    Both sides need an accelerometer; the base has the controls.
    """
    return tuple(joint for joint in joints_of(data.model) if _held(data, joint))


def _held(data: DataSet, joint: Joint) -> bool:
    moves = _simulated(data)
    if moves is None:
        return False
    visible = False
    for test, simulated in zip(data.tests, moves, strict=True):
        first, second = (_acceleration(data, test, test.responses, side) for side in joint)
        model = [_acceleration(data, test, simulated, side) for side in joint]
        if first is None or second is None or model[0] is None or model[1] is None:
            return False
        part = slice(test.start, test.stop)
        rows = [
            in_band(row, test.sample_rate, test.band)[part]
            for row in (first[0], second[0], model[1][0] - model[0][0])
        ]
        share = float(rows[0] @ rows[1]) / max(float(rows[0] @ rows[0]), 1e-300)
        noise = np.hypot(first[1], second[1])
        limit = np.hypot(noise, LINEARITY * _rms(rows[1]))
        if abs(share - 1.0) > GAIN or _rms(rows[1] - share * rows[0]) > HELD * limit:
            return False
        visible |= _rms(rows[2]) > VISIBLE * limit
    return visible


def _simulated(data: DataSet) -> tuple[FloatArray, ...] | None:
    """Return the signals of the sensors of the model as it is, in every test."""
    try:
        found = predict(data, data.model, every_test(data), None)
    except ModelError:
        return None
    return None if found.failed.any() else found.outputs


def _acceleration(
    data: DataSet, test: PreparedTest, responses: FloatArray, side: str
) -> tuple[FloatArray, float] | None:
    """Return the absolute acceleration of a place and its noise; None where none is known."""
    if side == BASE:
        if not data.model.excitation.moves_base:
            return None
        return test.input, float(np.sqrt(_power(test)))
    for i, sensor in enumerate(data.model.sensors.values()):
        if sensor.measures == "acceleration" and sensor.at == side:
            return responses[i], float(test.noise[i])
    return None


def _power(test: PreparedTest) -> float:
    """Return the power of the noise of the input within the band [(m/s^2)^2]."""
    noise = test.noise_density
    inside = (noise.frequency >= test.band[0]) & (noise.frequency <= test.band[1])
    return float(np.sum(noise.input[inside]) * noise.frequency[0])


def _rms(row: FloatArray) -> float:
    return float(np.sqrt(np.mean(row**2)))
