"""The published protocols: free runs of the tests, by a model fitted to the training part.

A set with a protocol has a log `published.yaml` besides its `testlog.yaml`. What is particular
to a test stands in its tags: `free_samples`, which the start is fitted to and which are not
scored, `periodic` for one period of a motion that has run in, `offset` where the sensor has a
constant, which the training part tells.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from shakerproc.comparison.sensors import input_rows, sensor_row, sensors_of
from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.runs import find_crop, open_test
from shakerproc.simulation import Input, prepare, simulate
from shakerproc.testlog import Test, TestLog, read_testlog

TOLERANCE = 1e-9
"""Last terms of a series, as a share of the motion [-]."""

RUN_IN = 0.05
"""Share of a training test after which its unknown start no longer counts [-]."""


@dataclass(frozen=True)
class Samples:
    """Input and first sensor of one test [SI], and its sample rate [Hz]."""

    driven: FloatArray
    measured: FloatArray
    sample_rate: float


@dataclass(frozen=True)
class Constants:
    """What the training part says of constants [SI]: of its input, and of its first sensor."""

    driven: float
    measured: float


def published_errors(model: Model, folder: Path) -> dict[str, float]:
    """Return the rms error of free runs, by test of the protocol, in SI.

    Parameters
    ----------
    model : Model
        Fitted to the training part, of whose input the mean was taken off.
    folder : Path
        Of a set, as `configs.benchmarks.convert` writes it.
    """
    log = read_testlog(folder / "published.yaml")
    constants = training_constants(model, folder)
    return {str(test.id): _rms_error(model, log, test, constants) for test in log.tests}


def training_constants(model: Model, folder: Path) -> Constants:
    """Return the mean of the input, and of what a free run leaves of the sensor."""
    log = read_testlog(folder / "testlog.yaml")
    parts = [samples_of(log, test, model) for test in log.tests if not test.hold_out]
    driven = float(np.mean(np.concatenate([part.driven for part in parts])))
    left = []
    for part in parts:
        given = prepare(part.driven - driven, part.sample_rate, tolerance=TOLERANCE)
        residual = part.measured - _free_run(model, given, None)
        left.append(residual[int(RUN_IN * residual.size) :])
    return Constants(driven, float(np.mean(np.concatenate(left))))


def samples_of(log: TestLog, test: Test, model: Model) -> Samples:
    """Return what drives the model and what its first sensor measured, as recorded."""
    name = next(iter(sensors_of(model)))
    with open_test(log, test) as recording:
        crop = find_crop(recording, test)
        samples = recording.samples(crop.start, crop.stop)
        driven = samples[input_rows(recording, model)].mean(axis=0)
        row = sensor_row(recording, name, model)
        return Samples(driven, samples[row], recording.sample_rate)


def _rms_error(model: Model, log: TestLog, test: Test, constants: Constants) -> float:
    found = samples_of(log, test, model)
    driven = found.driven - constants.driven
    measured = found.measured
    if test.tags.get("offset"):
        measured = measured - constants.measured
    if test.tags.get("periodic"):
        twice = prepare(np.tile(driven, 2), found.sample_rate, tolerance=TOLERANCE)
        return _rms(_free_run(model, twice, None)[driven.size :] - measured)
    given = prepare(driven, found.sample_rate, tolerance=TOLERANCE)
    free = int(test.tags.get("free_samples", 0))
    start = fitted_start(model, given, measured[:free]) if free else None
    return _rms((_free_run(model, given, start) - measured)[free:])


def fitted_start(model: Model, given: Input, measured: FloatArray) -> tuple[float, float]:
    """Return displacement [m] and velocity [m/s] with which a free run follows some samples."""
    beginning = Input(given.pieces[: measured.size - 1], 1, given.sample_rate)
    length = np.ptp(measured) or 1e-12
    time = measured.size / given.sample_rate

    def left(start: FloatArray) -> FloatArray:
        motion = (float(start[0]) * length, float(start[1]) * length / time)
        return (_free_run(model, beginning, motion) - measured) / length

    found = least_squares(left, [measured[0] / length, 0.0], diff_step=1e-4).x
    return float(found[0]) * length, float(found[1]) * length / time


def _free_run(model: Model, given: Input, start: tuple[float, float] | None) -> FloatArray:
    (mass,), (sensor,) = model.masses, model.sensors
    beginning = None if start is None else {mass: start}
    run = simulate(model, given, start=beginning, tolerance=TOLERANCE, growth=False)
    return run.outputs[sensor]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
