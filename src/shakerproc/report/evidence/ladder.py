"""Errors of models one below the other: how far each comes down, on which tests."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.report.figures.axes import UNIT, shown, ticks
from shakerproc.report.figures.figure import Axis, Curve
from shakerproc.report.figures.to_svg import legend, marker

_LEFT, _TOP, _ROW, _BELOW, _RIGHT = 230, 6, 22, 36, 20  # [px]
_WIDTH: Final = 1120
FITTED, HELD_OUT = 1, 0
"""Styles: a square for fitted tests, a disc for those kept aside."""


@dataclass(frozen=True, slots=True)
class Rung:
    """One model.

    Attributes
    ----------
    label : str
        What it is.
    fitted, held_out : float, optional
        Its errors [-]; None where there are none.
    strong : bool
        Whether it is one of the two that matter: the old model or the new one.
    """

    label: str
    fitted: float | None
    held_out: float | None
    strong: bool = False


def ladder(rungs: Sequence[Rung], noise_floor: float | None, *, title: str) -> Markup:
    """Return the errors of models as marks on a logarithmic axis, and the noise floor.

    `noise_floor` is a share, as the errors are [-].
    """
    values = [v for rung in rungs for v in (rung.fitted, rung.held_out, noise_floor)]
    known = [v for v in values if v is not None and np.isfinite(v) and v > 0.0] or [0.1]
    low = 10.0 ** np.floor(np.log10(min(known)) - 0.05)
    high = 10.0 ** np.ceil(np.log10(max(known)) + 0.02)
    axis = Axis("share of the response that is not explained [-]", low, high, logarithmic=True)
    width, height = _WIDTH - _LEFT - _RIGHT, _TOP + len(rungs) * _ROW + _BELOW
    foot = (_TOP + len(rungs) * _ROW) * UNIT

    def place(value: float) -> float:
        return (_LEFT + float(axis.share(np.array([value]))[0]) * width) * UNIT

    parts = [_grid(axis, place, foot, width)]
    if noise_floor is not None and np.isfinite(noise_floor) and noise_floor > 0.0:
        parts.append(
            Markup(
                '<path class="mark" d="M{0:.0f} {1}V{2}"/>'
                '<text class="marked start" x="{3:.0f}" y="{4}">noise floor {5:.2g}</text>'
            ).format(
                place(noise_floor), _TOP * UNIT, foot, place(noise_floor) + 20,
                (_TOP + 11) * UNIT, noise_floor,
            )
        )  # fmt: skip
    for i, rung in enumerate(rungs):
        parts.append(_rung(rung, (_TOP + (i + 0.5) * _ROW) * UNIT, place))
    drawing = Markup(
        '<svg viewBox="0 0 {} {}" class="plot" role="img"><title>{}</title>{}</svg>'
    ).format(_WIDTH * UNIT, height * UNIT, title, Markup("").join(parts))
    nothing = np.zeros(0)
    keys = [
        Curve("fitted tests", nothing, nothing, FITTED, points=True),
        Curve("held-out tests", nothing, nothing, HELD_OUT, points=True),
    ]
    return drawing + legend(keys)


def _grid(axis: Axis, place, foot: float, width: int) -> Markup:  # type: ignore[no-untyped-def]
    lines = "".join(f"M{place(v):.0f} {_TOP * UNIT}V{foot:.0f}" for v in ticks(axis))
    numbers = Markup("").join(
        Markup('<text x="{:.0f}" y="{:.0f}">{}</text>').format(
            place(v), foot + 14 * UNIT, shown(v, axis)
        )
        for v in ticks(axis)
    )
    return (
        Markup('<path class="grid" d="{}"/>').format(lines)
        + numbers
        + Markup('<text x="{}" y="{:.0f}">{}</text>').format(
            (_LEFT + width // 2) * UNIT, foot + 30 * UNIT, axis.label
        )
    )


def _rung(rung: Rung, y: float, place) -> Markup:  # type: ignore[no-untyped-def]
    out = Markup('<text class="end{}" x="{}" y="{:.0f}">{}</text>').format(
        " bold" if rung.strong else "", (_LEFT - 10) * UNIT, y + 15, rung.label
    )
    pairs = [(FITTED, rung.fitted), (HELD_OUT, rung.held_out)]
    for style, value in pairs:
        if value is None or not np.isfinite(value) or value <= 0.0:
            continue
        out += Markup('<path class="p{}" d="M{:.0f} {:.0f}{}"/>').format(
            style, place(value), y, marker(style)
        )
    return out
