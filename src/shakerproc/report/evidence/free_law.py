"""The force that no effect of the library has, drawn as the tests tell it."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.joint_outcomes import Outside
from shakerproc.models.effects import Table
from shakerproc.models.motion import shown_in, unit_in
from shakerproc.numerals import numeral
from shakerproc.report.figures import to_svg
from shakerproc.report.page.drawing import Drawing

_POINTS: Final = 200  # of a curve
_LINES: Final = 3  # of a law of displacement and velocity: the slowest, the middle, the fastest


def free_law(outside: Outside) -> Drawing:
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
        to_svg.Curve(text, x * factor, force, style, wide=style == 0)
        for style, (text, force) in enumerate(
            forces_along(outside, x, along_velocity=along_velocity)
        )
    ]
    limit = 1.05 * max(float(np.max(np.abs(curve.y))) for curve in curves) or 1.0
    return Drawing(
        f"Force that the joint between {' and '.join(outside.between)} lacks.",
        "A smooth law without a name, fitted to the tests; thin lines hold it with 95 % "
        "probability where only one axis tells it. `shakerproc add table` writes it into the "
        "model, so that its error falls as long as no effect explains it.",
        to_svg.plot(
            to_svg.Plot(
                curves,
                to_svg.Axis(f"{name} [{unit}]", float(x[0]) * factor, float(x[-1]) * factor),
                to_svg.Axis(f"force [{unit_in('N', outside.motion)}]", -limit, limit),
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
