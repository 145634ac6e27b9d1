"""Measured against models along the motion: errors, restoring force, laws of force."""

import math
from typing import Final

import numpy as np

from shakerproc.comparison import by_range
from shakerproc.comparison.hidden_joints import Banded, HiddenJoint
from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.diagnosis.joint_outcomes import Outside
from shakerproc.diagnosis.result import Diagnosis, Tried
from shakerproc.models import EFFECTS
from shakerproc.models.effects import Table
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.models.motion import Motion, shown_in, unit_in
from shakerproc.numerals import numeral
from shakerproc.report.evidence.comparison import (
    AFTER,
    MEASURED,
    NOISE,
    Models,
    by_input,
    capitalised,
    cloud,
    input_rms,
    label,
    loudest,
    same_joint,
)
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.axes import heat_map
from shakerproc.report.figures.figure import Axis, Curve, Plot, Span
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.runs.in_units import logarithmic_axis

BEYOND: Final = 1.5
"""How far the drawing goes, as a multiple of the largest motion that was measured [-]."""

MOST: Final = 4
"""Laws in one drawing."""

_SAMPLES: Final = 400  # of a cycle
_CYCLES: Final = 4  # until the memory of a law has settled


def error_maps(models: Models) -> list[PageFigure]:
    """Return the error of each test in each third octave, before and after."""
    drawings = []
    for sensor, name in enumerate(models.before.tests[0].measured.sensors):
        for text, _, comparison in models.each:
            rows = by_input(comparison)[::-1]
            bands = comparison.bands
            columns = np.flatnonzero(bands.driven.any(axis=0))
            shown = slice(columns[0], columns[-1] + 1)
            driven = bands.driven[rows, shown]
            drawings.append(
                PageFigure(
                    f"{name}: error by band and level, {text} [%].",
                    "Loudest test on top; bold: where a fifth of the error and more lies. "
                    "An error that grows upwards depends on amplitude. Shown are the bands "
                    "that each test drives; errors_by_band.csv has the others.",
                    heat_map(
                        [label(comparison.tests[i]) for i in rows],
                        bands.edges[columns[0] : columns[-1] + 2],
                        np.where(driven, bands.error[rows, sensor, shown], np.nan),
                        bands.share[rows, sensor, shown] > 0.2,
                        title=f"Error of {name} by third octave, {text}",
                    ),
                    broad=True,
                )
            )
    return drawings


def error_by_level(models: Models) -> PageFigure:
    """Return the error of every test over its input."""
    rising = by_input(models.before)
    kept = [models.before.tests[i].measured.test.hold_out for i in rising]
    by_force = models.before.model.excitation.on is not None
    unit, factor = ("N", 1.0) if by_force else ("g", 1.0 / STANDARD_GRAVITY)
    x = np.array([input_rms(models.before, i) for i in rising]) * factor
    curves = []
    for text, style, comparison in models.each:
        y = np.array([comparison.tests[i].error for i in rising])
        curves.append(Curve("", x, y, style, thin=True))
        curves.append(Curve(text, x, y, style, points=True, hollow=kept))
    noise = np.array([models.noise[i] for i in rising])
    if np.any(np.isfinite(noise) & (noise > 0.0)):
        noise = np.where(noise > 0.0, noise, np.nan)
        curves.append(Curve("noise", x, noise, NOISE, thin=True))
    return PageFigure(
        "Error by level.",
        "Each mark is a test; hollow: held out. What rises with the level depends on "
        "amplitude; what falls is friction or noise.",
        to_svg.plot(
            Plot(
                curves,
                _around(f"measured input, rms [{unit}]", x),
                logarithmic_axis("error [-]", curves),
            ),
            title="Error of every test over its input",
        ),
    )


def _around(text: str, x: FloatArray) -> Axis:
    """Return a logarithmic axis with room to both sides."""
    low, high = float(x.min()), float(x.max())
    if not low > 0.0:
        return Axis(text, 0.0, 1.1 * high or 1.0)
    return Axis(text, 0.8 * low, 1.25 * high, logarithmic=True)


