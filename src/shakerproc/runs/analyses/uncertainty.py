"""Uncertainty budgets by the GUM: expanded uncertainty of every level, peak and damping."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.runs import levels
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.budget import (
    COVERAGE,
    GROUPS,
    NO_SHEET,
    NOT_QUIET,
    Budget,
    Contribution,
    QuietPart,
    bias,
    calibration,
    damping,
    is_random,
    normal,
    of_mode,
    over_mean,
    quiet_part,
    rectangular,
    unknown,
)
from shakerproc.runs.pairs import functions_of
from shakerproc.runs.panels import Analysis, Cell
from shakerproc.runs.result import BoolArray, ResonancePeak, RunResult, shown_ratio, shown_unit
from shakerproc.runs.tracking import SweptReading
from shakerproc.spectra import Damping
from shakerproc.spectra.responses import mean_square_error, tallest_bins

ONE_AVERAGE: Final = "one average tells no scatter"
NOT_RESOLVED: Final = "the bins do not resolve the peak, and no mode fits it"

SEEN: Final = 2.0
"""Half-power width over that of the window from which most of it is the peak's own [-]."""

BESIDE: Final = 4
"""Bins to each side over which the density of noise is averaged [-]."""

OFFSET_BINS: Final = 3
"""Bins over which a window spreads the mean of a signal [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Spectrum:
    """A spectrum with peaks.

    Attributes
    ----------
    quantity, channel, unit : str
        ``psd`` or ``h1``, whose it is, and the unit of its height.
    values, errors : (n_frequencies,) arrays
        The spectrum in that unit [any unit], and its random errors [-].
    factor : float
        From SI to that unit [-].
    power : int
        1 of a density, 2 of a gain: what makes a power of it.
    powers : mapping
        By row, to what the gain of a channel goes into it [-].
    noise : (n_frequencies,) array, optional
        Largest share that noise may be of it [-]; None where nothing tells it.
    noise_origin : str
        Where the noise is from, or why it is not known.
    no_chance : str
        Why the random errors are not known; empty where they are.
    """

    quantity: str
    channel: str
    unit: str
    values: FloatArray
    errors: FloatArray
    factor: float
    power: int
    powers: Mapping[int, float]
    noise: FloatArray | None
    noise_origin: str
    no_chance: str


def peak_budgets(result: RunResult, quiet: QuietPart | None) -> Iterator[Budget]:
    """Yield the budgets of frequency, height, natural frequency and damping of every peak.

    Those of densities are left out where the run is no random vibration: nothing tells the
    scatter of a density that depends on sweep rate and crop.
    """
    for i in range(len(result.channels)) if is_random(result) else ():
        density = _density(result, quiet, i)
        for peak in result.averages.psd_peaks[i]:
            yield from _of_peak(result, density, peak)
    for row, i in enumerate(result.responses):
        if result.averages.against is not None and result.averages.response_peaks[i]:
            unit, factor = shown_ratio(*result.units_of_response(i))
            function = _function(
                result, (result.channels[i].name, unit or "1", factor),
                np.abs(result.averages.against.h1[row]) * factor,
                result.averages.against.coherence[row],
                over_mean(i, result.controls),
            )  # fmt: skip
            for peak in result.averages.response_peaks[i]:
                yield from _of_peak(result, function, peak)
    for function, peak in _resonances(result):
        yield from _of_peak(result, function, peak)


def _density(result: RunResult, quiet: QuietPart | None, i: int) -> _Spectrum:
    """Return the density of a channel."""
    n_averages, psd = result.spectra.effective_averages, result.averages.psd[i]
    unit, factor = shown_unit(result.channels[i].unit)
    noise = None
    if quiet is not None:
        width = 2 * BESIDE + 1
        smooth = np.convolve(quiet.density[i], np.full(width, 1.0 / width), mode="same")
        noise = np.zeros(smooth.shape)
        np.divide(smooth, psd, out=noise, where=psd > 0.0)
    return _Spectrum(
        "psd", result.channels[i].name, levels.density_unit(unit), psd * factor**2,
        np.full(psd.shape, n_averages**-0.5), factor**2, 1, {i: 2.0}, noise,
        NOT_QUIET if quiet is None else quiet.origin,
        "" if n_averages > 1.0 else ONE_AVERAGE,
    )  # fmt: skip


def _function(
    result: RunResult,
    names: tuple[str, str, float],
    gain: FloatArray,
    coherence: FloatArray,
    powers: Mapping[int, float],
) -> _Spectrum:
    r"""Return a response function; its gain lies between H1 and H2.

    .. math:: |H_2| = |H_1| / \gamma^2
    """
    averages = result.spectra.effective_averages
    channel, unit, factor = names
    if averages <= 1.0:
        none = np.zeros(gain.shape)
        return _Spectrum(
            "h1", channel, unit, gain, none, factor, 2, powers, None, ONE_AVERAGE, ONE_AVERAGE
        )
    clipped = np.clip(np.nan_to_num(coherence), 1e-12, 1.0)
    errors = spectra.gain_random_error(clipped, averages)
    return _Spectrum(
        "h1", channel, unit, gain, errors, factor, 2, powers, 1.0 / clipped - 1.0,
        "H2 less H1", "",
    )  # fmt: skip


def _resonances(result: RunResult) -> Iterator[tuple[_Spectrum, ResonancePeak]]:
    """Yield the resonances over forces that their analysis lists."""
    rows = [row for one in result.analyses if one.kind == "resonances" for row in one.summary]
    for pair in functions_of(result) if rows else ():
        names = (pair.label, pair.unit, 1.0)
        powers = over_mean(pair.row, pair.inputs)
        function = _function(result, names, np.abs(pair.h1), pair.coherence, powers)
        for row in rows:
            if row["function"] != pair.label:
                continue
            frequency, height = float(row["peak_hz"] or 0.0), float(row["height"] or 0.0)
            k = int(np.nanargmin(np.abs(function.values - height)))
            read = spectra.damping_of_response(
                pair.cross, pair.inputs, pair.row, frequency, result.band
            )
            peak = spectra.Peak(k, float(pair.cross.frequency[k]), frequency, height)
            yield function, ResonancePeak(peak, read)


def _of_peak(result: RunResult, of: _Spectrum, peak: ResonancePeak) -> Iterator[Budget]:
    """Yield frequency and height of a peak, natural frequency and damping of its mode."""
    at, k = peak.peak.frequency, peak.peak.index
    height = float(of.values[k])
    calibrated = calibration(result, height, of.powers)
    place, chance = _chance(result, of, peak)
    noise = unknown("noise", of.noise_origin)
    if of.noise is not None:
        noise = rectangular("noise", height * float(of.noise[k]), of.noise_origin)
    bins = rectangular("resolution", 0.5 * result.spectra.bin_width, "half a bin")
    name, width = f"{of.quantity} peak frequency", _resolution(result, of, peak)
    yield Budget(of.channel, name, at, at, "Hz", (bins, *place))
    lines = (calibrated, *width, *chance, noise)
    yield Budget(of.channel, f"{of.quantity} height", at, height, of.unit, lines)
    if peak.damping is not None:
        yield from of_mode(of.channel, of.quantity, at, peak.damping)


def _chance(
    result: RunResult, of: _Spectrum, peak: ResonancePeak
) -> tuple[list[Contribution], list[Contribution]]:
    r"""Return the contributions of chance to frequency and height of a peak.

    Of m bins that it does not tell apart, the peak may be any, and the tallest lies up to
    :math:`\varepsilon \sqrt{2 \ln m}` above the truth.
    """
    if of.no_chance:
        return [unknown("random", of.no_chance)], [unknown("random", of.no_chance)]
    cross, at, k = result.spectra, peak.peak.frequency, peak.peak.index
    first, last = tallest_bins(of.values, of.errors, k, 0.5 ** (1.0 / of.power))
    many = max(1.0, (last - first + 1) * cross.bin_width / cross.resolution)
    spread = float(of.values[k]) * float(of.errors[k])
    text = f"{numeral(many, 2)} bins that chance does not tell apart"
    reach = max(abs(float(cross.frequency[m]) - at) for m in (first, last))
    place = [rectangular("random", reach, text)] if last > first else []
    return place, [
        normal("random", spread, 1.0, "scatter of the averages"),
        rectangular(
            "random", spread * float(np.sqrt(2.0 * np.log(many))), f"tallest of {text}"
        ),
    ]


def _resolution(result: RunResult, of: _Spectrum, peak: ResonancePeak) -> list[Contribution]:
    r"""Return the contributions of window and bins to the height of a peak.

    A resonance is lower by what the window smears (`seen_share`), and up to half a bin beside
    its top, :math:`(\Delta f / B)^2` of its power. Where the bins do not resolve it, it is the
    distance from the fit, which allows for the window.
    """
    cross, read, k = result.spectra, peak.damping, peak.peak.index
    height = float(of.values[k])
    reading = spectra.half_power_ratio(cross.frequency, of.values**of.power, k)
    seen = 0.0 if reading is None else reading[1]
    if read is not None and read.height is not None and not peak.resolved:
        off = abs(read.height * of.factor - height)
        return [rectangular("resolution", off, "distance from the fit of the mode")]
    if not seen >= SEEN * cross.resolution:  # nor where a band without input cuts it
        return [unknown("resolution", NOT_RESOLVED)]
    true_width = spectra.resonance_width(seen, cross.resolution)
    low = 1.0 / spectra.smeared_height(cross, true_width) - 1.0
    bin_loss = (cross.bin_width / true_width) ** 2 / of.power
    return [
        bias("resolution", height * low, "smearing by the window"),
        rectangular("resolution", height * bin_loss, "half a bin beside the top"),
    ]


def budgets_of(recording: Recording, result: RunResult) -> Iterator[Budget]:
    """Yield the budget of every level, peak and damping of a run."""
    quiet = quiet_part(recording, result)
    yield from _levels(result, quiet)
    yield from peak_budgets(result, quiet)
    for reading in result.over_time.swept:
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
            ("rms", float(result.averages.statistics.rms[i]), moving),
            ("rms in band", float(result.averages.band_rms[i]), inside),
        ):
            if rms > 0.0:
                lines = _of_mean_square(result, quiet, (i,), rms**2, bins)
                head = Budget(channel.name, name, None, rms * factor, unit, tuple(lines))
                yield _level(result, head, {i: 1.0})
    level, rows = result.averages.measured_level, levels.watched(result.test, result.channels)
    if level is None or not level.value > 0.0:
        return
    value, unit = level.shown
    power = 2.0 if level.kind == "density" else 1.0
    square = float(np.mean(result.averages.band_rms[list(rows)] ** 2))
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
        density = result.averages.psd[list(rows)].mean(axis=0)[bins]
        duration = result.crop.n_samples / result.recorded.sample_rate
        spread = mean_square_error(density, cross.bin_width, duration, cross.effective_averages)
        source = f"random vibration over {numeral(duration, 4)} s"
        lines.append(normal("random", spread / square, 1.0, source))
    if quiet is None:
        return [*lines, unknown("noise", NOT_QUIET)]
    noise = float(quiet.density[list(rows)].mean(axis=0)[bins].sum()) * cross.bin_width
    return [*lines, rectangular("noise", noise / square, quiet.origin)]


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
    calibrated = calibration(result, gain, over_mean(i, result.controls))
    noise = unknown("noise", NOT_QUIET)
    if quiet is not None:
        share = _noise_of_sweep(result, reading, quiet)
        noise = rectangular("noise", gain * share, quiet.origin)
    yield Budget(channel, f"{name} gain", at, gain, unit or "1", (calibrated, height, noise))
    if mode is not None:
        yield damping(channel, name, at, mode.ratio, mode.ratio * mode.half)


def _noise_of_sweep(result: RunResult, reading: SweptReading, quiet: QuietPart) -> float:
    """Return the noise of response and controls over their amplitudes at a swept peak [-].

    It is all of the noise: what the tracking leaves of it is less.
    """
    near = [
        (abs(float(frequency) - reading.frequency), float(control))
        for sweep in result.over_time.tracking.sweeps
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


_TOLD: Final = (
    "Expanded is k = 2 times the root of the sum of squares of the standard uncertainties in "
    "the last columns, some 95 % (JCGM 100:2008).",
    "Calibration: the sheet's expanded uncertainty over 2, twice that for a density, that of "
    "both channels for a response function.",
    "Resolution: half a bin of a frequency; of a height what the window smears, which is not "
    "corrected, and half a bin beside the top.",
    "Random: scatter of the averages, which of the tallest bins is taken, and the 95 % "
    "interval of a fit over 1.96.",
    "Noise: the quiet part of the recording; of a response function, H2 less H1. Limits are "
    "rectangular laws, over the root of 3.",
    "Not included, for nothing states them: the recorder's clock, transverse sensitivity, "
    "temperature, mounting, and how far a second run differs.",
)


@final
class UncertaintyAnalysis(AbstractAnalysis):
    """Uncertainty of every reported number."""

    kind: ClassVar[str] = "uncertainty"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the budgets of a run; None where they are not asked for."""
        if not result.test.processing.uncertainty:
            return None
        budgets = tuple(budgets_of(recording, result))
        rows = [row for budget in budgets for row in _lines(budget)]
        return Analysis(
            kind=self.kind,
            title="Measurement uncertainty, k = 2",
            columns={name: [row[name] for row in rows] for name in (rows[0] if rows else ())},
            summary=tuple(_row(budget) for budget in budgets),
            panels=(),
            sentences=(*_TOLD, *_not_known(result, budgets)),
        )


