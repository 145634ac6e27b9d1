"""The tones of a sine on random, each judged by itself: frequency and amplitude."""

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from shakerproc.data import Recording
from shakerproc.numerals import numeral
from shakerproc.runs import levels
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.analysis import Analysis, Cell
from shakerproc.runs.levels import AMPLITUDE_TOLERANCE
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.runs.tones import frequency_tolerance
from shakerproc.spectra.tones.lines import MixedTones
from shakerproc.testlog.excitation import DemandedTone


@final
class ToneAnalysis(AbstractAnalysis):
    """Frequency and amplitude of every tone against those that the log demands."""

    kind: ClassVar[str] = "tones"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the tones of a run; None where none are taken out of it."""
        del recording  # they stand in the result
        tones = result.tones
        if tones is None:
            return None
        unit, factor = shown_unit(_control_unit(result))
        demanded = result.test.tones or (None,) * tones.frequency.size
        rows = tuple(_row(tones, k, one, factor, unit) for k, one in enumerate(demanded))
        return Analysis(
            kind=self.kind,
            title="Tones",
            columns={
                **{key: [row[key] for row in rows] for key in rows[0]},
                **_responses(result, tones),
            },
            summary=rows,
            panels=(),
            told=(
                _tone_sentences(rows, unit),
                "Level, control density, profile, densities, response functions and peaks are "
                "those of the random vibration without these tones.",
            ),
            problems=tuple(
                text
                for k, row in enumerate(rows)
                for text in (_missed(row, unit), _moved(tones, k, row))
                if text
            ),
        )


def _control_unit(result: RunResult) -> str:
    return result.channels[levels.watched(result.test, result.channels)[0]].unit


def _row(
    tones: MixedTones, k: int, demanded: DemandedTone | None, factor: float, unit: str
) -> dict[str, Cell]:
    """Return the numbers of a tone, beside its demand in the log."""
    frequency, amplitude = float(tones.frequency[k]), float(abs(tones.control[k]))
    parts = np.abs(tones.parts[:, k]) * factor
    level = None if demanded is None else demanded.level
    wanted = None if demanded is None else demanded.frequency
    kept: list[bool] = []
    if wanted is not None:
        kept.append(abs(frequency - wanted) <= frequency_tolerance(wanted))
    if level is not None:
        kept.append(abs(amplitude / level - 1.0) <= AMPLITUDE_TOLERANCE)
    return {
        "frequency_hz": frequency,
        "demanded_hz": wanted,
        "tolerance_hz": None if wanted is None else frequency_tolerance(wanted),
        "amplitude": amplitude * factor,
        "amplitude_error": float(tones.error[k]) * factor,
        "demanded_amplitude": None if level is None else level * factor,
        "tolerance_percent": None if level is None else 100.0 * AMPLITUDE_TOLERANCE,
        "unit": unit,
        "least_in_parts": float(parts.min()),
        "largest_in_parts": float(parts.max()),
        "kept": all(kept) if kept else None,
    }


def _responses(result: RunResult, tones: MixedTones) -> dict[str, Sequence[float]]:
    """Return the amplitude of every channel at each tone."""
    columns: dict[str, Sequence[float]] = {}
    for channel, values in zip(result.channels, np.abs(tones.amplitude), strict=True):
        unit, factor = shown_unit(channel.unit)
        columns[f"amplitude_{channel.name}{spelled(unit)}"] = list(values * factor)
    return columns


def _tone_sentences(rows: Sequence[dict[str, Cell]], unit: str) -> str:
    """Return every tone in a sentence, with its verdict where there is one."""
    words = {True: ", kept", False: ", NOT KEPT", None: ""}
    return "Tones of the control: " + "; ".join(
        f"{numeral(row['amplitude'])} {unit} at {row['frequency_hz']:.5g} Hz"
        f"{words[None if row['kept'] is None else bool(row['kept'])]}"
        for row in rows
    ) + "."  # fmt: skip


def _missed(row: dict[str, Cell], unit: str) -> str:
    """Return the message on a tone that misses its demand; empty where it does not."""
    if row["kept"] is None or row["kept"]:
        return ""
    said = f"the tone demanded at {row['demanded_hz']:g} Hz"
    if row["demanded_amplitude"] is None:
        demand = f"(tolerance {numeral(row['tolerance_hz'])} Hz)"
    else:
        demand = (
            f"where {numeral(row['demanded_amplitude'])} {unit} is demanded (tolerance "
            f"{row['tolerance_percent']:g} %, {numeral(row['tolerance_hz'])} Hz)"
        )
    return (
        f"{said} is {numeral(row['amplitude'])} {unit} at {row['frequency_hz']:.5g} Hz, "
        f"{demand}"
    )


def _moved(tones: MixedTones, k: int, row: dict[str, Cell]) -> str:
    """Return that a tone is not fixed, where that leaves much of it in the density."""
    whole = tones.control[k]
    apart = np.abs(tones.parts[:, k] - whole).max()
    if not tones.moves[k] or apart <= AMPLITUDE_TOLERANCE * abs(whole):
        return ""
    return (
        f"the tone at {row['frequency_hz']:.5g} Hz moves by up to {apart / abs(whole):.0%} of "
        "its amplitude during the run: only fixed tones are taken out whole, and the density "
        "there holds what is left"
    )
