"""Free decays of a model beside those measured: frequency and damping against amplitude."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.measured import Measured, usable_tests
from shakerproc.comparison.own import TOLERANCE, as_means
from shakerproc.comparison.windows import RUN_IN_PERIODS, Windows, fitted_starts
from shakerproc.data import FloatArray
from shakerproc.errors import DiagnosisError, SimulationError
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.simulation import motions_of, prepare, simulate
from shakerproc.spectra.decays import DecayCurve, DecayLine, decay_curve, decay_lines
from shakerproc.testlog import TestLog

NEAR: Final = 1.5
"""Ratio of the frequencies of a measured mode and of a mode of the model beyond which they are
never one [-]."""

QUIETER: Final = 0.01
"""Noise that is added to the motion of a model, over that of the measurement [-]: what has come
to rest has no frequency."""

TAIL: Final = 0.1
"""Share of a decay at its end that tells its noise [-]."""

_INTEGRATIONS: Final = {"acceleration": 2, "velocity": 1, "relative velocity": 1}


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModeDecay:
    """One mode of a measured decay, and the same mode of the model.

    Attributes
    ----------
    number : int
        Of the mode, from 1.
    sensor : int
        Place of the sensor that shows it best.
    measured : DecayCurve
        As measured.
    model : DecayCurve, optional
        Of the model in the same sensor; None where the model has no such mode.
    """

    number: int
    sensor: int
    measured: DecayCurve
    model: DecayCurve | None


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestDecays:
    """One test.

    Attributes
    ----------
    measured : Measured
        The test.
    modes : tuple of ModeDecay
        Lowest first.
    only_model : tuple of DecayLine
        Lines of the model that were not measured.
    start : (n_motions,) array
        Displacements and velocities with which the model begins, fitted [SI].
    """

    __test__ = False
    measured: Measured
    modes: tuple[ModeDecay, ...]
    only_model: tuple[DecayLine, ...]
    start: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class DecayComparison:
    """A model compared with free decays.

    Attributes
    ----------
    model : Model
        The model, which nothing drives.
    tests : tuple of TestDecays
        In the order of the log.
    left_out : tuple of str
        Which tests took no part, a sentence each.
    """

    model: Model
    tests: tuple[TestDecays, ...]
    left_out: tuple[str, ...] = ()


def compare_decays(
    model: Model,
    log: TestLog,
    *,
    tell: Callable[[str], None] = lambda _: None,
    warn: Callable[[str], None] = lambda _: None,
) -> DecayComparison:
    """Return frequency and damping against amplitude, of the tests of a log and of a model.

    Parameters
    ----------
    model : Model
        The model; nothing drives it, and its sensors name the channels.
    log : TestLog
        The campaign.
    tell : callable
        Told what is going on.
    warn : callable
        Told, before the work, which tests are left out and of faulty channels.

    Raises
    ------
    DiagnosisError
        If the model and the log do not fit together.
    ShakerprocError
        If a recording cannot be used, or the model runs away.
    """
    usable = usable_tests(log, model)
    usable.tell(warn)
    found = []
    for test in usable.tests:
        tell(f"test {test.name}")
        found.append(decays_of(model, test))
    return DecayComparison(model, tuple(found), usable.left_out)


def decays_of(model: Model, test: Measured) -> TestDecays:
    """Return the modes of a decay, and those of the model after a start that is fitted.

    Raises
    ------
    DiagnosisError
        If no mode stands out of the noise.
    SimulationError
        If the model runs away; the message opens with the run.
    """
    rows = test.responses[:, test.start :]  # with the rest at its end, which tells the noise
    rate = test.sample_rate
    noise = rows[:, -max(int(TAIL * rows.shape[1]), 2) :].std(axis=1)
    count = test.test.processing.peaks.count
    lines = decay_lines(rows, rate, test.excited, count=count)
    if not lines:
        raise DiagnosisError(
            f"{test.run}: no mode stands out of the noise within {numeral(test.excited[0], 4)} "
            f"to {numeral(test.excited[1], 4)} Hz of this decay; correct from and to of the "
            "test"
        )
    start = _start(model, test, rows, lines[0].frequency)
    motion = _motion(model, test, start, rows.shape[1])
    generator = np.random.default_rng(0)
    quiet = QUIETER * noise[:, np.newaxis]
    motion = motion + quiet * generator.standard_normal(motion.shape)
    own = decay_lines(motion, rate, test.excited, noise=noise)
    pairs = _paired(lines, own)
    modes = tuple(
        ModeDecay(
            number,
            line.row,
            decay_curve(rows[line.row], rate, line),
            None if other is None else decay_curve(motion[line.row], rate, other),
        )
        for number, (line, other) in enumerate(zip(lines, pairs, strict=True), 1)
    )
    left = tuple(line for line in own if all(line is not one for one in pairs))
    return TestDecays(test, modes, left, start)


def _start(model: Model, test: Measured, rows: FloatArray, lowest: float) -> FloatArray:
    """Return the motion at the start, fitted to the first periods of the lowest mode [SI]."""
    n, rate = rows.shape[1], test.sample_rate
    run_in = min(round(RUN_IN_PERIODS * rate / lowest), n // 2)
    windows = Windows(np.zeros(1, np.int64), n, run_in)
    given = prepare(np.zeros(n), rate, tolerance=TOLERANCE)
    sizes = _sizes(model, rows[:, :run_in], 2.0 * np.pi * lowest)
    found: FloatArray = fitted_starts(model, given, as_means(model, rows), windows, sizes)[0]
    return found


def _sizes(model: Model, rows: FloatArray, omega: float) -> FloatArray:
    """Return the size of every motion as the loudest sensor tells it, at one frequency [SI]."""
    sensors = model.sensors.values()
    displacement = max(
        float(np.std(row)) / omega ** _INTEGRATIONS.get(sensor.measures, 0)
        for row, sensor in zip(rows, sensors, strict=True)
    )
    by_kind = {"x": displacement, "v": omega * displacement}
    return np.array([by_kind.get(name.split()[0], 0.0) for name in motions_of(model)])


def _motion(model: Model, test: Measured, start: FloatArray, n: int) -> FloatArray:
    """Return the signals of the model's sensors after a start, (n_sensors, n) array.

    Raises
    ------
    SimulationError
        If the model runs away; the message opens with the run.
    """
    names = [name[2:] for name in motions_of(model) if name.startswith("x ")]
    begin = {
        name: (float(start[i]), float(start[len(names) + i])) for i, name in enumerate(names)
    }
    try:
        found = simulate(
            model, np.zeros(n), test.sample_rate, start=begin, growth=False, tolerance=TOLERANCE
        )
    except SimulationError as error:
        raise SimulationError(f"{test.run}: {error}") from error
    return np.array([found.outputs[name] for name in test.sensors])


def _paired(lines: Sequence[DecayLine], own: Sequence[DecayLine]) -> list[DecayLine | None]:
    """Return the line of the model for each measured one: the nearest first, each once."""
    apart = sorted(
        (abs(np.log(b.frequency / a.frequency)), i, j)
        for i, a in enumerate(lines)
        for j, b in enumerate(own)
    )
    found: list[DecayLine | None] = [None] * len(lines)
    taken: set[int] = set()
    for distance, i, j in apart:
        if distance < np.log(NEAR) and found[i] is None and j not in taken:
            found[i] = own[j]
            taken.add(j)
    return found