def error_by_motion(models: Models) -> list[PageFigure]:
    """Return the missing force over displacement and velocity in the loudest test."""
    index = loudest(models.before)
    test = models.before.tests[index]
    drawings = []
    for joint in test.joints:
        places = " and ".join(joint.between)
        for by_velocity, quantity, si in (
            (False, "displacement", "m"),
            (True, "velocity", "m/s"),
        ):
            largest = float(np.max(np.abs(getattr(joint, quantity))))
            unit, factor = shown_in(si, models.before.model.motion, largest)
            curves = []
            for text, style, comparison in models.each:
                motion = same_joint(comparison.tests[index], joint.between)
                if motion is None:
                    continue
                by_motion = by_range(
                    motion, motion.velocity if by_velocity else motion.displacement
                )
                curves.append(Curve(text, by_motion.centre * factor, by_motion.error, style))
            reach = max(float(np.max(np.abs(c.x))) for c in curves) * 1.05
            drawings.append(
                PageFigure(
                    f"Error by {quantity}, between {places}.",
                    f"{capitalised(label(test))}: rms of measured less modelled force in "
                    f"each range, over the rms force of the test. Look where it begins.",
                    to_svg.plot(
                        Plot(
                            curves,
                            Axis(f"{quantity} [{unit}]", -reach, reach),
                            logarithmic_axis("missing force [-]", curves, 4),
                        ),
                        title=f"Missing force by {quantity} between {places}",
                    ),
                )
            )
    return drawings


def restoring_force(models: Models) -> list[PageFigure]:
    """Return the force in each joint over displacement and over velocity, each model's too."""
    index = loudest(models.before)
    drawings = []
    for joint in models.before.tests[index].joints:
        for by_velocity in (False, True):
            drawings += _forces(models, index, joint.between, by_velocity=by_velocity)
    return drawings


def _forces(
    models: Models, index: int, between: tuple[str, str], *, by_velocity: bool
) -> list[PageFigure]:
    clouds = [
        (text, style, cloud(motion, by_velocity=by_velocity))
        for text, style, c in models.each
        if (motion := same_joint(c.tests[index], between)) is not None
    ]
    clouds = [(text, style, rows) for text, style, rows in clouds if rows.size]
    if not clouds:  # no sample where the other is small: a motion that is no number
        return []
    limit = 1.05 * max(float(np.max(np.abs(rows[1:]))) for _, _, rows in clouds) or 1.0
    largest = max(float(np.max(np.abs(rows[0]))) for _, _, rows in clouds)
    test = models.before.tests[index]
    places = " and ".join(between)
    quantity, other, si = (
        ("velocity", "displacement", "m/s")
        if by_velocity
        else ("displacement", "velocity", "m")
    )
    model = models.before.model
    unit, factor = shown_in(si, model.motion, largest)
    reach = 1.02 * factor * largest or 1.0
    return [
        PageFigure(
            f"Force over {quantity} between {places}, {text}.",
            f"{capitalised(label(test))}, samples of little {other}. The grey dots are what "
            f"holds the mass, measured{_from(models, index, between)}: a straight line is "
            "linear, a kink is a gap, a step is friction.",
            to_svg.plot(
                Plot(
                    [
                        Curve("measured", factor * rows[0], rows[1], MEASURED, dots=True),
                        Curve(text, factor * rows[0], rows[2], style, dots=True),
                    ],
                    Axis(f"{quantity} [{unit}]", -reach, reach),
                    Axis(f"force [{model.unit_of('N')}]", -limit, limit),
                ),
                title=f"Restoring force over {quantity} between {places}, {text}",
                height=260,
            ),
        )
        for text, style, rows in clouds
    ]


def _from(models: Models, index: int, between: tuple[str, str]) -> str:
    """Return from which frequency on a joint is measured, in words."""
    joint = same_joint(models.before.tests[index], between)
    low = 0.0 if joint is None else joint.band[0]
    return f" from {numeral(low)} Hz on" if low > 0.0 else ""


