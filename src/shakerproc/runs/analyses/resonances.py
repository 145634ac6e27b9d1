"""Resonances of the response functions over a force: natural frequency and damping of each."""

from collections.abc import Iterator
from typing import ClassVar, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.pairs import ChannelPair, functions_of
from shakerproc.runs.panels import Analysis, Cell
from shakerproc.runs.result import RunResult
from shakerproc.spectra import Damping


@final
class ResonanceAnalysis(AbstractAnalysis):
    """Every peak of |H1| over a force that chance does not make, with its damping.

    Where nothing tells what chance makes, only the tallest peak is taken, or as many as
    ``peaks: {count: ...}`` says.
    """

    kind: ClassVar[str] = "resonances"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the resonances of a run that forces drive."""
        del recording  # its spectra are those of the result
        pairs = [pair for pair in functions_of(result) if _is_driven(result, pair)]
        if not pairs:
            return None
        rows = tuple(row for pair in pairs for row in _rows(result, pair))
        return Analysis(
            kind=self.kind,
            title="Resonances of the response functions",
            columns={name: [row[name] for row in rows] for name in (rows[0] if rows else ())},
            summary=rows,
            panels=(),
            sentences=()
            if rows
            else ("No response function has a peak that chance does not make.",),
        )


def _is_driven(result: RunResult, pair: ChannelPair) -> bool:
    """Return whether the input is a force, so that peaks are resonances of the structure."""
    return all(result.channels[i].role == "force" for i in pair.inputs)


def _rows(result: RunResult, pair: ChannelPair) -> Iterator[dict[str, Cell]]:
    cross, wanted = pair.cross, result.test.processing.peaks
    gain = spectra.masked(np.abs(pair.h1), pair.excited)
    errors = _errors(result, pair)
    peaks = spectra.find_peaks(
        cross.frequency,
        gain,
        result.band,
        distance=wanted.distance,
        count=wanted.count or (1 if errors is None else None),
        errors=errors,
    )
    for peak in sorted(peaks, key=lambda one: one.frequency):
        read = spectra.damping_of_response(
            cross, pair.inputs, pair.row, peak.frequency, result.band
        )
        yield {
            "function": pair.label,
            "peak_hz": peak.frequency,
            "height": peak.value,
            "unit": pair.unit,
            "coherence": float(pair.coherence[peak.index]),
            **_of_mode(read),
            "added_by_window_percent": 100.0
            * cross.added_damping(read.frequency or peak.frequency),
            "withheld": read.reason or "",
        }


def _errors(result: RunResult, pair: ChannelPair) -> FloatArray | None:
    """Return the random error of each gain [-]; None where nothing tells it.

    One average has no coherence; of one blow it is that of noise as before the blow, white,
    where enough samples lie there to know it.
    """
    cross, blows = pair.cross, result.over_time.blows
    if cross.effective_averages <= 1.0:
        if blows is None or np.isnan(blows.noise).any():
            return None
        chosen = [*pair.inputs, pair.row]
        noise = blows.noise_density[chosen, np.newaxis]
        shares = np.full((len(chosen), cross.frequency.size), np.inf)
        np.divide(
            noise,
            result.averages.psd[chosen],
            out=shares,
            where=result.averages.psd[chosen] > 0.0,
        )
        return np.asarray(np.sqrt(0.5 * shares.sum(axis=0)))
    return spectra.gain_random_error(
        np.clip(pair.coherence, 0.0, 1.0), cross.effective_averages
    )


def _of_mode(read: Damping) -> dict[str, Cell]:
    low, high = read.ratio_low, read.ratio_high
    return {
        "natural_frequency_hz": read.frequency,
        "damping_percent": None if read.ratio is None else 100.0 * read.ratio,
        "low_percent": None if low is None else 100.0 * low,
        "high_percent": None if high is None else 100.0 * high,
    }
