"""Free decays of a model beside those measured: frequency and damping against amplitude."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from shakerproc.comparison.measured import Measured, usable_tests
from shakerproc.comparison.own import TOLERANCE, as_means
from shakerproc.comparison.windows import RUN_IN_PERIODS, EvenWindows, fitted_starts
from shakerproc.data import FloatArray
from shakerproc.errors import DiagnosisError, SimulationError
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.runs.analyses.decays import DISPUTED, harmonic_of, law_words
from shakerproc.runs.result import shown_unit
from shakerproc.simulation import motions_of, prepare, simulate
from shakerproc.spectra.decays import (
    DecayCurve,
    DecayLine,
    DecayReading,
    at_amplitudes,
    decay_curve,
    decay_lines,
    trend_of,
)
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
    model = model.under(test.conditions)
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
    windows = EvenWindows(np.zeros(1, np.int64), n, run_in)
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
            model,
            np.zeros(n),
            test.sample_rate,
            start=begin,
            growth=False,
            tolerance=TOLERANCE,
            solver="quick",
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


SCHEMA: Final = "shakerproc-compare-decays/1"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Departures:
    """Measured less model at the amplitudes that both have.

    Attributes
    ----------
    readings : tuple of DecayReading
        As measured, at these amplitudes.
    frequency, damping : (n,) array
        Measured frequency over the model's less 1, measured damping less the model's [-].
    frequency_error, damping_error : (n,) array
        Half the widths of both intervals of 95 % together [-].
    """

    readings: tuple[DecayReading, ...]
    frequency: FloatArray
    damping: FloatArray
    frequency_error: FloatArray
    damping_error: FloatArray

    @property
    def outside(self) -> float:
        """Share of the stretches in which the intervals of both do not meet [-]."""
        apart = np.abs(self.frequency) > self.frequency_error
        apart |= np.abs(self.damping) > self.damping_error
        return float(np.mean(apart))


def departures_of(mode: ModeDecay) -> Departures | None:
    """Return measured less model; None where they have no amplitude in common."""
    if mode.model is None or not mode.model.fitted or not mode.measured.fitted:
        return None
    fitted = mode.measured.fitted
    model = at_amplitudes(mode.model.fitted, [one.amplitude for one in fitted])
    both = tuple(one for one, known in zip(fitted, model.known, strict=True) if known)
    if not both:
        return None
    return Departures(
        both,
        np.array([one.frequency for one in both]) / model.frequency - 1.0,
        np.array([one.damping for one in both]) - model.damping,
        np.array([one.frequency_error for one in both]) / model.frequency
        + model.frequency_error / model.frequency,
        np.array([one.damping_error for one in both]) + model.damping_error,
    )


def said_of(mode: ModeDecay, test: TestDecays) -> str:
    """Return where a mode and that of the model disagree, and what the model lacks."""
    name = f"{numeral(mode.measured.line.frequency, 4)} Hz"
    lower = harmonic_of(mode.measured.line, [one.measured.line for one in test.modes])
    if lower is not None:
        name = f"{name} (perhaps a harmonic, {lower[0]} times {numeral(lower[1], 4)} Hz)"
    if mode.measured.problem:
        return f"{name}: no curve: {mode.measured.problem}."
    if mode.model is None:
        return f"{name}: the model has no such mode."
    found = departures_of(mode)
    if found is None:
        why = mode.model.problem or "its amplitudes are others"
        return f"{name}: the model's mode at {numeral(mode.model.line.frequency, 4)} Hz: {why}."
    if found.outside <= DISPUTED:
        return f"{name}: the model agrees within the intervals of the measurement."
    first, last = (
        f"{100.0 * found.frequency[i]:+.2g} % in frequency and "
        f"{100.0 * found.damping[i]:+.2g} % of critical in damping"
        for i in (0, -1)
    )
    return (
        f"{name}: measured less model is {first} at the largest amplitude, {last} at the "
        f"smallest. {_lacks(mode)}"
    )


def _lacks(mode: ModeDecay) -> str:
    """Return which law makes the difference."""
    if mode.model is None:
        return ""
    measured, model = mode.measured.fitted, mode.model.fitted
    lacking, beyond = trend_of(measured, model), trend_of(model, measured)
    if lacking is None or beyond is None:
        return "Too few stretches in common tell which law."
    if not lacking.law and beyond.law:
        return f"The model has more than was measured: {_low(law_words(beyond))}"
    law = law_words(lacking)
    if law:
        return f"What the model lacks: {_low(law)}"
    return (
        "The difference is the same at every amplitude: numbers of the linear elements "
        "(stiffness or mass, damping), no further law."
    )


def _low(text: str) -> str:
    return f"{text[0].lower()}{text[1:]}"


def sentences_of(test: TestDecays) -> Iterator[str]:
    """Yield the remarks on a test: on each mode, and on modes that the model has besides."""
    for mode in test.modes:
        yield f"test {test.measured.name}, {said_of(mode, test)}"
    lines = [mode.model.line for mode in test.modes if mode.model is not None]
    alone = [line for line in test.only_model if harmonic_of(line, lines) is None]
    if alone:
        shown = ", ".join(f"{numeral(line.frequency, 4)} Hz" for line in alone)
        yield (
            f"test {test.measured.name}: {shown} of the model rings after the fitted start and "
            "was not measured"
        )


def sentence_of_decays(found: DecayComparison) -> str:
    """Return a sentence on the mode that disagrees most."""
    every = [(test, mode) for test in found.tests for mode in test.modes]
    test, mode = max(every, key=lambda pair: _badness(pair[1], pair[0]))
    return f"Test {test.measured.name}, {said_of(mode, test)}"


def _badness(mode: ModeDecay, test: TestDecays) -> tuple[float, float]:
    """Return how far the model departs: a mode that is missing first, then in intervals."""
    lines = [one.measured.line for one in test.modes]
    if mode.measured.problem or harmonic_of(mode.measured.line, lines) is not None:
        return (-1.0, 0.0)
    found = departures_of(mode)
    if found is None:
        return (1.0, 0.0)
    over = np.abs(found.damping) / found.damping_error
    over += np.abs(found.frequency) / found.frequency_error
    return (0.0, float(np.median(over)))


def decay_rows(found: DecayComparison) -> list[dict[str, Any]]:
    """Return the table: a row for each mode and end of its curve."""
    return [_row(found, test, mode) for test in found.tests for mode in test.modes]


def _row(found: DecayComparison, test: TestDecays, mode: ModeDecay) -> dict[str, Any]:
    name = test.measured.sensors[mode.sensor]
    unit, factor = shown_unit(unit_of(found, name))
    there = departures_of(mode)
    row: dict[str, Any] = {
        "test": test.measured.name, "mode": mode.number, "sensor": name,
        "measured_hz": mode.measured.line.frequency,
        "model_hz": None if mode.model is None else mode.model.line.frequency,
    }  # fmt: skip
    for end, i in (("largest", 0), ("smallest", -1)):
        one = None if there is None else there.readings[i]
        row[f"{end}_amplitude"] = None if one is None else factor * one.amplitude
        row[f"frequency_at_{end}_hz"] = None if one is None else one.frequency
        row[f"frequency_difference_at_{end}_percent"] = (
            None if there is None else 100.0 * float(there.frequency[i])
        )
        row[f"damping_at_{end}_percent"] = None if one is None else 100.0 * one.damping
        row[f"damping_difference_at_{end}_percent"] = (
            None if there is None else 100.0 * float(there.damping[i])
        )
    row["unit"] = unit
    row["stretches"] = 0 if there is None else len(there.readings)
    row["outside_percent"] = None if there is None else 100.0 * there.outside
    row["said"] = said_of(mode, test)
    return row


def unit_of(found: DecayComparison, sensor: str) -> str:
    """Return the SI unit of a sensor of the model."""
    return found.model.sensor_unit(found.model.sensors[sensor])


def curve_columns(found: DecayComparison) -> dict[str, list[Any]]:
    """Return every reading: a row for each mode, whose it is, method and stretch."""
    rows = []
    for test in found.tests:
        for mode in test.modes:
            name = test.measured.sensors[mode.sensor]
            unit, factor = shown_unit(unit_of(found, name))
            curves = [("measured", mode.measured)]
            curves += [] if mode.model is None else [("model", mode.model)]
            for whose, curve in curves:
                both = (("least squares", curve.fitted), ("peaks and crossings", curve.charted))
                rows += [
                    {
                        "test": test.measured.name, "mode": mode.number, "sensor": name,
                        "whose": whose, "method": method, "time_s": one.time,
                        "amplitude": factor * one.amplitude, "unit": unit,
                        "frequency_hz": one.frequency,
                        "frequency_half_width_hz": one.frequency_error,
                        "damping_percent": 100.0 * one.damping,
                        "damping_half_width_percent": 100.0 * one.damping_error,
                    }
                    for method, readings in both for one in readings
                ]  # fmt: skip
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def document_of_decays(found: DecayComparison) -> dict[str, Any]:
    """Return the comparison as compare.json holds it."""
    return {
        "schema": SCHEMA,
        "model": found.model.title,
        "sentence": sentence_of_decays(found),
        "left_out": list(found.left_out),
        "modes": decay_rows(found),
        "tests": [
            {
                "test": test.measured.name,
                "start": test.start.tolist(),
                "free_part_s": (test.measured.responses.shape[1] - test.measured.start)
                / test.measured.sample_rate,
                "said": list(sentences_of(test)),
                "notes": [*test.measured.notes, *test.measured.read],
            }
            for test in found.tests
        ],
    }
