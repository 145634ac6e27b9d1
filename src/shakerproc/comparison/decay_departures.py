"""Where the curves of a decay and of a model part, and which law that looks like."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from shakerproc.comparison.decays import DecayComparison, ModeDecay, TestDecays
from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.runs.analyses.decays import DISPUTED, harmonic_of, law_words
from shakerproc.runs.result import shown_unit
from shakerproc.spectra.decays import DecayReading, at_amplitudes, trend_of

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
