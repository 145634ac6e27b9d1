"""Numbers of the evidence: candidates and intervals for people, all of them as tables."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from markupsafe import Markup

from shakerproc.comparison import by_range
from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS, Estimate
from shakerproc.diagnosis.headline import LEAST_SHARE
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.numerals import numeral
from shakerproc.report.evidence.comparison import Models, cloud, loudest, same_joint, spread_out
from shakerproc.report.evidence.spectra import picked
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
    rows = [
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
        ReportTable("Found, with 95 % intervals", columns, [*rows, *linear]),
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
    """Return value, low, high, the parts of tests and of calibration in the band, and unit."""
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


Columns = dict[str, list[Any]]

_OF_MOTION: Final = ("test", "between", "model", "quantity", "unit")
_MOTIONS: Final = (("displacement", "m"), ("velocity", "m/s"))


def tables(models: Models | None, diagnosis: Diagnosis | None) -> dict[str, Columns]:
    """Return columns by the name of their file."""
    out: dict[str, Columns] = {}
    if models is not None:
        out["response_functions.csv"] = response_functions(models)
        out["errors_by_test.csv"] = errors_by_test(models)
        out["errors_by_band.csv"] = errors_by_band(models)
        out["errors_by_motion.csv"] = errors_by_motion(models)
        out["restoring_force.csv"] = restoring_forces(models)
    if diagnosis is not None:
        out["ladder.csv"] = candidates(diagnosis)
        out["parameters.csv"] = parameters(diagnosis)
        out["hidden_joints.csv"] = hidden_joints(diagnosis)
    return {name: columns for name, columns in out.items() if next(iter(columns.values()))}


def _columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> Columns:
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def hidden_joints(diagnosis: Diagnosis) -> Columns:
    """Return motion [m] and force [N] of joints that no recording tells, with bands."""
    rows = []
    for joint in diagnosis.hidden:
        z, f = joint.displacement, joint.force
        values = (joint.time, z.value, z.low, z.high, f.value, f.low, f.high)
        where = (" - ".join(joint.between), joint.test)
        rows += [(*where, *one) for one in zip(*values, strict=True)]
    names = (
        "between", "test", "time_s", "displacement_m", "displacement_low_m",
        "displacement_high_m", "force_n", "force_low_n", "force_high_n",
    )  # fmt: skip
    return _columns(names, rows)


def response_functions(models: Models) -> Columns:
    """Return response function and coherence of the drawn tests, measured and of each model."""
    rows: list[tuple[Any, ...]] = []
    for index in spread_out(models.before):
        test = models.before.tests[index]
        _, pick = picked(test.pair.frequency, test.pair.excited)
        for sensor, name in enumerate(test.measured.sensors):
            pair = test.pair
            whose = [("measured", pair.h1[sensor], pair.coherence[sensor])] + [
                (text, c.tests[index].pair.h1_model[sensor],
                 c.tests[index].pair.coherence_model[sensor])
                for text, _, c in models.each
            ]  # fmt: skip
            for text, h1, coherence in whose:
                rows += [
                    (test.measured.name, name, text, float(f), float(abs(h)),
                     float(np.degrees(np.angle(h))), float(g))
                    for f, h, g in zip(
                        pair.frequency[pick], h1[pick], coherence[pick], strict=True
                    )
                ]  # fmt: skip
    names = ("test", "sensor", "whose", "frequency_hz", "magnitude", "phase_deg", "coherence")
    return _columns(names, rows)


def errors_by_test(models: Models) -> Columns:
    """Return the error of each model in every test, and the noise."""
    rows = [
        (test.measured.name, test.measured.test.level_text, test.measured.test.hold_out, text,
         float(np.sqrt(np.mean(test.prediction.input**2))), test.error, test.noise,
         test.floor.source)
        for text, _, comparison in models.each
        for test in comparison.tests
    ]  # fmt: skip
    names = (
        "test",
        "level",
        "held_out",
        "model",
        "input_rms_si",
        "error",
        "noise",
        "noise_from",
    )
    return _columns(names, rows)


def errors_by_band(models: Models) -> Columns:
    """Return the error of each model in every third octave."""
    rows = []
    for text, _, comparison in models.each:
        bands = comparison.bands
        for i, test in enumerate(comparison.tests):
            for j, sensor in enumerate(test.measured.sensors):
                for k in range(bands.edges.size - 1):
                    rows.append((
                        test.measured.name, sensor, text, float(bands.edges[k]),
                        float(bands.edges[k + 1]), float(bands.error[i, j, k]),
                        float(bands.floor[i, j, k]), float(bands.share[i, j, k]),
                    ))  # fmt: skip
    names = ("test", "sensor", "model", "from_hz", "to_hz", "error", "noise", "share_of_error")
    return _columns(names, rows)


def errors_by_motion(models: Models) -> Columns:
    """Return the force that each model lacks by range of displacement and velocity."""
    rows = []
    for text, _, comparison in models.each:
        for test in comparison.tests:
            for joint in test.joints:
                for quantity, si in _MOTIONS:
                    bins = by_range(joint, getattr(joint, quantity))
                    rows += [
                        (test.measured.name, " - ".join(joint.between), text, quantity,
                         models.before.model.unit_of(si), float(a), float(b), float(c))
                        for a, b, c in zip(bins.centre, bins.mean, bins.error, strict=True)
                    ]  # fmt: skip
    return _columns((*_OF_MOTION, "middle", "missing_force_n", "error"), rows)


def restoring_forces(models: Models) -> Columns:
    """Return the samples of the restoring force that are drawn."""
    index = loudest(models.before)
    test = models.before.tests[index]
    rows = []
    for joint in test.joints:
        for text, _, comparison in models.each:
            motion = same_joint(comparison.tests[index], joint.between)
            if motion is None:
                continue
            for quantity, si in _MOTIONS:
                unit = models.before.model.unit_of(si)
                along, force, law = cloud(motion, by_velocity=quantity == "velocity")
                rows += [
                    (test.measured.name, " - ".join(joint.between), text, quantity, unit, *row)
                    for row in zip(along.tolist(), force.tolist(), law.tolist(), strict=True)
                ]
    return _columns((*_OF_MOTION, "motion", "force_n", "force_model_n"), rows)


def candidates(diagnosis: Diagnosis) -> Columns:
    """Return the error of every model that was tried."""
    errors = diagnosis.errors.among
    rows: list[tuple[Any, ...]] = [
        ("model as it was", "", errors.fitted.before, errors.held_out.before)
    ]
    rows += [
        (c.kind, " - ".join(c.between), c.fitted_error, c.held_out_error)
        for c in diagnosis.candidates
    ]
    rows.append(("new model", "", errors.fitted.after, errors.held_out.after))
    rows.append(("noise floor", "", None, errors.noise_floor))
    return _columns(("model", "between", "fitted_error", "held_out_error"), rows)


def parameters(diagnosis: Diagnosis) -> Columns:
    """Return the parameters of the effects, of the linear joints and of every candidate."""
    rows: list[tuple[Any, ...]] = [
        ("found", e.kind, " - ".join(e.between), name, *p.row)
        for e in diagnosis.effects
        for name, p in e.parameters.items()
    ]
    rows += [
        ("linear", "joint", place, number, *p.row)
        for name, p in diagnosis.linear.items()
        for number, place in [name.split(" ", 1)]
    ]  # fmt: skip
    rows += [
        ("candidate", c.kind, " - ".join(c.between), name, *p.row)
        for c in diagnosis.candidates
        if c.held_out_error is not None
        for name, p in c.parameters.items()
    ]
    return _columns(("of", "kind", "between", "number", *ESTIMATE_COLUMNS), rows)
