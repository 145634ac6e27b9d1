"""Tones: taken out of a recording (sine on random, a notched one), and judged one by one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording, SampleSource
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs import levels
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.averaging import averaged, welch
from shakerproc.runs.levels import AMPLITUDE_TOLERANCE
from shakerproc.runs.panels import Analysis, Cell
from shakerproc.runs.result import (
    NotchResult,
    RunResult,
    shown_unit,
)
from shakerproc.runs.tables import spelled
from shakerproc.spectra import Crop
from shakerproc.spectra.tones.lines import MixedTones, centre_of, check_separable, mixed_tones
from shakerproc.testlog import Test
from shakerproc.testlog.excitation import DemandedTone

FILTERED: Final = 2**20
"""Samples of each channel that a notch is cut into at most, from the middle."""

FREQUENCY_TOLERANCE: Final = ((0.25, 0.05, 0.0), (5.0, 0.0, 0.2), (50.0, 1.0, 0.0))
"""Up to which frequency [Hz] a tone may be how far off: [Hz], and [-] (IEC 60068-2-6)."""

ABOVE: Final = 0.02
"""The same above the last of them [-]."""


def notched(recording: Recording, crop: Crop, test: Test) -> tuple[NotchResult | None, str]:
    """Return the second look that the log asks for, or why it cannot be had."""
    if test.notch_hz is None:
        return None, ""
    longest = FILTERED
    part, problem = crop, ""
    if crop.n_samples > longest:
        first = crop.start + (crop.n_samples - longest) // 2
        part = Crop(first, first + longest)
        problem = (
            f"only {numeral(longest / recording.sample_rate, 4)} s from the middle were "
            "filtered"
        )
    try:
        return _without_tone(recording, part, test, test.notch_hz), problem
    except SpectrumError as error:
        return None, str(error)


def _without_tone(
    recording: Recording, crop: Crop, test: Test, frequency: float
) -> NotchResult:
    """Return the responses without the tone: two periods from the middle, and densities.

    One channel after the other, so that a long recording needs little memory.
    """
    rate, cut = recording.sample_rate, test.processing.notch
    before, after, density = [], [], []
    start, part = 0, slice(0)
    for row, channel in enumerate(recording.channels):
        if channel.role == "control":
            continue
        samples = recording.select([row]).samples(crop.start, crop.stop)
        result = spectra.notch(
            samples, rate, frequency, width=cut.width, harmonics=cut.harmonics, trim=cut.trim
        )
        n_samples, size = result.samples.shape[1], round(2.0 * rate / frequency) + 1
        first = max(0, (n_samples - size) // 2)
        start, part = result.start, slice(first, min(first + size, n_samples))
        before.append(samples[0, start + part.start : start + part.stop].copy())
        after.append(result.samples[0, part].copy())
        density.append(spectra.psd(welch(iter((result.samples,)), rate, test))[0])
    return NotchResult(
        frequency=frequency,
        time=(crop.start + start + np.arange(part.start, part.stop)) / rate,
        before=np.array(before),
        after=np.array(after),
        psd=np.array(density),
    )


def frequency_tolerance(frequency: float) -> float:
    """Return how far a tone may lie from its `frequency` [Hz] by IEC 60068-2-6 [Hz]."""
    for end, fixed, share in FREQUENCY_TOLERANCE:
        if frequency <= end:
            return fixed + share * frequency
    return ABOVE * frequency


@final
@dataclass(frozen=True, slots=True, eq=False)
class _WithoutTones(SampleSource):
    """Samples of a recording less its tones."""

    recording: Recording
    tones: MixedTones
    start: int

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        samples = self.recording.samples(start, stop)[list(rows)]
        rate, first = self.recording.sample_rate, start - self.start
        return samples - self.tones.at(rows, first, stop - start, rate)

    def close(self) -> None:
        """Do nothing: the recording closes its own source."""


def tones_taken_out(
    recording: Recording, crop: Crop, test: Test
) -> tuple[MixedTones | None, Recording]:
    """Return the tones of a sine on random and the recording without them.

    Parameters
    ----------
    recording : Recording
        The recording.
    crop : Crop
        The run in it, outside of which nothing is taken out that means anything.
    test : Test
        What the log says of it.

    Returns
    -------
    MixedTones or None, Recording
        None and the recording itself of any other excitation.

    Raises
    ------
    SpectrumError
        If the controls hold no fixed tone, or the run does not tell its tones apart.
    """
    if test.excitation != "sine on random":
        return None, recording
    controls = levels.watched(test, recording.channels)
    if not controls:
        raise SpectrumError(
            "sine on random: no channel measures its tones; give one the role control"
        )
    mixed = mixed_tones(
        lambda start, stop: recording.samples(crop.start + start, crop.start + stop),
        crop.n_samples,
        recording.sample_rate,
        controls,
        frequency=_places(recording, crop, test, controls),
        stretch=test.processing.welch.segment,
    )
    source = _WithoutTones(recording, mixed, crop.start)
    rows = tuple(range(len(recording.channels)))
    return mixed, replace(recording, source=source, rows=rows)


def _places(
    recording: Recording, crop: Crop, test: Test, controls: Sequence[int]
) -> list[float]:
    """Return where the tones are, near those of the log, else the steady ones [Hz].

    Raises
    ------
    SpectrumError
        If the log says none and none is steady.
    """
    cross, _ = averaged(recording, crop, test)
    if not test.tones:
        band = test.band or (0.0, cross.sample_rate / 2.0)
        lines = spectra.steady_lines(cross, controls, band)
        if not lines:
            raise SpectrumError(
                "sine on random: the controls hold no tone of fixed frequency, and other tones "
                "are not known; state tones: [{frequency: ...}], or excitation: random"
            )
        return sorted(line.frequency for line in lines)
    density = spectra.psd(cross)[list(controls)].mean(axis=0)
    places, stated = [], [tone.frequency for tone in test.tones]
    check_separable(stated, test.processing.welch.segment, cross.sample_rate)
    for tone in test.tones:
        reach = max(frequency_tolerance(tone.frequency), cross.bin_width)
        others = [abs(tone.frequency - one) / 2.0 for one in stated if one != tone.frequency]
        reach = min([reach, *others])
        near = np.abs(cross.frequency - tone.frequency) <= reach
        if not near.any():
            raise SpectrumError(
                f"sine on random: the tone of {tone.frequency:g} Hz lies above half the sample "
                f"rate, {cross.sample_rate / 2.0:g} Hz"
            )
        peak = int(np.argmax(np.where(near, density, -1.0)))
        at = centre_of(cross, density, peak)
        places.append(float(np.clip(at, tone.frequency - reach, tone.frequency + reach)))
    return places


@final
class ToneAnalysis(AbstractAnalysis):
    """Frequency and amplitude of every tone against those that the log demands."""

    kind: ClassVar[str] = "tones"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the tones of a run; None where none are taken out of it."""
        del recording  # they stand in the result
        tones = result.over_time.tones
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
            sentences=(
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
    largest = np.abs(tones.parts[:, k] - whole).max()
    if not tones.moves[k] or largest <= AMPLITUDE_TOLERANCE * abs(whole):
        return ""
    return (
        f"the tone at {row['frequency_hz']:.5g} Hz moves by up to {largest / abs(whole):.0%} "
        "of its amplitude during the run. Only fixed tones are taken out whole; the density "
        "there holds the rest"
    )
