"""A long record in shocks and parts of vibration: when, how high, and the spectra of each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis, accelerations, natural_frequencies
from shakerproc.runs.panels import Analysis, Cell, Look, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.spectra.response_spectra import shock_spectra
from shakerproc.spectra.splitting import CELL, Cells, RecordPart, ShockRule, cells_of, split
from shakerproc.spectra.welch.cross import psd
from shakerproc.spectra.welch.engine import cross_spectra
from shakerproc.testlog.processing import Shock, Splitting

MOST_DRAWN: Final = 8
"""Spectra in a figure at most."""

STEEP: Final = 1e-4
"""How far a line up goes aside, as a share of the time that is shown [-]."""

MOST_DECADES: Final = 6
"""Decades of the level over time at most."""

MOST_POINTS: Final = 1200
"""Points of a level over time at most, the largest of neighbouring cells each."""

LEAST_CELL: Final = 8
"""Samples of a cell at least."""

MOST_SPECTRA: Final = 50
"""Shocks whose spectra are computed, the highest ones, and parts of vibration, the longest."""


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
        panels.append(_vibration_panel(vibration, names, steady))
    if shocks:
        panels.append(_shock_panel(shocks, names, loudest))
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


def _vibration_panel(spectra: Sequence[PartSpectrum], names: Sequence[str], row: int) -> Panel:
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


def _shock_panel(spectra: Sequence[PartSpectrum], names: Sequence[str], row: int) -> Panel:
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


@final
class SplittingAnalysis(AbstractAnalysis):
    """Shocks and stationary parts, each with its spectrum."""

    kind: ClassVar[str] = "splitting"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the parts of a run.

        Raises
        ------
        SpectrumError
            If the run is shorter than a stationary part, or nothing is an acceleration.
        """
        wanted = result.test.processing.splitting
        if wanted is None:
            return None
        rows = accelerations(result, self.kind)
        run = _LevelRun(recording.select(rows), result, rows)
        cells = run.cells(wanted)
        rule = ShockRule(wanted.crest, wanted.least, wanted.longest)
        parts = split(cells, rule, shortest=wanted.shortest, step=wanted.step)
        spectra = [*_shocks(run, cells, parts, wanted), *_vibration(run, cells, parts)]
        table = [_row(run, cells, parts, i) for i in range(len(parts))]
        shocks = sum(part.kind == "shock" for part in parts)
        return Analysis(
            kind=self.kind,
            title=f"Shocks and vibration: {shocks} of {len(parts)} parts are shocks",
            columns=_columns(spectra, run.names),
            summary=tuple(table),
            panels=panels_of(cells, parts, spectra, run.names, run.start),
            sentences=tuple(_advice(parts, spectra)),
        )


@final
class _LevelRun:
    """The accelerations of a run without their means.

    Attributes
    ----------
    names : list of str
        Names of the channels.
    start : float
        Beginning of the run in the recording [s].
    """

    def __init__(self, recording: Recording, result: RunResult, rows: Sequence[int]) -> None:
        self.recording, self.result = recording, result
        self.names = [result.channels[i].name for i in rows]
        self.mean = result.averages.statistics.mean[list(rows), np.newaxis]
        self.start = result.crop.start / result.recorded.sample_rate

    def cells(self, wanted: Splitting) -> Cells:
        """Return the cells of the run.

        Raises
        ------
        SpectrumError
            If it is shorter than a stationary part.
        """
        rate, samples = self.result.recorded.sample_rate, self.result.crop.n_samples
        length = max(LEAST_CELL, round(CELL * rate))
        if samples < max(length, wanted.shortest * rate):
            raise SpectrumError(
                f"splitting: the run lasts {numeral(samples / rate, 4)} s, and a stationary "
                f"part at least {wanted.shortest:g} s. Give splitting: {{shortest: ...}} less "
                "than the run, or take splitting: out of processing"
            )
        return cells_of(self.blocks(0, samples), rate, length)

    def blocks(self, start: int, stop: int) -> Iterator[FloatArray]:
        """Yield samples of the run, counted from its beginning."""
        begin = self.result.crop.start
        for block in self.recording.blocks(begin + start, begin + stop):
            yield block - self.mean

    def samples_of(self, part: RecordPart, length: int) -> tuple[int, int]:
        """Return the first sample of a part and the one after the last."""
        return part.first * length, min(part.stop * length, self.result.crop.n_samples)


def _calm(parts: Sequence[RecordPart], one: RecordPart) -> list[tuple[int, int]]:
    """Return the cells of a part of vibration without its shocks, from first to stop."""
    cuts = [p for p in parts if p.kind == "shock" and p.stop > one.first and p.first < one.stop]
    starts = [one.first, *(p.stop for p in cuts)]
    stops = [*(p.first for p in cuts), one.stop]
    return [(a, b) for a, b in zip(starts, stops, strict=True) if b > a]


def _cells_in(parts: Sequence[RecordPart], one: RecordPart) -> list[tuple[int, int]]:
    return [(one.first, one.stop)] if one.kind == "shock" else _calm(parts, one)