def _row(budget: Budget) -> dict[str, Cell]:
    """Return a number with its expanded uncertainty, and its contributions."""
    known, expanded = budget.standard() is not None, budget.expanded
    row: dict[str, Cell] = {
        "channel": budget.channel,
        "quantity": budget.quantity,
        "peak_hz": budget.at,
        "value": budget.value,
        "expanded": None if budget.missing else expanded,
        "unit": budget.unit,
        "expanded_percent": None if budget.missing else budget.share(expanded),
        "at_least_percent": budget.share(expanded) if budget.missing and known else None,
        "not_known": ", ".join(budget.missing) or None,
    }
    shares = {f"{group}_percent": budget.share(budget.standard(group)) for group in GROUPS}
    return row | shares


def _lines(budget: Budget) -> Iterator[dict[str, Cell]]:
    """Yield the lines of a budget, their sum, and the expanded uncertainty."""
    head: dict[str, Cell] = {
        "channel": budget.channel, "quantity": budget.quantity, "peak_hz": budget.at,
        "value": budget.value, "unit": budget.unit,
    }  # fmt: skip
    for line in budget.lines:
        known = line.given is not None
        yield head | {
            "contribution": line.group,
            "given": line.given,
            "distribution": line.distribution if known else "not known",
            "divisor": line.divisor if known else None,
            "standard_uncertainty": line.standard,
            "standard_uncertainty_percent": budget.share(line.standard),
            "source": line.source,
        }
    of = (
        f"of what is known: {', '.join(budget.missing)} missing" if budget.missing else "of all"
    )
    for name, value in (
        ("combined", budget.standard()),
        (f"expanded (k = {COVERAGE:g})", budget.expanded),
    ):
        yield head | {
            "contribution": name,
            "given": None,
            "distribution": "normal",
            "divisor": None,
            "standard_uncertainty": value,
            "standard_uncertainty_percent": budget.share(value),
            "source": of,
        }


def _not_known(result: RunResult, budgets: Sequence[Budget]) -> Iterator[str]:
    """Yield each reason why a contribution is unknown, once, with the numbers concerned."""
    unknowns: dict[tuple[str, str], dict[str, None]] = {}
    for budget in budgets:
        for line in budget.lines:
            if line.given is None and line.group != "calibration":
                unknowns.setdefault((line.group, line.source), {})[budget.channel] = None
    if any(result.averages.psd_peaks) and not is_random(result):
        yield (
            "Peaks of densities have no budget: the run is no random vibration, and nothing "
            "tells their scatter."
        )
    bare = [channel.name for channel in result.channels if channel.uncertainty is None]
    if bare:
        unknowns = {("calibration", NO_SHEET): dict.fromkeys(bare)} | unknowns
    for (group, reason), names in unknowns.items():
        yield f"Not known and not taken as zero: {group} of {', '.join(names)}, {reason}."
