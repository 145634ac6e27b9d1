"""The budgets of the numbers of a run: levels, peaks, natural frequencies, damping."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import Recording
from shakerproc.numerals import numeral
from shakerproc.runs import levels
from shakerproc.runs.budget import Budget, Contribution, normal, rectangular, unknown
from shakerproc.runs.budget_parts import (
    NOT_QUIET,
    calibration,
    damping,
    is_random,
    of_mode,
    over_mean,
)
from shakerproc.runs.peak_budgets import peak_budgets
from shakerproc.runs.quiet_part import QuietPart, quiet_part
from shakerproc.runs.result import BoolArray, RunResult, shown_ratio, shown_unit
from shakerproc.runs.tracking import SweptReading
from shakerproc.spectra import Damping
from shakerproc.spectra.responses.bounds import mean_square_error

OFFSET_BINS: Final = 3
"""Bins over which a window spreads the mean of a signal [-]."""


def budgets_of(recording: Recording, result: RunResult) -> Iterator[Budget]:
    """Yield the budget of every level, peak and damping of a run."""
    quiet = quiet_part(recording, result)
    yield from _levels(result, quiet)
    yield from peak_budgets(result, quiet)
    for reading in result.swept:
        yield from _of_sweep(result, reading, quiet)
    yield from _decays(result)


def _levels(result: RunResult, quiet: QuietPart | None) -> Iterator[Budget]:
    """Yield the rms of every channel, whole and in the band, and the level of the test."""
    frequency = result.spectra.frequency
    inside = (frequency >= result.band[0]) & (frequency <= result.band[1])
    moving = np.arange(frequency.size) >= OFFSET_BINS
    for i, channel in enumerate(result.channels):
        unit, factor = shown_unit(channel.unit)
        for name, rms, bins in (
            ("rms", float(result.statistics.rms[i]), moving),
            ("rms in band", float(result.band_rms[i]), inside),
        ):
            if rms > 0.0:
                lines = _of_mean_square(result, quiet, (i,), rms**2, bins)
                head = Budget(channel.name, name, None, rms * factor, unit, tuple(lines))
                yield _level(result, head, {i: 1.0})
    level, rows = result.measured_level, levels.watched(result.test, result.channels)
    if level is None or not level.value > 0.0:
        return
    value, unit = level.shown
    power = 2.0 if level.kind == "density" else 1.0
    square = float(np.mean(result.band_rms[list(rows)] ** 2))
    lines = _of_mean_square(result, quiet, rows, square, inside)
    whose = ", ".join(result.channels[i].name for i in rows)
    head = Budget(whose, f"level ({level.kind})", None, value, unit, tuple(lines))
    yield _level(result, head, dict.fromkeys(rows, power / len(rows)), power)


def _level(
    result: RunResult, shares: Budget, powers: Mapping[int, float], power: float = 1.0
) -> Budget:
    """Return the budget of a level, whose lines are given as shares of the mean square.

    The level goes with the root of the mean square to this power.
    """
    lines = (
        line
        if line.given is None
        else replace(line, given=0.5 * power * shares.value * line.given)
        for line in shares.lines
    )
    return replace(shares, lines=(calibration(result, shares.value, powers), *lines))


def _of_mean_square(
    result: RunResult,
    quiet: QuietPart | None,
    rows: Sequence[int],
    square: float,
    bins: BoolArray,
) -> list[Contribution]:
    """Return chance and noise of the mean square of channels, as shares of it."""
    cross, lines = result.spectra, []
    if is_random(result):
        density = result.psd[list(rows)].mean(axis=0)[bins]
        duration = result.crop.n_samples / result.sample_rate
        spread = mean_square_error(density, cross.bin_width, duration, cross.effective_averages)
        source = f"random vibration over {numeral(duration, 4)} s"
        lines.append(normal("random", spread / square, 1.0, source))
    if quiet is None:
        return [*lines, unknown("noise", NOT_QUIET)]
    noise = float(quiet.density[list(rows)].mean(axis=0)[bins].sum()) * cross.bin_width
    return [*lines, rectangular("noise", noise / square, quiet.told)]


def _of_sweep(
    result: RunResult, reading: SweptReading, quiet: QuietPart | None
) -> Iterator[Budget]:
    """Yield frequency and gain of a swept peak, and the damping of its mode."""
    i, mode, at = reading.channel, reading.mode, reading.frequency
    unit, factor = shown_ratio(*result.units_of_response(i))
    channel, name = result.channels[i].name, f"sweep {reading.direction}"
    gain, why = reading.gain * factor, "no linear mode tells what the sweep rate does"
    place = height = unknown("resolution", why)
    if mode is not None:
        source = "distance from what a slow sweep would show"
        place = rectangular("resolution", abs(mode.steady_frequency - at), source)
        off = abs(mode.steady_gain - reading.gain) * factor
        height = rectangular("resolution", off, source)
    yield Budget(channel, f"{name} peak frequency", at, at, "Hz", (place,))
    own = calibration(result, gain, over_mean(i, result.controls))
    noise = unknown("noise", NOT_QUIET)
    if quiet is not None:
        share = _noise_of_sweep(result, reading, quiet)
        noise = rectangular("noise", gain * share, quiet.told)
    yield Budget(channel, f"{name} gain", at, gain, unit or "1", (own, height, noise))
    if mode is not None:
        yield damping(channel, name, at, mode.ratio, mode.ratio * mode.half)


def _noise_of_sweep(result: RunResult, reading: SweptReading, quiet: QuietPart) -> float:
    """Return the noise of response and controls over their amplitudes at a swept peak [-].

    It is all of the noise: what the tracking leaves of it is less.
    """
    near = [
        (abs(float(frequency) - reading.frequency), float(control))
        for sweep in result.tracking.sweeps
        if sweep.direction == reading.direction
        for frequency, control in zip(sweep.frequency, sweep.control, strict=True)
    ]
    amplitude = min(near)[1]
    noise = np.sqrt(2.0) * quiet.rms
    control = float(noise[list(result.controls)].mean())
    return float(noise[reading.channel]) / (amplitude * reading.gain) + control / amplitude


def _decays(result: RunResult) -> Iterator[Budget]:
    """Yield frequency and damping of every mode of a decay, at its largest amplitude."""
    for one in result.analyses:
        if one.kind != "decays" or not one.columns:
            continue
        for row in zip(*one.columns.values(), strict=True):
            cell = dict(zip(one.columns, row, strict=True))
            if cell["method"] != "least squares" or cell["stretch"] != 1:
                continue
            ends = ("", "_low", "_high")
            at, least, most = (float(cell[f"frequency{end}_hz"]) for end in ends)
            ratio, low, high = (0.01 * float(cell[f"damping{end}_percent"]) for end in ends)
            read = Damping(at, least, most, ratio, low, high, None, None, 0.0)
            name = f"decay, mode {cell['mode']}"
            yield from of_mode(cell["channel"], name, at, read)
