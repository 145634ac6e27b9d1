"""Octave and fractional-octave bands of every channel."""

from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.runs.analyses import AbstractAnalysis, offset_free
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.spectra.octaves import (
    HIGHEST,
    OctaveBands,
    octave_bands,
    rms_of_density,
    rms_through_filters,
)

_NAMES: Final = {1: "Octave", 3: "Third-octave"}


@final
class OctaveAnalysis(AbstractAnalysis):
    """Root mean squares in bands of an octave or a part of it."""

    kind: ClassVar[str] = "octaves"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the bands of every channel of a run."""
        wanted = result.test.processing.octaves
        if wanted is None:
            return None
        bands = _bands(result, wanted.fraction, wanted.low, wanted.high)
        rows = list(range(len(result.channels)))
        filtered = rms_through_filters(
            offset_free(recording, result, rows), result.recorded.sample_rate, bands
        )
        density = rms_of_density(result.spectra, bands)
        units = [shown_unit(c.unit) for c in result.channels]
        factors = np.array([factor for _, factor in units])[:, np.newaxis]
        filtered, density = filtered * factors, density * factors
        name = {1: "Octave", 3: "Third-octave"}.get(
            wanted.fraction, f"1/{wanted.fraction} octave"
        )
        return Analysis(
            kind=self.kind,
            title=f"{name} bands (IEC 61260-1)",
            columns=_columns(result, bands, filtered, density),
            summary=tuple(_row(result, i, bands, filtered[i]) for i in rows),
            panels=tuple(
                _panel(result, unit, bands, filtered, name)
                for unit in dict.fromkeys(unit for unit, _ in units)
            ),
        )


def _bands(
    result: RunResult, fraction: int, low: float | None, high: float | None
) -> OctaveBands:
    """Return the bands that the log asks for; by default those within the excited band.

    Raises
    ------
    SpectrumError
        If one reaches beyond what the sample rate allows, or there is none.
    """
    most = HIGHEST * result.recorded.sample_rate
    bands = octave_bands(
        fraction,
        result.band[0] if low is None else low,
        result.band[1] if high is None else high,
    )
    if high is None:
        kept = bands.upper <= most
        bands = OctaveBands(
            fraction,
            *(row[kept] for row in (bands.nominal, bands.middle, bands.lower, bands.upper)),
        )
    if bands.upper.size and bands.upper[-1] > most:
        raise SpectrumError(
            f"octaves: the band at {bands.nominal[-1]:g} Hz reaches {bands.upper[-1]:.5g} Hz, "
            f"beyond {most:.5g} Hz, {HIGHEST:g} of the sample rate; give a lower to"
        )
    if not bands.middle.size:
        raise SpectrumError("octaves: no band lies between from and to; give them wider apart")
    return bands


def _columns(
    result: RunResult, bands: OctaveBands, filtered: FloatArray, density: FloatArray
) -> dict[str, FloatArray]:
    columns = {
        "nominal_hz": bands.nominal,
        "middle_hz": bands.middle,
        "lower_hz": bands.lower,
        "upper_hz": bands.upper,
    }
    for i, channel in enumerate(result.channels):
        ending = f"{channel.name}{spelled(shown_unit(channel.unit)[0])}"
        columns[f"rms_{ending}"] = filtered[i]
        columns[f"rms_from_psd_{ending}"] = density[i]
    return columns


def _row(result: RunResult, i: int, bands: OctaveBands, rms: FloatArray) -> dict[str, Cell]:
    loudest = int(np.argmax(rms))
    return {
        "channel": result.channels[i].name,
        "unit": shown_unit(result.channels[i].unit)[0],
        "rms": float(np.sqrt(np.sum(rms**2))),
        "loudest_band_hz": float(bands.nominal[loudest]),
        "rms_there": float(rms[loudest]),
    }


def _panel(
    result: RunResult, unit: str, bands: OctaveBands, rms: FloatArray, name: str
) -> Panel:
    """Return the bands of the channels of one unit, each value across its band."""
    x = np.column_stack([bands.lower, bands.upper]).ravel()
    rows = [i for i, c in enumerate(result.channels) if shown_unit(c.unit)[0] == unit]
    ending = spelled(unit) if unit != "g" else ""
    return Panel(
        name=f"octaves{ending}",
        title=f"{name} bands",
        caption="Root mean square of what passes the filter of each band.",
        x=PanelScale("frequency [Hz]"),
        y=PanelScale(f"rms [{unit}]"),
        lines=tuple(
            PanelLine(
                result.channels[i].name,
                x,
                np.repeat(rms[i], 2),
                channel=result.channels[i].name,
            )
            for i in rows
        ),
    )