def error_in_time(models: Models) -> list[PageFigure]:
    """Return the error of each sensor along the loudest test."""
    index = loudest(models.before)
    test = models.before.tests[index]
    drawings = []
    for sensor, name in enumerate(test.measured.sensors):
        curves = [
            Curve(text, time.time, time.error[sensor], style)
            for text, style, comparison in models.each
            for time in (comparison.tests[index].time,)
        ]
        end = max(float(c.x[-1]) for c in curves)
        drawings.append(
            PageFigure(
                f"{name}: error along {label(test)}.",
                "Level where the model is the same from start to end; a slope means that "
                "something drifts, such as a joint that loosens or warms.",
                to_svg.plot(
                    Plot(
                        curves,
                        Axis("time [s]", 0.0, 1.02 * end),
                        logarithmic_axis("error [-]", curves),
                    ),
                    title=f"Error of {name} along the loudest test",
                ),
            )
        )
    return drawings


def alternatives(diagnosis: Diagnosis) -> list[Tried]:
    """Return the candidates that were found or do as well, each kind and place once."""
    kinds = {e.kind for e in diagnosis.effects} | set(diagnosis.indistinguishable)
    alike: dict[tuple[str, tuple[str, ...]], Tried] = {}
    for tried in diagnosis.candidates:
        if tried.kind in kinds and effect_of(tried) is not None:
            alike.setdefault((tried.kind, tried.between), tried)
    return list(alike.values())[:MOST]


def effect_of(tried: Tried) -> AbstractEffect | None:
    """Return the effect with the numbers of a candidate; None for several at once."""
    made = EFFECTS.get(tried.kind)
    if made is None or not tried.parameters:
        return None
    known = made.estimated()
    needed = {name for name, parameter in known.items() if not parameter.optional}
    if needed - set(tried.parameters):
        return None
    return made.of_numbers({
        name: p.value for name, p in tried.parameters.items() if name in known
    })


def laws(models: Models, diagnosis: Diagnosis) -> PageFigure | None:
    """Return the force of each alternative over a cycle; None without any, or a joint."""
    chosen = alternatives(diagnosis)
    test = models.before.tests[loudest(models.before)]
    joint = next(
        (j for j in test.joints if chosen and set(j.between) == set(chosen[0].between)), None
    )
    if len(chosen) < 2 or joint is None:
        return None
    reach = float(np.max(np.abs(joint.displacement)))
    frequency = max(test.errors[0].peak_hz, 1.0)
    curves = []
    for style, tried in enumerate(chosen):
        effect = effect_of(tried)
        if effect is not None:
            z, force = forced_cycle(effect, BEYOND * reach, frequency)
            name = tried.kind.replace("_", " ")
            curves.append(Curve(name, z * 1e3, force, style, wide=style == 0))
    limit = 1.05 * max(float(np.max(np.abs(c.y))) for c in curves) or 1.0
    model = models.before.model
    unit, _ = shown_in("m", model.motion)
    edge, end = reach * 1e3, BEYOND * reach * 1e3
    return PageFigure(
        "Laws that explain these tests alike.",
        f"Force of the effect alone over a sine at {frequency:.0f} Hz; white is what the tests "
        "reached. Where the lines part in the grey, a louder test tells them apart; where they "
        "do not, another kind of test must.",
        to_svg.plot(
            Plot(
                curves,
                Axis(f"displacement [{unit}]", -end, end),
                Axis(f"force [{model.unit_of('N')}]", -limit, limit),
                spans=[Span(-end, -edge), Span(edge, end)],
            ),
            title="Laws of effects that explain the tests alike",
        ),
    )


def forced_cycle(
    effect: AbstractEffect, amplitude: float, frequency: float
) -> tuple[FloatArray, FloatArray]:
    """Return displacement [m] and force [N] over the last of several cycles of a sine."""
    angle = 2.0 * math.pi * (np.arange(_CYCLES * _SAMPLES) + 0.5) / _SAMPLES
    z = amplitude * np.sin(angle)
    speed = amplitude * 2.0 * math.pi * frequency * np.cos(angle)
    force = effect.force_along(z, speed, frequency * _SAMPLES)
    return z[-_SAMPLES:], force[-_SAMPLES:]


def hidden(diagnosis: Diagnosis, of: Motion) -> list[PageFigure]:
    """Return motion and force of joints that recordings do not tell, those of effects first."""
    effect_pairs = {frozenset(effect.between) for effect in diagnosis.effects}
    order = sorted(diagnosis.hidden, key=lambda one: frozenset(one.between) not in effect_pairs)
    return [
        _banded(joint, what, band, *shown_in(si, of, max(map(abs, band.value))))
        for joint in order[:MOST]
        for what, si, band in (
            ("displacement", "m", joint.displacement),
            ("force", "N", joint.force),
        )
    ]


