"""Samples as they are, against time: before anything is cropped or averaged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import LEFT
from shakerproc.report.figures.units import USUAL, read_unit
from shakerproc.runs.thinning import Envelope, envelope

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def time_signals(recording: Recording) -> "Figure":
    """Return every channel against time: the extremes of each of some thousand slices."""
    found = envelope(recording.blocks(), recording.n_samples, recording.sample_rate)
    named = []
    for channel in recording.channels:
        unit, factor = read_unit(channel.unit)
        named.append((channel.name, unit, factor))
    return _drawn(recording.run, found, named, recording.duration)


def signals(
    title: str, time: FloatArray, named: Sequence[tuple[str, str, FloatArray]]
) -> "Figure":
    """Return signals against time, likewise.

    Parameters
    ----------
    title : str
        Headline.
    time : (n,) array
        From 0 in equal steps [s].
    named : sequence of (str, str, (n,) array)
        Name, unit and samples of each.
    """
    rate = (time.size - 1) / float(time[-1]) if time.size > 1 else 1.0
    rows = np.stack([samples for _, _, samples in named])
    found = envelope([rows], time.size, rate)
    return _drawn(
        title,
        found,
        [(name, *USUAL.unit(unit)) for name, unit, _ in named],
        time.size / rate,
    )


def _drawn(
    title: str, found: Envelope, named: Sequence[tuple[str, str, float]], duration: float
) -> "Figure":
    n = len(named)
    with style.look():
        figure, axes = style.figure(
            7.0, 0.5 + 0.85 * n, n, sharex=True, left=LEFT, legend=False
        )
        for i, (axis, (name, unit, factor)) in enumerate(zip(axes, named, strict=True)):
            low, high = found.low[i] * factor, found.high[i] * factor
            axis.fill_between(found.time, low, high, color=style.COLOURS[0], lw=0.5)
            style.name(axis, name)
            axis.set_ylabel(f"[{unit}]")
        style.head(axes[0], title, f"{numeral(duration, 4)} s", legend=False)
        axes[-1].set_xlabel("time [s]")
        axes[-1].set_xlim(0.0, duration)
    return figure
