"""Figures of a record that is split: parts over time, densities, shock response spectra."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.numerals import numeral
from shakerproc.runs.analysis import Look, Panel, PanelLine, PanelScale
from shakerproc.spectra.splitting import Cells, RecordPart

MOST_DRAWN: Final = 8
"""Spectra in a figure at most."""

STEEP: Final = 1e-4
"""How far a line up goes aside, as a share of the time that is shown [-]."""

MOST_DECADES: Final = 6
"""Decades of the level over time at most."""

MOST_POINTS: Final = 1200
"""Points of a level over time at most, the largest of neighbouring cells each."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PartSpectrum:
    """The spectrum of one part.

    Attributes
    ----------
    number : int
        Of the part, from 1.
    kind : str
        Of the part.
    frequency : (n_frequencies,) array
        Of the spectrum [Hz].
    values : (n_channels, n_frequencies) array
        Maximax of a shock [m/s²], density of vibration [(m/s²)²/Hz].
    """

    number: int
    kind: str
    frequency: FloatArray
    values: FloatArray


def panels_of(
    cells: Cells,
    parts: Sequence[RecordPart],
    spectra: Sequence[PartSpectrum],
    names: Sequence[str],
    start: float,
) -> tuple[Panel, ...]:
    """Return the figures; `start` is when the run begins in the recording [s]."""
    shocks = [one for one in spectra if one.kind == "shock"]
    vibration = [one for one in spectra if one.kind != "shock"]
    loudest = int(np.argmax(cells.peak.max(axis=1)))
    steady = int(np.argmax(np.median(cells.mean_square, axis=1)))
    panels = [_over_time(cells, parts, names, start)]
    if vibration:
        panels.append(_vibration(vibration, names, steady))
    if shocks:
        panels.append(_shocks(shocks, names, loudest))
    return tuple(panels)


def _over_time(
    cells: Cells, parts: Sequence[RecordPart], names: Sequence[str], start: float
) -> Panel:
    """Return the rms of every channel over time, with shocks and changes of the level."""
    rms = np.sqrt(cells.mean_square) / STANDARD_GRAVITY
    firsts = np.arange(0, cells.count, -(-cells.count // MOST_POINTS))
    time = (start + firsts * cells.seconds).astype(np.float64)
    lines = [
        PanelLine(name, time, np.maximum.reduceat(rms[row], firsts), channel=name)
        for row, name in enumerate(names)
    ]
    peaks = cells.peak / STANDARD_GRAVITY
    ends, span = _decades(rms, peaks), cells.count * cells.seconds
    shocks = [part for part in parts if part.kind == "shock"]
    if shocks:
        heights = [float(peaks[:, p.first : p.stop].max()) for p in shocks]
        times = [start + p.first * cells.seconds for p in shocks]
        lines.append(_comb("shocks, to their peaks", times, heights, (ends[0], span), "abort"))
    times = [start + p.first * cells.seconds for p in parts if p.kind != "shock" and p.first]
    if times:
        tops = [float(peaks.max())] * len(times)
        lines.append(_comb("changes of the level", times, tops, (ends[0], span), "demand"))
    return Panel(
        "splitting_time",
        "Shocks and changes of the level over time",
        f"Rms in cells of {numeral(1e3 * cells.seconds)} ms, the largest where many share a "
        "point.",
        PanelScale("time [s]", logarithmic=False),
        PanelScale("acceleration [g]", ends=ends),
        tuple(lines),
    )


def _decades(rms: FloatArray, peaks: FloatArray) -> tuple[float, float]:
    """Return the decades that hold the levels and the peaks [g]."""
    shown, high = rms[rms > 0.0], float(peaks.max())
    if not shown.size:
        return 0.1, 1.0
    low, top = np.floor(np.log10(shown.min())), np.ceil(np.log10(high))
    return float(10.0 ** max(low, top - MOST_DECADES)), float(10.0 ** max(top, low + 1.0))


def _comb(
    label: str,
    times: Sequence[float],
    heights: Sequence[float],
    floor_and_span: tuple[float, float],
    look: Look,
) -> PanelLine:
    """Return a line that goes up to each height and down again, below the axis between them.

    `floor_and_span` are the low end of the axis and the time that is shown [s].
    """
    floor, span = floor_and_span
    values = np.array([[0.1 * floor, height, 0.1 * floor] for height in heights])
    aside = STEEP * span * np.arange(3.0)  # not upright: the page draws functions of time
    return PanelLine(
        label, (np.array(times)[:, np.newaxis] + aside).ravel(), values.ravel(), look=look
    )


def _vibration(spectra: Sequence[PartSpectrum], names: Sequence[str], row: int) -> Panel:
    longest = spectra[:MOST_DRAWN]
    return Panel(
        "splitting_densities",
        f"Density of {names[row]} in parts of vibration",
        "Without the shocks in them." + _more(spectra),
        PanelScale("frequency [Hz]"),
        PanelScale("density [g²/Hz]"),
        tuple(
            PanelLine(f"part {one.number}, {one.kind}", one.frequency[1:],
                 one.values[row, 1:] / STANDARD_GRAVITY**2, style=i)
            for i, one in enumerate(longest)
        ),
    )  # fmt: skip


def _shocks(spectra: Sequence[PartSpectrum], names: Sequence[str], row: int) -> Panel:
    frequency = spectra[0].frequency
    values = np.array([one.values[row] for one in spectra]) / STANDARD_GRAVITY
    order = np.argsort(-values.max(axis=1), kind="stable")[:MOST_DRAWN]
    lines = [
        PanelLine(f"part {spectra[k].number}", frequency, values[k], style=i)
        for i, k in enumerate(sorted(order))
    ]
    lines.append(PanelLine("all shocks", frequency, values.max(axis=0), look="demand"))
    return Panel(
        "splitting_shocks",
        f"Shock response of {names[row]}, maximax of the absolute acceleration",
        "Dashed: the highest of all shocks." + _more(spectra),
        PanelScale("natural frequency [Hz]"),
        PanelScale("acceleration [g]"),
        tuple(lines),
    )


def _more(spectra: Sequence[PartSpectrum]) -> str:
    if len(spectra) <= MOST_DRAWN:
        return ""
    return f" {MOST_DRAWN} of {len(spectra)} are drawn; the table has them all."