def _row(run: _LevelRun, cells: Cells, parts: Sequence[RecordPart], i: int) -> dict[str, Cell]:
    """Return when a part is, with peak and rms of each channel, of vibration without shocks."""
    one, seconds = parts[i], cells.seconds
    chosen = [np.arange(a, b) for a, b in _cells_in(parts, one)]
    seen = np.concatenate([*chosen, np.zeros(0, dtype=np.int64)]).astype(np.int64)
    shocks = sum(p.kind == "shock" and one.first <= p.first < one.stop for p in parts)
    cell_values: dict[str, Cell] = {
        "part": float(i + 1),
        "kind": one.kind,
        "start_s": run.start + one.first * seconds,
        "stop_s": run.start + one.stop * seconds,
        "duration_s": (one.stop - one.first) * seconds,
        "shocks": None if one.kind == "shock" else float(shocks),
    }
    for row, name in enumerate(run.names):
        peak, square = cells.peak[row, seen], cells.mean_square[row, seen]
        known = seen.size > 0
        cell_values[f"peak_{name}_g"] = float(peak.max()) / STANDARD_GRAVITY if known else None
        rms = float(np.sqrt(square.mean())) if known else None
        cell_values[f"rms_{name}_g"] = None if rms is None else rms / STANDARD_GRAVITY
    return cell_values


def _shocks(
    run: _LevelRun, cells: Cells, parts: Sequence[RecordPart], wanted: Splitting
) -> Iterator[PartSpectrum]:
    """Yield the shock response spectra of the highest shocks, in order of time."""
    asked = run.result.test.processing.shock or Shock(low=1.0 / wanted.longest, per_octave=6)
    shocks = [i for i, part in enumerate(parts) if part.kind == "shock"]
    if not shocks:
        return
    frequency = natural_frequencies(
        run.result, (asked.low, asked.high), asked.per_octave, SplittingAnalysis.kind
    )
    highest = sorted(shocks, key=lambda i: -cells.peak[:, parts[i].first : parts[i].stop].max())
    for i in sorted(highest[:MOST_SPECTRA]):
        samples = run.blocks(*run.samples_of(parts[i], cells.length))
        spectra_of_shocks = shock_spectra(samples, cells.sample_rate, frequency, asked.damping)
        maximax = spectra_of_shocks.values["absolute_acceleration"]["maximax"]
        yield PartSpectrum(i + 1, parts[i].kind, frequency, maximax)


def _vibration(
    run: _LevelRun, cells: Cells, parts: Sequence[RecordPart]
) -> Iterator[PartSpectrum]:
    """Yield the densities of the longest parts of vibration, in order of time."""
    vibration = [i for i, part in enumerate(parts) if part.kind != "shock"]
    longest = sorted(vibration, key=lambda i: parts[i].first - parts[i].stop)
    for i in sorted(longest[:MOST_SPECTRA]):
        density = _density(run, cells, _calm(parts, parts[i]))
        if density is not None:
            yield PartSpectrum(i + 1, parts[i].kind, run.result.spectra.frequency, density)


def _density(
    run: _LevelRun, cells: Cells, pieces: Sequence[tuple[int, int]]
) -> FloatArray | None:
    """Return the density over pieces of a record; None where none holds a segment."""
    spectra, length = run.result.spectra, cells.length
    total, averages = np.zeros((len(run.names), spectra.frequency.size)), 0
    for first, stop in pieces:
        if (stop - first) * length < spectra.segment:
            continue
        cross = cross_spectra(
            run.blocks(first * length, stop * length), cells.sample_rate,
            segment=spectra.segment, overlap=spectra.overlap, window=spectra.window,
            n_fft=spectra.n_fft, detrend=spectra.detrend,
        )  # fmt: skip
        total += cross.n_segments * psd(cross)
        averages += cross.n_segments
    return total / averages if averages else None


def _columns(
    spectra: Sequence[PartSpectrum], names: Sequence[str]
) -> dict[str, FloatArray | list[str]]:
    """Return a row for each part and frequency: densities of vibration, maximax of shocks."""
    sizes = [one.frequency.size for one in spectra]
    columns: dict[str, FloatArray | list[str]] = {
        "part": np.repeat([float(one.number) for one in spectra], sizes),
        "kind": [one.kind for one in spectra for _ in range(one.frequency.size)],
        "frequency_hz": np.concatenate([np.zeros(0), *(one.frequency for one in spectra)]),
    }
    for row, name in enumerate(names):
        for shock, header, unit in (
            (False, f"psd_{name}_g2_per_hz", STANDARD_GRAVITY**2),
            (True, f"shock_maximax_{name}_g", STANDARD_GRAVITY),
        ):
            values = [
                one.values[row] / unit
                if (one.kind == "shock") is shock
                else np.full(one.frequency.size, np.nan)
                for one in spectra
            ]
            columns[header] = np.concatenate([np.zeros(0), *values])
    return columns


def _advice(parts: Sequence[RecordPart], spectra: Sequence[PartSpectrum]) -> Iterator[str]:
    """Yield the next step, and the parts without a spectrum."""
    yield (
        "To process a part alone, give a test of the log its times: crop: {from: ... s, "
        "to: ... s}. Peak and rms of vibration are without the shocks in it."
    )
    n_unread = len(parts) - len(spectra)
    if n_unread:
        yield (
            f"{n_unread} of {len(parts)} parts have no spectrum: only the {MOST_SPECTRA} "
            f"highest shocks and the {MOST_SPECTRA} longest parts of vibration have one. A "
            "part has to hold one segment of welch without a shock."
        )
