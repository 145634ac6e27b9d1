"""Velocity and displacement of every acceleration, by integration."""

from collections.abc import Iterator
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis, accelerations
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.spectra.integration import integrated, straight_baseline

SLICES: Final = 4000
"""Rows of the table; of a longer run each holds the extremes of several samples."""

QUANTITIES: Final = ("velocity", "displacement")

UNITS: Final = {"velocity": "mm_per_s", "displacement": "mm"}

_SHOWN: Final = {"velocity": "mm/s", "displacement": "mm"}
_FACTOR: Final = 1e3  # both are shown in thousandths


@final
class IntegrationAnalysis(AbstractAnalysis):
    """Velocity and displacement of the accelerations."""

    kind: ClassVar[str] = "integration"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return velocities and displacements of a run."""
        wanted = result.test.processing.integration
        if wanted is None:
            return None
        rows = accelerations(result, self.kind)
        corner = _corner(result, wanted.high_pass)
        motion = _Motion(result, len(rows))
        for block in _integrals(recording.select(rows), result, corner):
            motion.add(block)
        names = [result.channels[i].name for i in rows]
        how = (
            "from rest, no high-pass"
            if corner is None
            else f"high-pass {numeral(corner, 4)} Hz"
        )
        return Analysis(
            kind=self.kind,
            title=f"Velocity and displacement ({how}, baseline: {wanted.baseline_taken})",
            columns=motion.columns(names),
            summary=tuple(motion.row(i, name) for i, name in enumerate(names)),
            panels=tuple(motion.panel(k, names) for k in range(2)),
        )


def _corner(result: RunResult, wanted: float | str | None) -> float | None:
    """Return the corner of the high-pass; by default half the low end of the excited band.

    Raises
    ------
    SpectrumError
        If it lies above half the sample rate, or the run holds less than two of its periods.
    """
    if wanted == "none":
        return None
    corner = 0.5 * result.band[0] if wanted is None else float(wanted)
    seconds = result.crop.n_samples / result.recorded.sample_rate
    if not 2.0 / seconds <= corner <= 0.5 * result.recorded.sample_rate:
        raise SpectrumError(
            f"integration: a high-pass at {numeral(corner, 4)} Hz does not lie between two "
            f"periods in the run ({numeral(2.0 / seconds, 4)} Hz) and half the sample rate. "
            "Give another high_pass, or high_pass: none"
        )
    return corner


def _integrals(
    recording: Recording, result: RunResult, corner: float | None
) -> Iterator[FloatArray]:
    """Return the integrals of the run in blocks, its baseline taken out first."""
    part = (result.crop.start, result.crop.stop)
    wanted = result.test.processing.integration
    kind = "none" if wanted is None else wanted.baseline_taken
    middle = slope = np.zeros((len(recording.channels), 1))
    if kind != "none":
        middle, slope = straight_baseline(recording.samples, part, sloped=kind == "line")
    centre = 0.5 * (part[0] + part[1] - 1)

    def read(start: int, stop: int) -> FloatArray:
        places = np.clip(np.arange(start, stop), part[0], part[1] - 1) - centre
        return recording.samples(start, stop) - middle - slope * places

    return integrated(
        read, recording.n_samples, result.recorded.sample_rate, part, corner=corner
    )


@final
class _Motion:
    """Extremes of slices and sums of velocity and displacement, gathered block by block."""

    def __init__(self, result: RunResult, n_channels: int) -> None:
        self.result = result
        self.n_samples = result.crop.n_samples
        self.each = max(1, -(-self.n_samples // SLICES))
        count = -(-self.n_samples // self.each)
        shape = (2, n_channels, count)
        self.low, self.high = np.full(shape, np.inf), np.full(shape, -np.inf)
        self.power = np.zeros((2, n_channels))
        self.at = 0

    def add(self, block: FloatArray) -> None:
        """Take in the next samples."""
        slices = (self.at + np.arange(block.shape[2])) // self.each
        starts = np.flatnonzero(np.diff(slices, prepend=-1))
        there = slices[starts]
        low = np.minimum.reduceat(block, starts, axis=2)
        high = np.maximum.reduceat(block, starts, axis=2)
        self.low[:, :, there] = np.minimum(self.low[:, :, there], low)
        self.high[:, :, there] = np.maximum(self.high[:, :, there], high)
        self.power += np.sum(block**2, axis=2)
        self.at += block.shape[2]

    @property
    def time(self) -> FloatArray:
        """Start of each slice, from the start of the recording [s]."""
        first = self.result.crop.start + self.each * np.arange(self.low.shape[2])
        return np.array(first / self.result.recorded.sample_rate)

    def columns(self, names: list[str]) -> dict[str, FloatArray]:
        """Return least and largest of each slice, against time."""
        columns = {"time_s": self.time}
        for i, name in enumerate(names):
            for k, quantity in enumerate(QUANTITIES):
                for side, values in (("low", self.low), ("high", self.high)):
                    header = f"{quantity}_{side}_{name}_{UNITS[quantity]}"
                    columns[header] = values[k, i] * _FACTOR
        return columns

    def row(self, i: int, name: str) -> dict[str, Cell]:
        """Return rms, largest and the way from end to end of a channel."""
        cells: dict[str, Cell] = {"channel": name}
        for k, quantity in enumerate(QUANTITIES):
            low, high = self.low[k, i].min() * _FACTOR, self.high[k, i].max() * _FACTOR
            rms = np.sqrt(self.power[k, i] / self.n_samples) * _FACTOR
            for what, value in (
                ("rms", rms),
                ("peak", max(-low, high)),
                ("peak_to_peak", high - low),
            ):
                cells[f"{quantity}_{what}_{UNITS[quantity]}"] = float(value)
        return cells

    def panel(self, k: int, names: list[str]) -> Panel:
        """Return velocity or displacement against time, slices as their two extremes."""
        quantity = QUANTITIES[k]
        time = np.repeat(self.time, 2)
        return Panel(
            name=f"integration_{quantity}",
            title=quantity.capitalize(),
            caption=f"{quantity.capitalize()} by integration; extremes of each slice.",
            x=PanelScale("time [s]", logarithmic=False),
            y=PanelScale(f"{quantity} [{_SHOWN[quantity]}]", logarithmic=False),
            lines=tuple(
                PanelLine(
                    name,
                    time,
                    np.stack([self.low[k, i], self.high[k, i]], axis=1).ravel() * _FACTOR,
                    channel=name,
                )
                for i, name in enumerate(names)
            ),
        )