def _banded(
    joint: HiddenJoint, what: str, band: Banded, unit: str, factor: float
) -> PageFigure:
    """Return samples of a joint within their band, times a factor in the unit of it."""
    x = np.array(joint.time)
    low, value, high = (factor * np.array(one) for one in (band.low, band.value, band.high))
    room = 0.05 * float(np.max(high) - np.min(low))
    places = " and ".join(joint.between)
    return PageFigure(
        f"{what.capitalize()} between {places}, test {joint.test}.",
        "As modes and laws of the model found tell it, about its largest motion. Thin lines: "
        "90 % of what tests and calibration leave open of the numbers. As large a share as the "
        "model leaves of the sensors is added.",
        to_svg.plot(
            Plot(
                [
                    Curve("90 %", x, low, NOISE, thin=True),
                    Curve("", x, high, NOISE, thin=True),
                    Curve(what, x, value, AFTER),
                ],
                Axis("time [s]", float(x[0]), float(x[-1])),
                Axis(f"{what} [{unit}]", float(np.min(low)) - room, float(np.max(high)) + room),
            ),
            title=f"Predicted {what} between {places}",
        ),
    )


_POINTS: Final = 200  # of a curve
_LINES: Final = 3  # of a law of displacement and velocity: the slowest, the middle, the fastest


def free_law(outside: Outside) -> PageFigure:
    """Return the missing force over displacement, or over velocity where it has that alone."""
    along_velocity = len(outside.displacement) == 1
    name, si, nodes = (
        ("velocity", "m/s", outside.velocity)
        if along_velocity
        else ("displacement", "m", outside.displacement)
    )
    unit, factor = shown_in(si, outside.motion)
    x = np.linspace(nodes[0], nodes[-1], _POINTS)
    curves = [
        Curve(text, x * factor, force, style, wide=style == 0)
        for style, (text, force) in enumerate(
            forces_along(outside, x, along_velocity=along_velocity)
        )
    ]
    limit = 1.05 * max(float(np.max(np.abs(curve.y))) for curve in curves) or 1.0
    return PageFigure(
        f"Force that the joint between {' and '.join(outside.between)} lacks.",
        "A smooth law without a name, fitted to the tests; thin lines hold it with 95 % "
        "probability where only one axis tells it. `shakerproc add table` writes it into the "
        "model, so that its error falls as long as no effect explains it.",
        to_svg.plot(
            Plot(
                curves,
                Axis(f"{name} [{unit}]", float(x[0]) * factor, float(x[-1]) * factor),
                Axis(f"force [{unit_in('N', outside.motion)}]", -limit, limit),
            ),
            title=f"Missing force over {name}",
        ),
    )


def forces_along(
    outside: Outside, x: FloatArray, *, along_velocity: bool
) -> list[tuple[str, FloatArray]]:
    """Return the curves [N] of a law over x [m] or [m/s] with names, its band on one axis."""
    known = Table(outside.displacement, outside.velocity, outside.force)
    if along_velocity:
        still = np.full_like(x, outside.displacement[0])
        force, band = known.force_at(still, x), np.array(outside.band)[0]
        return _with_band(force, np.interp(x, outside.velocity, band))
    if len(outside.velocity) == 1:
        force = known.force_at(x, np.full_like(x, outside.velocity[0]))
        band = np.array(outside.band)[:, 0]
        return _with_band(force, np.interp(x, outside.displacement, band))
    chosen = np.linspace(0, len(outside.velocity) - 1, _LINES).round().astype(int)
    speeds = [outside.velocity[i] for i in chosen]
    unit = unit_in("m/s", outside.motion)
    return [(f"at {numeral(v)} {unit}", known.force_at(x, np.full_like(x, v))) for v in speeds]


def _with_band(force: FloatArray, band: FloatArray) -> list[tuple[str, FloatArray]]:
    return [("missing force", force), ("lower end", force - band), ("upper end", force + band)]
