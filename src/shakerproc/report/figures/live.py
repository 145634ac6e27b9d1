"""The numbers of a drawing for the script of the page, small: two letters for a value."""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from shakerproc.data import FloatArray
from shakerproc.report.figures.figure import Axis, Curve, Filling, Plot, unwrapped
from shakerproc.report.figures.style import COLOURS

_LETTERS: Final = np.frombuffer(
    b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_", dtype=np.uint8
)
"""Digits to base 64."""

PLACES: Final = (3, 2)
"""Digits of a value along x and y: steps of 4 millionths and of a quarter per thousand of the
range of the figure's values; where the axis is logarithmic, of the range of the logarithms."""

EVEN: Final = 2e-2
"""How far places may lie off even steps to be told as such, in steps [-]."""


def payload(plot: Plot) -> Markup:
    """Return an element without content whose value holds the numbers of a figure.

    Nothing, where a line goes back and forth along x.
    """
    x_axis, y_axis, marks, spans = plot.x, plot.y, plot.marks, plot.spans
    items = [unwrapped(item, y_axis) for item in plot.items]
    drawn = [one for item in items if (one := _placed(item, x_axis)).x.size]
    if any(_loops(item) for item in drawn):
        return Markup("")  # the script draws functions of x
    x_range = _range([item.x for item in drawn], logarithmic=x_axis.logarithmic)
    y_range = _range(
        [rows for item in drawn for rows in _rows(item)], logarithmic=y_axis.logarithmic
    )
    known: dict[bytes, int] = {}
    lines = []
    for i, item in enumerate(drawn):
        first = known.setdefault(item.x.tobytes(), i)
        places = first if first < i else _places(item.x, x_axis, x_range)
        values: list[Any] = [_text(row, y_axis, y_range, PLACES[1]) for row in _rows(item)]
        if isinstance(item, Curve) and any(item.hollow):
            values.append([j for j, empty in enumerate(item.hollow) if empty])
        if isinstance(item, Curve) and len(item.bars):
            values += [[]] * (2 - len(values)) + [[_rounded(bar) for bar in item.bars]]
        lines.append([item.label, item.style % len(COLOURS), _kind(item), places, *values])
    content: dict[str, Any] = {
        "x": [*_axis(x_axis), *_short(x_range)],
        "y": [*_axis(y_axis), *_short(y_range)],
        "c": lines,
    }
    if marks:
        content["m"] = [[_rounded(mark.x), mark.label] for mark in marks]
    if spans:
        content["s"] = [[_rounded(span.low), _rounded(span.high)] for span in spans]
    if plot.image is not None:
        content["i"] = [_rounded(plot.image.low), _rounded(plot.image.high), plot.image.label]
    if plot.spread and y_axis.logarithmic:
        content["e"] = _rounded(plot.spread[1] / plot.spread[0])
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup("<data value='{}'></data>").format(quoted(text))


def _placed(item: Curve | Filling, axis: Axis) -> Curve | Filling:
    """Return an item of which every point has a place along x; where one has none, a break."""
    known = np.isfinite(axis.share(item.x))
    if known.all():
        return item
    at = np.maximum.accumulate(np.where(known, np.arange(item.x.size), -1))
    begun = at >= 0
    x, known = item.x[at[begun]], known[begun]
    if isinstance(item, Filling):
        low, high = (np.where(known, row[begun], np.nan) for row in (item.low, item.high))
        return replace(item, x=x, low=low, high=high)
    hollow, bars = (
        tuple(np.asarray(row)[begun[: len(row)]]) for row in (item.hollow, item.bars)
    )
    y = np.where(known, item.y[begun], np.nan)
    return replace(item, x=x, y=y, hollow=hollow, bars=bars)


def _loops(item: Curve | Filling) -> bool:
    """Return whether a line goes back and forth."""
    if isinstance(item, Curve) and (item.points or item.dots):
        return False
    steps = np.diff(item.x)
    return bool(np.any(steps > 0.0) and np.any(steps < 0.0))


def quoted(text: str) -> Markup:
    """Return text for an attribute in single quotes; JSON is full of double ones."""
    safe = text.replace("&", "&amp;").replace("'", "&#39;")
    return Markup(safe.replace("<", "&lt;").replace(">", "&gt;"))  # noqa: S704 - escaped here


def _axis(axis: Axis) -> list[Any]:
    steps = 1 if axis.logarithmic else 2 if axis.degrees else 0
    return [axis.label, _rounded(axis.low), _rounded(axis.high), steps]


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def _short(limits: tuple[float, float]) -> list[float]:
    """Return limits rounded as the text is: they are what it is decoded with."""
    return [_rounded(value) for value in limits]


def _rows(item: Curve | Filling) -> list[FloatArray]:
    return [item.high, item.low] if isinstance(item, Filling) else [item.y]


def _kind(item: Curve | Filling) -> int:
    """Return 0 for a line, 1 thin, 2 broad, 3 marks, 4 dots, 5 an area."""
    if isinstance(item, Filling):
        return 5
    flags = (item.thin, item.wide, item.points, item.dots)
    return next((i for i, flag in enumerate(flags, 1) if flag), 0)


def _range(rows: Sequence[FloatArray], *, logarithmic: bool) -> tuple[float, float]:
    """Return the smallest and largest value, made to be told apart and rounded outwards."""
    values = np.concatenate([*rows, np.zeros(0)])
    values = values[np.isfinite(values) & ((values > 0.0) | (not logarithmic))]
    if not values.size:
        return 1.0, 2.0
    low, high = float(values.min()), float(values.max())
    if logarithmic:
        return _rounded(low * (1.0 - 1e-5)), _rounded(high * (1.0 + 2e-5))
    margin = 1e-5 * max(high - low, abs(high), abs(low), 1e-12)
    return _rounded(low - margin), _rounded(high + margin)


def _places(x: FloatArray, axis: Axis, limits: tuple[float, float]) -> str | list[float]:
    """Return where points lie: first and last and their number where they are even."""
    if x.size > 2 and not axis.logarithmic and np.isfinite(x).all():
        even = np.linspace(x[0], x[-1], x.size)
        step = abs(x[-1] - x[0]) / (x.size - 1)
        if step > 0.0 and np.max(np.abs(x - even)) < EVEN * step:
            return [_rounded(float(x[0])), _rounded(float(x[-1])), x.size]
    return _text(x, axis, limits, PLACES[0])


def _text(values: FloatArray, axis: Axis, limits: tuple[float, float], places: int) -> str:
    """Return values as letters; the largest number there is says that there is none."""
    low, high = limits
    top = 64**places - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        if axis.logarithmic:
            values, low, high = np.log(np.maximum(values, 0.0)), np.log(low), np.log(high)
        share = (values - low) / (high - low)
    known = np.isfinite(share)
    steps = np.full(values.size, top, dtype=np.int64)
    steps[known] = np.rint(np.clip(share[known], 0.0, 1.0) * (top - 1)).astype(np.int64)
    digits = np.array([steps >> (6 * place) & 63 for place in reversed(range(places))])
    return str(_LETTERS[digits.T.ravel()].tobytes(), "ascii")
