"""A recording as it is, against time: before anything of it is cropped or averaged."""

from typing import TYPE_CHECKING

from shakerproc.data import Recording
from shakerproc.report import style
from shakerproc.report.run_figures import LEFT
from shakerproc.runs.envelope import envelope
from shakerproc.runs.result import shown_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def time_signals(recording: Recording) -> "Figure":
    """Return every channel against time: the extremes of each of some thousand slices."""
    found = envelope(recording.blocks(), recording.n_samples, recording.sample_rate)
    n = len(recording.channels)
    with style.look():
        figure, axes = style.figure(
            7.0, 0.5 + 0.85 * n, n, sharex=True, left=LEFT, legend=False
        )
        for i, (axis, channel) in enumerate(zip(axes, recording.channels, strict=True)):
            unit, factor = shown_unit(channel.unit)
            low, high = found.low[i] * factor, found.high[i] * factor
            axis.fill_between(found.time, low, high, color=style.COLOURS[0], lw=0.3)
            style.name(axis, channel.name, unit)
        style.head(axes[0], recording.run, f"{recording.duration:.4g} s", legend=False)
        axes[-1].set_xlabel("time [s]")
        axes[-1].set_xlim(0.0, recording.duration)
    return figure
