"""A long steady sine: frequency of the control, gain and phase of every response over time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_ratio, shown_unit
from shakerproc.runs.tables import spelled, spelled_ratio
from shakerproc.spectra import Tone

MOST: Final = 300
"""Stretches of a run where the log does not say how long they are [-]."""

PERIODS: Final = 20.0
"""Periods that a stretch holds at least where the log does not say how long it is [-]."""

FEWEST: Final = 2
"""Stretches below which nothing is said over time [-]."""

ENDS: Final = 10
"""One over the share of the stretches at each end whose medians the drift lies between [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Dwell:
    """A sine over time: `gain` [-] and `phase` [deg] are (n_responses, n_stretches)."""

    time: FloatArray  # middle of each stretch, from the start of the recording [s]
    frequency: FloatArray  # [Hz]
    control: FloatArray  # amplitude, in SI
    gain: FloatArray
    phase: FloatArray


@final
class DwellAnalysis(AbstractAnalysis):
    """Gain, phase and frequency in stretches of equal length."""

    kind: ClassVar[str] = "dwell"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the dwell of a run, None where the log does not ask for it.

        Raises
        ------
        SpectrumError
            If the run is no sine, holds too few stretches, or has no control.
        """
        asked, frequency = result.test.processing.dwell, result.test.frequency_hz
        if asked is None:
            return None
        if result.test.excitation != "sine" or frequency is None or not result.controls:
            raise SpectrumError(
                "dwell: expected a test with excitation: sine and a channel with the role "
                f"control, got {result.test.excitation or 'no excitation'}; take dwell out"
            )
        n_samples = _stretch(result, frequency, asked.every)
        tones = _tones(recording, result, frequency, n_samples)
        known = [tone for tone in tones if tone is not None]
        if len(known) < FEWEST:
            raise SpectrumError(
                f"dwell: the control is a sine near {frequency:g} Hz in {len(known)} of "
                f"{len(tones)} stretches; correct frequency or crop"
            )
        dwell = _dwell(result, tones, n_samples)
        lost = len(tones) - len(known)
        return Analysis(
            kind=self.kind,
            title="Dwell",
            columns=_columns(result, dwell),
            summary=tuple(_row(result, k, dwell) for k in range(len(result.responses))),
            panels=tuple(_panels(result, dwell)),
            sentences=(
                f"Read in stretches of {numeral(n_samples / result.recorded.sample_rate)} s; "
                "drift is from the first tenth of them to the last.",
                *(
                    [f"In {lost} of {len(tones)} stretches the control is no sine."]
                    * bool(lost)
                ),
            ),
        )


def _stretch(result: RunResult, frequency: float, every: float | None) -> int:
    """Return how many samples a stretch has.

    Raises
    ------
    SpectrumError
        If the run holds fewer than `FEWEST` of them.
    """
    n_samples, rate = result.crop.n_samples, result.recorded.sample_rate
    wanted = max(n_samples / MOST, PERIODS * rate / frequency)
    stretch = int(np.ceil(wanted if every is None else every * rate))
    if n_samples < FEWEST * stretch:
        raise SpectrumError(
            f"dwell: the run of {numeral(n_samples / rate, 4)} s does not hold {FEWEST} "
            f"stretches of {numeral(stretch / rate, 4)} s; give a shorter every"
        )
    return stretch


def _tones(
    recording: Recording, result: RunResult, frequency: float, n_samples: int
) -> list[Tone | None]:
    """Return the tone of each stretch, looked for where it was last; None where none is."""
    tones: list[Tone | None] = []
    for start in range(result.crop.start, result.crop.stop - n_samples + 1, n_samples):
        samples = recording.samples(start, start + n_samples)
        try:
            tone = spectra.tone_response(
                samples,
                result.recorded.sample_rate,
                result.controls,
                frequency=frequency,
                start=start,
            )
        except SpectrumError:
            tones.append(None)
        else:
            tones.append(tone)
            frequency = tone.frequency
    return tones


def _dwell(result: RunResult, tones: Sequence[Tone | None], n_samples: int) -> _Dwell:
    """Return the tones over time, not a number where there is none, phases unwrapped."""
    number = np.arange(len(tones))
    gain = np.full((len(result.responses), number.size), np.nan, dtype=np.complex128)
    frequency, control = np.full((2, number.size), np.nan)
    for k, tone in enumerate(tones):
        if tone is not None:
            gain[:, k] = tone.gain[list(result.responses)]
            frequency[k], control[k] = tone.frequency, tone.control
    known = np.isfinite(frequency)
    phase = np.full(gain.shape, np.nan)
    phase[:, known] = np.degrees(np.unwrap(np.angle(gain[:, known])))
    middle = result.crop.start + (number + 0.5) * n_samples
    time: FloatArray = np.asarray(middle / result.recorded.sample_rate)
    return _Dwell(time, frequency, control, np.abs(gain), phase)


def _columns(result: RunResult, dwell: _Dwell) -> dict[str, FloatArray]:
    unit, factor = shown_unit(result.channels[result.controls[0]].unit)
    columns = {
        "time_s": dwell.time,
        "frequency_hz": dwell.frequency,
        f"control{spelled(unit)}": dwell.control * factor,
    }
    for k, i in enumerate(result.responses):
        units, name = result.units_of_response(i), result.channels[i].name
        columns[f"gain_{name}{spelled_ratio(*units)}"] = dwell.gain[k] * shown_ratio(*units)[1]
        columns[f"phase_{name}_deg"] = dwell.phase[k]
    return columns


def _ends(values: FloatArray) -> tuple[float, float]:
    """Return the medians of the first and the last tenth of the values that there are."""
    there = values[np.isfinite(values)]
    count = max(1, there.size // ENDS)
    return float(np.median(there[:count])), float(np.median(there[-count:]))


def _row(result: RunResult, k: int, dwell: _Dwell) -> dict[str, Cell]:
    """Return where gain and phase of a response began and ended."""
    i = result.responses[k]
    unit, factor = shown_ratio(*result.units_of_response(i))
    gain, phase, hertz = (_ends(v) for v in (dwell.gain[k], dwell.phase[k], dwell.frequency))
    return {
        "channel": result.channels[i].name,
        "unit": unit or "1",
        "gain_first": gain[0] * factor,
        "gain_last": gain[1] * factor,
        "gain_drift_percent": 100.0 * (gain[1] / gain[0] - 1.0) if gain[0] > 0.0 else None,
        "phase_first_deg": phase[0],
        "phase_last_deg": phase[1],
        "phase_drift_deg": phase[1] - phase[0],
        "frequency_first_hz": hertz[0],
        "frequency_last_hz": hertz[1],
    }


def _panels(result: RunResult, dwell: _Dwell) -> list[Panel]:
    """Return gain, for each unit, phase and frequency over time."""
    time = PanelScale("time [s]", logarithmic=False)
    ratios = [shown_ratio(*result.units_of_response(i)) for i in result.responses]
    names = [result.channels[i].name for i in result.responses]
    panels = []
    for number, unit in enumerate(dict.fromkeys(unit for unit, _ in ratios), 1):
        lines = tuple(
            PanelLine(name, dwell.time, gain * ratio[1], channel=name)
            for name, gain, ratio in zip(names, dwell.gain, ratios, strict=True)
            if ratio[0] == unit
        )
        panels.append(
            Panel(f"dwell_gain_{number}", "Gain over time", "Response over the control at its "
                  "frequency: a line that falls or rises tells a change.", time,
                  PanelScale(f"gain [{unit or '-'}]", logarithmic=False), lines)
        )  # fmt: skip
    phases = tuple(
        PanelLine(name, dwell.time, phase, channel=name)
        for name, phase in zip(names, dwell.phase, strict=True)
    )
    panels.append(
        Panel("dwell_phase", "Phase over time", "Response against the control: at a resonance "
              "that drifts, the phase moves before the gain does.", time,
              PanelScale("phase [deg]", logarithmic=False), phases)
    )  # fmt: skip
    panels.append(
        Panel("dwell_frequency", "Frequency over time", "Of the control, as its controller "
              "holds or tracks it.", time, PanelScale("frequency [Hz]", logarithmic=False),
              (PanelLine("control", dwell.time, dwell.frequency),))
    )  # fmt: skip
    return panels
