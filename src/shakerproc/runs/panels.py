"""Figures of a run as data: panels of its analyses, envelopes, points that tell a curve."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray

Cell: TypeAlias = str | float | bool | None

Look: TypeAlias = Literal["curve", "alarm", "abort", "demand", "paper"]
"""What a line is: a result of a channel, a limit, what is demanded, a line of the paper."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PanelLine:
    """One line of a figure.

    Attributes
    ----------
    label : str
        Name in the legend; empty for a line that needs none.
    x, y : (n,) arrays
        Points, in the units of the axes; not a number breaks the line.
    channel : str
        Whose it is, so that a channel has one colour everywhere; empty for a limit.
    look : Look
        What it is.
    style : int
        Colour and dash of a line that is no channel's.
    """

    label: str
    x: FloatArray
    y: FloatArray
    channel: str = ""
    look: Look = "curve"
    style: int = 0


@final
@dataclass(frozen=True, slots=True)
class PanelScale:
    """An axis: its label with the unit, whether it is logarithmic, and its ends if fixed."""

    label: str
    logarithmic: bool = True
    ends: tuple[float, float] | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One figure.

    Attributes
    ----------
    name : str
        Name of its file, such as ``shock_maximax``.
    title, caption : str
        What it is, and what to look for.
    x, y : PanelScale
        Axes.
    lines : tuple of PanelLine
        What is drawn.
    equal : bool
        Whether a unit is as long along one axis as along the other, both being linear.
    """

    name: str
    title: str
    caption: str
    x: PanelScale
    y: PanelScale
    lines: tuple[PanelLine, ...]
    equal: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """Result of one further analysis of a run.

    Attributes
    ----------
    kind : str
        Key in the log and name of its table.
    title : str
        For people.
    columns : mapping
        The whole table, columns of equal length by header with units.
    summary : tuple of mapping
        A few rows for the report, the terminal and the table of the batch, by header.
    panels : tuple of Panel
        Figures.
    sentences : tuple of str
        Sentences for people.
    problems : tuple of str
        What is odd or not kept, a sentence each: flags of the run.
    """

    kind: str
    title: str
    columns: Mapping[str, Any]
    summary: tuple[Mapping[str, Cell], ...]
    panels: tuple[Panel, ...]
    sentences: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


OFF: Final = 2.0
"""How far off a straight line a point may lie that is left out [steps of a drawing]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Envelope:
    """Extremes of each slice of time.

    Attributes
    ----------
    time : (n_slices,) array
        Middle of each slice [s].
    low, high : (n_channels, n_slices) arrays
        Smallest and largest sample of each slice [unit of the channel].
    """

    time: FloatArray
    low: FloatArray
    high: FloatArray


def envelope(
    blocks: Iterable[FloatArray], n_samples: int, sample_rate: float, n_slices: int = 1200
) -> Envelope:
    """Return the extremes of samples that come in blocks.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        All samples in order [unit of the channel].
    n_samples : int
        How many there are.
    sample_rate : float
        Samples per second [Hz].
    n_slices : int
        Slices of equal length; fewer where there are fewer samples.

    Returns
    -------
    Envelope
        Extremes of each slice.
    """
    n_slices = max(1, min(n_slices, n_samples))
    edges = np.arange(n_slices + 1) * n_samples // n_slices
    low: FloatArray | None = None
    high: FloatArray | None = None
    position = 0
    for block in blocks:
        if low is None or high is None:
            low = np.full((block.shape[0], n_slices), np.inf)
            high = np.full((block.shape[0], n_slices), -np.inf)
        end = position + block.shape[1]
        first = int(np.searchsorted(edges, position, side="right")) - 1
        last = int(np.searchsorted(edges, end, side="left"))
        starts = np.maximum(edges[first:last] - position, 0)
        part = slice(first, last)
        low[:, part] = np.fmin(low[:, part], np.minimum.reduceat(block, starts, axis=1))
        high[:, part] = np.fmax(high[:, part], np.maximum.reduceat(block, starts, axis=1))
        position = end
    middle = np.asarray((edges[:-1] + edges[1:]) / (2.0 * sample_rate), dtype=float)
    if low is None or high is None:
        return Envelope(middle, np.zeros((0, n_slices)), np.zeros((0, n_slices)))
    return Envelope(middle, low, high)


def thinned(x: FloatArray, y: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Return a curve with at most so many points, in order.

    Of a function of `x` the extremes of each slice; of a line that goes back and forth, as a
    circle does, points at equal distances along it. A line that is broken stays so: of the
    values that are none, one in each slice or gap is kept.

    Parameters
    ----------
    x, y : (n,) arrays
        Points [any unit]; `y` not a number breaks the line.
    most : int
        How many are kept, beside the gaps of a line that goes back and forth.
    """
    if x.size <= most:
        return x, y
    steps = np.diff(x[np.isfinite(x)])
    loops = np.any(steps > 0.0) and np.any(steps < 0.0)
    kept = _along(x, y, most) if loops else _extremes(y, most)
    return x[kept], y[kept]


def straightened(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line without the points that lie within `OFF` of a straight line along x or y.

    Each point that is kept begins a stretch, which lasts as long as one straight line from it
    leaves no point further off than that, along y; where x goes back or stands, it ends.

    Parameters
    ----------
    x, y : (n,) arrays
        Finite points in steps of a drawing [-].
    """
    across, up = x.tolist(), y.tolist()
    kept, anchor = [0], 0
    least, most = -np.inf, np.inf
    for i in range(1, len(across)):
        run = across[i] - across[anchor]
        slope = (up[i] - up[anchor]) / run if run > 0.0 else np.nan
        if i > anchor + 1 and not (least <= slope <= most and across[i] > across[i - 1]):
            anchor = i - 1
            kept.append(anchor)
            least, most = -np.inf, np.inf
            run = across[i] - across[anchor]
        if run > 0.0:
            least = max(least, (up[i] - up[anchor] - OFF) / run)
            most = min(most, (up[i] - up[anchor] + OFF) / run)
        else:
            least, most = np.inf, -np.inf  # upright, or back: the next point begins anew
    if len(across) > 1:
        kept.append(len(across) - 1)
    return x[kept], y[kept]


def _extremes(y: FloatArray, most: int) -> list[int]:
    finite = np.isfinite(y)
    each = 2 if finite.all() else 3
    kept: list[int] = []
    for part in np.array_split(np.arange(y.size), most // each):
        good, gaps = part[finite[part]], part[~finite[part]]
        chosen = {int(gap) for gap in gaps[:1]}
        if good.size:
            chosen |= {int(good[np.argmin(y[good])]), int(good[np.argmax(y[good])])}
        kept.extend(sorted(chosen))
    return kept


def _along(x: FloatArray, y: FloatArray, most: int) -> list[int]:
    finite = np.isfinite(x) & np.isfinite(y)
    places = np.flatnonzero(finite)
    if not places.size:
        return [0]
    wide, high = (float(np.ptp(row[places])) or 1.0 for row in (x, y))
    way = np.hypot(np.diff(x[places]) / wide, np.diff(y[places]) / high)
    length = np.concatenate([[0.0], np.cumsum(way)])
    wanted = np.searchsorted(length, np.linspace(0.0, length[-1], most))
    gaps = np.flatnonzero(~finite & np.concatenate([[True], finite[:-1]]))
    return sorted({*places[np.minimum(wanted, places.size - 1)].tolist(), *gaps.tolist()})
