"""Response functions and resolved peaks of a run, each with its damping."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray
from shakerproc.runs.averaging import FinerSpectra
from shakerproc.runs.result import (
    BoolArray,
    ResonancePeak,
    Responses,
)
from shakerproc.spectra import CrossSpectra, Damping, Peak, SpectralLine
from shakerproc.spectra.responses import estimators
from shakerproc.testlog import Test

SINGLE_FREQUENCY: Final = ("sine",)
"""Kinds of excitation that reach one frequency only."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Where peaks are looked for; `finer` gives spectra of longer segments, if any."""

    spectra: CrossSpectra
    test: Test
    band: tuple[float, float]
    finer: FinerSpectra | None
    lines: tuple[SpectralLine, ...]  # tones of the control, which are no resonances

    @property
    def one_frequency(self) -> bool:
        """Whether the table moves at one frequency at a time, and bands mean nothing."""
        return self.test.excitation in SINGLE_FREQUENCY

    def valid(self, control: FloatArray) -> BoolArray:
        """Return which frequencies are excited, given the density of the mean control.

        `control` is a density [unit²/Hz].
        """
        frequency = self.spectra.frequency
        there = estimators.driven(frequency, control, self.judged)
        return there if there.any() else estimators.excited(frequency, self.judged)

    @property
    def judged(self) -> tuple[float, float]:
        """Where controls and responses can be compared [Hz]: the band, or near the tone."""
        if self.one_frequency and self.test.frequency_hz is not None:
            reach = estimators.NOTCH_BINS * self.spectra.bin_width
            return max(0.0, self.test.frequency_hz - reach), self.test.frequency_hz + reach
        return self.band

    def peaks(self, values: FloatArray, errors: FloatArray | None) -> tuple[Peak, ...]:
        """Return the peaks of a spectrum that chance does not make, tallest first.

        `values` are in any unit, `errors` shares of them [-].
        """
        wanted = self.test.processing.peaks
        return spectra.find_peaks(
            self.spectra.frequency,
            values,
            self.band,
            distance=wanted.distance,
            count=wanted.count if errors is not None else 1,
            errors=errors,
        )


def against_controls(
    search: Search, controls: Sequence[int], responses: Sequence[int]
) -> Responses | None:
    """Return the response functions against the controls; None where one side is missing."""
    if not controls or not responses:
        return None
    cross = search.spectra
    density = spectra.psd(cross)[list(controls)].mean(axis=0)
    there = estimators.audible(cross.frequency, density, search.judged)
    return Responses(
        h1=np.where(there, spectra.h1(cross, controls, responses), np.nan),
        h2=np.where(there, spectra.h2(cross, controls, responses), np.nan),
        hv=np.where(there, spectra.hv(cross, controls, responses), np.nan),
        psd_ratio=np.where(there, spectra.psd_ratio(cross, controls, responses), np.nan),
        coherence=averaged_share(cross, spectra.coherence(cross, controls, responses)),
        multiple_coherence=averaged_share(
            cross, spectra.multiple_coherence(cross, controls, responses)
        ),
        valid=search.valid(density),
    )


def averaged_share(cross: CrossSpectra, coherence: FloatArray) -> FloatArray:
    """Return a coherence [-]; of one average, whose quotient is always 1, not a number."""
    return coherence if cross.effective_averages > 1.0 else np.full_like(coherence, np.nan)


def density_peaks(
    search: Search, density: FloatArray, against: Responses | None, responses: Sequence[int]
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of the density of every channel; damping only without an input.

    `density` is in the units of the channels, squared, over [Hz].
    """
    row_of = {channel: row for row, channel in enumerate(responses)} if against else {}
    found = []
    for i, values in enumerate(density):
        coherence = against.coherence[row_of[i]] if against and i in row_of else None
        elsewhere = against is not None or search.one_frequency
        read = None if elsewhere else _reader_of_density(search, i)
        averages = search.spectra.effective_averages
        chance = np.full(values.shape, averages**-0.5) if averages > 1.0 else None
        if search.lines and i in responses:
            left = spectra.clear_of_lines(search.spectra, search.lines, i)
            peaks = search.peaks(spectra.masked(values, left), chance)
        else:
            peaks = search.peaks(values, chance) or search.peaks(values, None)
        found.append(_read(search, values, peaks, coherence, read))
    return tuple(found)


def response_peaks(
    search: Search,
    against: Responses | None,
    controls: Sequence[int],
    responses: Sequence[int],
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of |H1| of every response, none for the controls."""
    found: list[tuple[ResonancePeak, ...]] = [()] * (len(controls) + len(responses))
    if against is not None and not search.one_frequency:
        for row, channel in enumerate(responses):
            apart = spectra.clear_of_lines(search.spectra, search.lines, channel)
            gain = spectra.masked(np.abs(against.h1[row]), against.valid & apart)
            chance = spectra.gain_random_error(
                np.clip(against.coherence[row], 0.0, 1.0), search.spectra.effective_averages
            )
            known = chance if np.isfinite(chance).any() else None
            read = None if known is None else _reader_of_response(search, controls, channel)
            peaks = search.peaks(gain, known)
            found[channel] = _read(search, gain**2, peaks, against.coherence[row], read)
    return tuple(found)


Reader: TypeAlias = Callable[[float], Damping]


def _reader_of_density(search: Search, channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_density(
            cross, channel, frequency, search.band
        ),
    )


def _reader_of_response(search: Search, controls: Sequence[int], channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_response(
            cross, controls, channel, frequency, search.band
        ),
    )


def _resolved(search: Search, read: Callable[[CrossSpectra, float], Damping]) -> Reader:
    """Return a reader of damping that looks again with longer segments where they may help."""

    def reader(frequency: float) -> Damping:
        first, finer = read(search.spectra, frequency), search.finer
        if finer is None or not spectra.longer_may_resolve(
            search.spectra, first, finer.bin_width
        ):
            return first
        second = read(finer.make(), frequency)
        return first if second.ratio is None else second

    return reader


def _read(
    search: Search,
    power: FloatArray,
    peaks: Sequence[Peak],
    coherence: FloatArray | None,
    read: Reader | None,
) -> tuple[ResonancePeak, ...]:
    """Return peaks with the coherence there and their damping."""
    return tuple(
        ResonancePeak(
            peak,
            None if read is None else read(peak.frequency),
            None if coherence is None else float(coherence[peak.index]),
            spectra.is_resolved(search.spectra, power, peak.index),
        )
        for peak in peaks
    )
