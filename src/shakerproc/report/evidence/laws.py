"""Laws of force drawn: those that explain the tests equally well, and one without a name."""

import math
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.joint_outcomes import Outside
from shakerproc.diagnosis.result import Diagnosis, Tried
from shakerproc.models import EFFECTS
from shakerproc.models.effects import Table
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.models.motion import shown_in, unit_in
from shakerproc.numerals import numeral
from shakerproc.report.evidence.models import Models, loudest
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot, Span
from shakerproc.report.page.sections import PageFigure

BEYOND: Final = 1.5
"""How far the drawing goes, as a multiple of the largest motion that was measured [-]."""

MOST: Final = 4
"""Laws in one drawing."""

_SAMPLES: Final = 400  # of a cycle
_CYCLES: Final = 4  # until the memory of a law has settled


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
