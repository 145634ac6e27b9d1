"""Vibration response and fatigue damage spectra of accelerations."""

from typing import ClassVar, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray, Recording
from shakerproc.runs.analyses import (
    AbstractAnalysis,
    accelerations,
    natural_frequencies,
    offset_free,
)
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.spectra.response_spectra import FatigueSpectra, fatigue_spectra


@final
class FatigueAnalysis(AbstractAnalysis):
    """Root mean squares and damage of oscillators under the vibration."""

    kind: ClassVar[str] = "fatigue"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the spectra of the accelerations of a run."""
        wanted = result.test.processing.fatigue
        if wanted is None:
            return None
        rows = accelerations(result, self.kind)
        frequency = natural_frequencies(
            result, (wanted.low, wanted.high), wanted.per_octave, self.kind
        )
        spectra = fatigue_spectra(
            offset_free(recording.select(rows), result, rows),
            result.recorded.sample_rate,
            frequency,
            damping=wanted.damping,
            exponent=wanted.exponent,
        )
        names = [result.channels[i].name for i in rows]
        how = f"damping {100.0 * wanted.damping:g} %, exponent {wanted.exponent:g}"
        unit = f"(m/s)^{wanted.exponent:g}"
        rms = spectra.acceleration / STANDARD_GRAVITY
        return Analysis(
            kind=self.kind,
            title=f"Vibration response and fatigue damage spectra ({how})",
            columns=_columns(spectra, names, wanted.exponent),
            summary=tuple(_row(spectra, i, name, unit) for i, name in enumerate(names)),
            panels=(
                _panel("response", "Vibration response spectrum, absolute acceleration",
                       "acceleration [g rms]", spectra.frequency, rms, names),
                _panel("damage", f"Fatigue damage spectrum of pseudo-velocity, {how}",
                       f"damage [{unit}]", spectra.frequency, spectra.damage, names),
            ),
        )  # fmt: skip


def _columns(
    spectra: FatigueSpectra, names: list[str], exponent: float
) -> dict[str, FloatArray]:
    columns = {"frequency_hz": spectra.frequency}
    for i, name in enumerate(names):
        columns[f"acceleration_rms_{name}_g"] = spectra.acceleration[i] / STANDARD_GRAVITY
        columns[f"displacement_rms_{name}_mm"] = spectra.displacement[i] * 1e3
        columns[f"damage_{name}_m_per_s_to_the_{exponent:g}"] = spectra.damage[i]
    return columns


def _row(spectra: FatigueSpectra, i: int, name: str, unit: str) -> dict[str, Cell]:
    """Return the largest values of a channel, and of which oscillators they are."""
    loudest, worst = int(np.argmax(spectra.acceleration[i])), int(np.argmax(spectra.damage[i]))
    return {
        "channel": name,
        "acceleration_rms_g": float(spectra.acceleration[i, loudest] / STANDARD_GRAVITY),
        "acceleration_at_hz": float(spectra.frequency[loudest]),
        "damage": float(spectra.damage[i, worst]),
        "damage_unit": unit,
        "damage_at_hz": float(spectra.frequency[worst]),
    }


def _panel(  # noqa: PLR0917
    name: str, title: str, label: str, frequency: FloatArray, values: FloatArray,
    channels: list[str],
) -> Panel:  # fmt: skip
    """Return one figure: values of every channel against natural frequency."""
    return Panel(
        name=f"fatigue_{name}",
        title=title,
        caption="Of an oscillator of each natural frequency on the place of the sensor.",
        x=PanelScale("natural frequency [Hz]"),
        y=PanelScale(label),
        lines=tuple(
            PanelLine(channel, frequency, values[i], channel=channel)
            for i, channel in enumerate(channels)
        ),
    )
