"""Errors and numbers of a diagnosis for people: candidates as one figure, intervals."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.headline import LEAST_SHARE
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.axes import UNIT, shown, ticks
from shakerproc.report.figures.figure import Axis, Curve
from shakerproc.report.figures.to_svg import legend, marker
from shakerproc.report.page.sections import ReportTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN_UNITS: Final[Mapping[str, tuple[str, float]]] = {
    "m": ("mm", 1e3),
    "kg": ("g", 1e3),
    "m/s^2": ("m/s²", 1.0),
    "1": ("-", 1.0),
}

_LEFT, _TOP, _ROW, _BELOW, _RIGHT = 230, 6, 22, 36, 20  # [px]
_WIDTH: Final = 1120
FITTED, HELD_OUT = 1, 0
"""Styles: a square for fitted tests, a disc for those kept aside."""


def candidate_name(kind: str, parameters: Mapping[str, Estimate]) -> str:
    """Return the kind of a candidate, with its side where it has one."""
    side = parameters.get("side")
    name = kind.replace("_", " ").replace("+", " + ")
    return name if side is None else f"{name}, {side.value}"


def parameter_tables(diagnosis: Diagnosis) -> list[ReportTable]:
    """Return the numbers of effects found, of the linear joints, and of every candidate."""
    parts = ("± by tests", "± by calibration")
    columns = ("", "between", "number", "value", "low", "high", *parts, "unit")
    found = [
        (
            effect.kind.replace("_", " "), " - ".join(effect.between), name,
            *_bounds_by_source(estimate),
        )
        for effect in diagnosis.effects
        for name, estimate in (effect.parameters or {"": Estimate("", None, None, "")}).items()
    ]  # fmt: skip
    linear = [
        ("linear joint", place, number, *_bounds_by_source(estimate))
        for name, estimate in diagnosis.linear.items()
        for number, place in [name.split(" ", 1)]
    ]
    tried = [
        (
            candidate_name(c.kind, c.parameters), " - ".join(c.between), name,
            *_bounds_by_source(estimate),
        )
        for c in diagnosis.candidates
        if c.held_out_error is not None
        for name, estimate in c.parameters.items()
    ]  # fmt: skip
    together = [
        (one.combination, " and ".join(one.numbers), *_bounds_by_source(one.estimate))
        for one in diagnosis.known_together
    ]
    tables = [
        ReportTable("Found, with 95 % intervals", columns, [*found, *linear]),
        ReportTable("Known of numbers that no test tells one by one", ("", "of", *columns[3:]),
              together),
        ReportTable("Candidates that were fitted, with 95 % intervals of those that stand",
              columns, tried),
    ]  # fmt: skip
    return [table for table in tables if table.rows]


def interval(estimate: Estimate) -> tuple[str, str, str, str, str]:
    """Return value, low, high, half width in per cent, and unit, for people."""
    if isinstance(estimate.value, str):
        return estimate.value, "", "", "", ""
    unit, factor = _SHOWN_UNITS.get(estimate.unit, (estimate.unit, 1.0))
    value = estimate.value * factor
    low, high = (
        "" if end is None or not math.isfinite(end) else numeral(end * factor, 4)
        for end in (estimate.low, estimate.high)
    )
    half = ""
    if estimate.low is not None and estimate.high is not None and value:
        half = f"{numeral(50.0 * abs((estimate.high - estimate.low) / estimate.value), 2)} %"
    return numeral(value, 4), low, high, half, unit


def _bounds_by_source(estimate: Estimate) -> tuple[str, str, str, str, str, str]:
    """Return value, low, high, what tests and what calibration leave open, and unit."""
    value, low, high, _, unit = interval(estimate)
    tests, calibration = map(_per_cent, (estimate.by_tests, estimate.by_calibration))
    return value, low, high, tests, calibration, unit


def _per_cent(share: float | None) -> str:
    """Return a share [-] in per cent; below LEAST_SHARE only that it is."""
    if share is None:
        return ""
    return (
        f"< {100.0 * LEAST_SHARE:g} %"
        if share < LEAST_SHARE
        else f"{numeral(100.0 * share, 2)} %"
    )


def shown_value(estimate: Estimate) -> str:
    """Return a value in the unit that people use, without it."""
    return interval(estimate)[0]


@dataclass(frozen=True, slots=True)
class CandidateError:
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


def ladder(rungs: Sequence[CandidateError], noise_floor: float | None, *, title: str) -> Markup:
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


def _rung(rung: CandidateError, y: float, place) -> Markup:  # type: ignore[no-untyped-def]
    out = Markup('<text class="end{}" x="{}" y="{:.0f}">{}</text>').format(
        " bold" if rung.strong else "", (_LEFT - 10) * UNIT, y + 15, rung.label
    )
    pairs = [(FITTED, rung.fitted), (HELD_OUT, rung.held_out)]
    for number, value in pairs:
        if value is None or not np.isfinite(value) or value <= 0.0:
            continue
        out += Markup('<path class="p{}" d="M{:.0f} {:.0f}{}"/>').format(
            number, place(value), y, marker(number)
        )
    return out


def candidate_errors(diagnosis: Diagnosis) -> "Figure":
    """Return the held-out error of the model as it was and with each hypothesis, as points."""
    from matplotlib.ticker import NullFormatter, PercentFormatter

    errors = diagnosis.errors.among
    tried = [one for one in diagnosis.candidates if one.held_out_error is not None]
    several = len({one.between for one in tried}) > 1
    names = ["model as it was"]
    for one in tried:
        place = f", {' - '.join(one.between)}" if several else ""
        names.append(candidate_name(one.kind, one.parameters) + place)
    values = [errors.held_out.before, *(one.held_out_error or 0.0 for one in tried)]
    with style.look():
        figure, (axis,) = style.figure(7.0, 1.2 + 0.28 * len(names), legend=False)
        places = range(len(names))
        colours = [style.COLOURS[7], *(style.COLOURS[0] for _ in tried)]
        axis.scatter(values, places, color=colours, s=30.0, zorder=3)
        axis.set_yticks(list(places), names)
        axis.invert_yaxis()
        axis.grid(visible=False, axis="y")
        floors = [errors.noise_floor] if math.isfinite(errors.noise_floor) else []
        for floor in floors:
            axis.axvline(floor, color=style.COLOURS[1], lw=1.2, label="noise floor")
        axis.set_xscale("log")
        inside = [*values, *floors]
        axis.set_xlim(0.6 * min(inside), 1.8 * max(inside))
        axis.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=None))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_xlabel("held-out error, share of the response [%]")
        axis.set_title(f"{diagnosis.verdict}: free-run errors of what was tried")
        axis.legend(loc="best")
    return figure
