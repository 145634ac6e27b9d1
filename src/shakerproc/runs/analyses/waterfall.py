"""Waterfall: spectra one after the other, over time or over the speed of a tachometer."""

from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.spectra.welch.spectrograms import spectrogram
from shakerproc.spectra.welch.windows import window_samples

MOST_POINTS: Final = 240
"""Points of one spectrum in the figure, the largest of neighbouring bins each [-]."""

TALLEST: Final = 4.0
"""Height of the largest amplitude, over the mean distance between spectra [-]."""

WINDOW: Final = "periodic hann"


@final
class WaterfallAnalysis(AbstractAnalysis):
    """Amplitude spectra of every channel in stretches of equal time."""

    kind: ClassVar[str] = "waterfall"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the waterfall of a run, over speed where its orders are asked for too.

        Raises
        ------
        SpectrumError
            If the band lies between two lines.
        """
        wanted = result.test.processing.waterfall
        if wanted is None:
            return None
        orders = result.test.processing.orders
        tachometer = None if orders is None else orders.tachometer
        crop, segment = result.crop, result.spectra.segment
        surface = spectrogram(
            lambda start, stop: recording.samples(crop.start + start, crop.start + stop),
            result.recorded.sample_rate, n_samples=crop.n_samples, segment=segment,
            window=WINDOW, most_times=wanted.spectra,
        )  # fmt: skip
        inside = (surface.frequency >= result.band[0]) & (surface.frequency <= result.band[1])
        if not inside.any():
            low, high = result.band
            raise SpectrumError(
                f"the band from {numeral(low, 4)} to {numeral(high, 4)} Hz holds no line of "
                f"the waterfall, whose lines are {numeral(surface.frequency[1], 4)} Hz apart. "
                "Set welch.segment to "
                f"{int(np.ceil(result.recorded.sample_rate / (high - low)))} samples or more."
            )
        amplitude = _amplitudes(
            surface.density[:, inside], result.recorded.sample_rate, segment
        )
        frequency, speed = surface.frequency[inside], _speeds(result, surface.time)
        time = surface.time + crop.start / result.recorded.sample_rate
        columns = {
            "time_s": np.repeat(time, frequency.size),
            "frequency_hz": np.tile(frequency, time.size),
        }
        if speed is not None:
            columns["speed_rev_per_min"] = np.repeat(speed, frequency.size)
        for channel, values in zip(result.channels, amplitude, strict=True):
            unit, factor = shown_unit(channel.unit)
            columns[f"amplitude_{channel.name}{spelled(unit)}"] = values.T.ravel() * factor
        return Analysis(
            kind=self.kind,
            title="Waterfall",
            columns=columns,
            summary=tuple(
                _row(result, i, frequency, time, values) for i, values in enumerate(amplitude)
            ),
            panels=tuple(
                _panel(result, i, frequency, (time, speed), values)
                for i, values in enumerate(amplitude)
                if tachometer not in {result.channels[i].name, result.channels[i].source_name}
            ),
        )


def _amplitudes(density: FloatArray, sample_rate: float, segment: int) -> FloatArray:
    """Return the amplitude of a sine that has such a density in the middle of its bin."""
    weights = window_samples(WINDOW, segment)
    bandwidth = sample_rate * float(weights @ weights) / float(weights.sum()) ** 2
    return np.sqrt(2.0 * bandwidth * density)


def _speeds(result: RunResult, time: FloatArray) -> FloatArray | None:
    """Return the mean speed around each spectrum [rev/min]; not a number without pulses."""
    shaft = result.over_time.shaft
    if shaft is None:
        return None
    half = 0.5 * result.spectra.segment / result.recorded.sample_rate
    early = np.clip(time - half, shaft.pulses.times[0], shaft.pulses.times[-1])
    late = np.clip(time + half, shaft.pulses.times[0], shaft.pulses.times[-1])
    seen = late > early
    width = np.where(seen, late - early, 1.0)
    return np.where(seen, 60.0 * (shaft.angle(late) - shaft.angle(early)) / width, np.nan)


def _row(
    result: RunResult, i: int, frequency: FloatArray, time: FloatArray, values: FloatArray
) -> dict[str, Cell]:
    """Return the largest amplitude of a channel, and where and when it is that large."""
    unit, factor = shown_unit(result.channels[i].unit)
    line, column = np.unravel_index(int(np.argmax(values)), values.shape)
    return {
        "channel": result.channels[i].name,
        "largest": float(values[line, column]) * factor,
        "unit": unit,
        "at_hz": float(frequency[line]),
        "time_s": float(time[column]),
    }


def _panel(
    result: RunResult,
    i: int,
    frequency: FloatArray,
    places: tuple[FloatArray, FloatArray | None],
    values: FloatArray,
) -> Panel:
    """Return spectra that rise from their time or speed."""
    time, speed = places
    place, label = (time, "time [s]") if speed is None else (speed, "speed [rev/min]")
    channel = result.channels[i]
    unit, factor = shown_unit(channel.unit)
    known, largest = place[np.isfinite(place)], float(values.max())
    span = float(known.max() - known.min()) if known.size else 0.0
    tall = TALLEST * (span or 1.0) / max(known.size - 1, 1)
    starts = np.arange(0, frequency.size, -(-frequency.size // MOST_POINTS))
    shown = np.maximum.reduceat(values, starts, axis=0) / (largest or 1.0) * tall
    return Panel(
        f"waterfall_{i + 1}", f"Waterfall of {channel.name}",
        f"Amplitude spectra rise from their {label.split(' ', maxsplit=1)[0]}; the highest is "
        f"{numeral(largest * factor)} {unit}.",
        PanelScale("frequency [Hz]", logarithmic=False), PanelScale(label, logarithmic=False),
        tuple(
            PanelLine("", frequency[starts], at + shown[:, k])  # all solid, of one colour
            for k, at in enumerate(place)
            if np.isfinite(at)
        ),
    )  # fmt: skip
