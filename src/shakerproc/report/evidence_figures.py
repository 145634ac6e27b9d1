"""What speaks for a missing effect, drawn: measured against the model before and after."""

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison import Comparison, JointMotion, TestComparison, by_range
from shakerproc.comparison.sensors import UNIT_OF
from shakerproc.data import STANDARD_GRAVITY, ComplexArray, FloatArray
from shakerproc.report import svg
from shakerproc.report.drawing import Drawing
from shakerproc.report.heat_map import heat_map
from shakerproc.report.run_curves import logarithmic_axis

MEASURED, BEFORE, AFTER, NOISE = 7, 1, 0, 6
"""Styles: a broad grey line, a dashed one, a thin one, and the noise floor."""

SHOWN: Final = 4
"""Tests whose response functions are drawn, the levels spread out."""

HEARD: Final = 0.1
"""Coherence below which a phase is noise and is left out [-]."""

DOTS: Final = 1500
"""Samples of a restoring force that are drawn."""

MOST_BINS: Final = 600
"""Bins of a response function that are drawn."""

_NEAR: Final = 0.12  # of the largest velocity or displacement: what counts as none
_PARTS: Final = 60  # of a range, from each of which as many samples are drawn


@dataclass(frozen=True, slots=True, eq=False)
class Models:
    """A model held against a campaign, and if there is one, its successor.

    Attributes
    ----------
    before : Comparison
        With the model as it was.
    after : Comparison, optional
        With the new one, against the same tests.
    old, new : str
        What the two are called.
    """

    before: Comparison
    after: Comparison | None = None
    old: str = "model as it was"
    new: str = "new model"

    @property
    def each(self) -> list[tuple[str, int, Comparison]]:
        """Name, style and comparison of each model."""
        both = [(self.old, BEFORE, self.before)]
        return both if self.after is None else [*both, (self.new, AFTER, self.after)]

    @property
    def noise(self) -> list[float]:
        """Noise of every test, through the better model: what a contact makes of it counts."""
        return [test.noise for test in (self.after or self.before).tests]


def label(test: TestComparison) -> str:
    """Return number and level of a test, and whether it was held out."""
    level = level_of(test)
    kept = ", held out" if test.measured.test.hold_out else ""
    return f"test {test.measured.name}{f', {level}' if level else ''}{kept}"


def level_of(test: TestComparison) -> str:
    """Return the level of a test as the log has it, in four digits at most."""
    number, _, unit = test.measured.test.level_text.partition(" ")
    with contextlib.suppress(ValueError):
        number = f"{float(number):.4g}"
    return f"{number} {unit}".strip().replace("^2", "²")


def same_joint(test: TestComparison, between: tuple[str, str]) -> JointMotion | None:
    """Return force and motion of the joint between two places, in this direction."""
    for joint in test.joints:
        if joint.between == between:
            return joint
        if joint.between == between[::-1]:
            return JointMotion(
                between, -joint.displacement, -joint.velocity, -joint.force, -joint.force_model
            )
    return None


def _opened(text: str) -> str:
    """Return text as the start of a sentence."""
    return f"{text[0].upper()}{text[1:]}"


def by_input(comparison: Comparison) -> list[int]:
    """Return the tests from the smallest input to the largest."""
    return sorted(range(len(comparison.tests)), key=lambda i: input_rms(comparison, i))


def input_rms(comparison: Comparison, index: int) -> float:
    """Return the rms of the input of a test [m/s^2 or N]."""
    return float(np.sqrt(np.mean(comparison.tests[index].prediction.input ** 2)))


def spread_out(comparison: Comparison) -> list[int]:
    """Return a few tests from the quietest to the loudest, one held out among them."""
    rising = by_input(comparison)
    if len(rising) <= SHOWN:
        return rising
    chosen = [rising[round(i)] for i in np.linspace(0, len(rising) - 1, SHOWN)]
    kept = [i for i in rising if comparison.tests[i].measured.test.hold_out]
    if kept and not set(kept) & set(chosen):
        chosen[2] = kept[len(kept) // 2]
    return chosen


def responses(models: Models) -> list[Drawing]:
    """Return magnitude, phase and coherence of each sensor in a few tests."""
    sensors = models.before.tests[0].measured.sensors
    return [
        _response(models, index, sensor)
        for sensor in range(len(sensors))
        for index in spread_out(models.before)
    ]


def _response(models: Models, index: int, sensor: int) -> Drawing:
    test = models.before.tests[index]
    name = test.measured.sensors[sensor]
    own = test.pair
    frequency, pick = picked(own.frequency, own.excited)
    heights, phases, coherences = [], [], []
    rows = [("measured", MEASURED, own.h1[sensor], own.coherence[sensor])] + [
        (text, style, c.tests[index].pair.h1_model[sensor],
         c.tests[index].pair.coherence_model[sensor])
        for text, style, c in models.each
    ]  # fmt: skip
    lowest = _lowest_phase(own.h1[sensor][pick], own.coherence[sensor][pick])
    for text, style, whole, whole_coherence in rows:
        h1, coherence = whole[pick], whole_coherence[pick]
        wide = style == MEASURED
        heights.append(svg.Curve(text, frequency, np.abs(h1), style, wide=wide))
        phase = _phase(h1, coherence, lowest)
        phases.append(svg.Curve(text, frequency, phase, style, wide=wide))
        coherences.append(svg.Curve(text, frequency, coherence, style, wide=wide))
    x_axis = svg.Axis("", 0.0, float(frequency[-1]))
    turn = svg.Axis("phase [°]", lowest, lowest + 360.0, degrees=True)
    below = svg.Axis("frequency [Hz]", 0.0, float(frequency[-1]))
    title = f"{name}, {label(test)}"
    error = "; ".join(
        f"{text} leaves {c.tests[index].errors[sensor].error:.1%}" for text, _, c in models.each
    )
    return Drawing(
        f"{name}, {label(test)}.",
        f"{_opened(error)}.",
        svg.plot(
            heights,
            x_axis,
            logarithmic_axis(f"|H1| [{_unit(models.before, name)}]", heights, 5),
            title=f"Response function of {title}",
            height=210,
            keys=False,
        )
        + svg.plot(
            phases,
            x_axis,
            turn,
            title=f"Phase of {title}",
            height=130,
            keys=False,
        )
        + svg.plot(
            coherences,
            below,
            svg.Axis("coherence [-]", 0.0, 1.0),
            title=f"Coherence of {title}",
            height=150,
        ),
    )


def picked(
    frequency: FloatArray, excited: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.int_]]:
    """Return the excited bins that are drawn, and their numbers."""
    inside = np.flatnonzero(excited)
    step = max(1, -(-inside.size // MOST_BINS))
    return frequency[inside[::step]], inside[::step]


def _phase(h1: ComplexArray, coherence: FloatArray, lowest: float) -> FloatArray:
    """Return the phase in degrees, broken where it is noise or jumps round the circle."""
    phase = (np.degrees(np.angle(h1)) - lowest) % 360.0 + lowest
    out = np.where(coherence > HEARD, phase, np.nan)
    out[1:][np.abs(np.diff(phase)) > 180.0] = np.nan
    return out


def _lowest_phase(h1: ComplexArray, coherence: FloatArray) -> float:
    """Return the angle to cut the circle at, so that the measured phase jumps least [°]."""
    clear = np.degrees(np.angle(h1[coherence > 0.5]))
    jumps = {
        lowest: np.sum(np.abs(np.diff((clear - lowest) % 360.0)) > 180.0)
        for lowest in (-180.0, -270.0, -90.0)
    }
    return min(jumps, key=lambda lowest: jumps[lowest])


def _unit(comparison: Comparison, sensor: str) -> str:
    unit = UNIT_OF[comparison.model.sensors[sensor].measures]
    drive = comparison.model.excitation.unit
    return "-" if unit == drive else f"{unit} / ({drive})".replace("^2", "²")


def error_maps(models: Models) -> list[Drawing]:
    """Return the error of each test in each third octave, before and after."""
    drawings = []
    for sensor, name in enumerate(models.before.tests[0].measured.sensors):
        for text, _, comparison in models.each:
            rows = by_input(comparison)[::-1]
            bands = comparison.bands
            drawings.append(
                Drawing(
                    f"{name}: error by band and level, {text} [%].",
                    "Loudest test on top; bold: where a fifth of the error and more lies. "
                    "An error that grows upwards depends on amplitude.",
                    heat_map(
                        [label(comparison.tests[i]) for i in rows],
                        bands.edges,
                        bands.error[rows, sensor],
                        bands.share[rows, sensor] > 0.2,
                        title=f"Error of {name} by third octave, {text}",
                    ),
                    broad=True,
                )
            )
    return drawings


def error_by_band(models: Models) -> list[Drawing]:
    """Return the error over frequency in the test that counts most, with the noise."""
    index = deciding(models.before)
    test = models.before.tests[index]
    drawings = []
    for sensor, name in enumerate(test.measured.sensors):
        edges = models.before.bands.edges
        curves = [
            _stairs(text, edges, c.bands.error[index, sensor], style)
            for text, style, c in models.each
        ]
        floor = models.before.bands.floor[index, sensor]
        if np.any(np.isfinite(floor) & (floor > 0.0)):
            curves.append(_stairs("noise", edges, floor, NOISE, thin=True))
        drawings.append(
            Drawing(
                f"{name}, {label(test)}: error by band.",
                "Unexplained over measured rms in each third octave. A good model comes down "
                "to the noise wherever there is response.",
                svg.plot(
                    curves,
                    svg.Axis(
                        "frequency [Hz]", float(edges[0]), float(edges[-1]), logarithmic=True
                    ),
                    logarithmic_axis("error [-]", curves, 5),
                    title=f"Error of {name} by third octave",
                ),
            )
        )
    return drawings


def _stairs(
    text: str, edges: FloatArray, values: FloatArray, style: int, *, thin: bool = False
) -> svg.Curve:
    """Return a value over each band, so that its width is seen."""
    values = np.where(values > 0.0, values, np.nan)
    return svg.Curve(text, np.repeat(edges, 2)[1:-1], np.repeat(values, 2), style, thin=thin)


def deciding(comparison: Comparison) -> int:
    """Return the loudest test that was held out, or the loudest of all."""
    rising = by_input(comparison)
    kept = [i for i in rising if comparison.tests[i].measured.test.hold_out]
    return (kept or rising)[-1]


def error_by_level(models: Models) -> Drawing:
    """Return the error of every test over its input."""
    rising = by_input(models.before)
    kept = [models.before.tests[i].measured.test.hold_out for i in rising]
    by_force = models.before.model.excitation.on is not None
    unit, factor = ("N", 1.0) if by_force else ("g", 1.0 / STANDARD_GRAVITY)
    x = np.array([input_rms(models.before, i) for i in rising]) * factor
    curves = []
    for text, style, comparison in models.each:
        y = np.array([comparison.tests[i].error for i in rising])
        curves.append(svg.Curve("", x, y, style, thin=True))
        curves.append(svg.Curve(text, x, y, style, points=True, hollow=kept))
    noise = np.array([models.noise[i] for i in rising])
    if np.any(np.isfinite(noise) & (noise > 0.0)):
        noise = np.where(noise > 0.0, noise, np.nan)
        curves.append(svg.Curve("noise", x, noise, NOISE, thin=True))
    return Drawing(
        "Error by level.",
        "Each mark is a test; hollow: held out. What rises with the level depends on "
        "amplitude; what falls is friction or noise.",
        svg.plot(
            curves,
            _around(f"measured input, rms [{unit}]", x),
            logarithmic_axis("error [-]", curves, 5),
            title="Error of every test over its input",
        ),
    )


def _around(text: str, x: FloatArray) -> svg.Axis:
    """Return a logarithmic axis with room to both sides."""
    low, high = float(x.min()), float(x.max())
    if not low > 0.0:
        return svg.Axis(text, 0.0, 1.1 * high or 1.0)
    return svg.Axis(text, 0.8 * low, 1.25 * high, logarithmic=True)


def loudest(comparison: Comparison) -> int:
    """Return the test with the largest input."""
    return by_input(comparison)[-1]


def error_by_motion(models: Models) -> list[Drawing]:
    """Return the missing force over displacement and velocity in the loudest test."""
    index = loudest(models.before)
    test = models.before.tests[index]
    drawings = []
    for joint in test.joints:
        places = " and ".join(joint.between)
        for by_velocity, quantity, unit, factor in (
            (False, "displacement", "mm", 1e3),
            (True, "velocity", "m/s", 1.0),
        ):
            curves = []
            for text, style, comparison in models.each:
                motion = same_joint(comparison.tests[index], joint.between)
                if motion is None:
                    continue
                found = by_range(
                    motion, motion.velocity if by_velocity else motion.displacement
                )
                curves.append(svg.Curve(text, found.centre * factor, found.error, style))
            reach = max(float(np.max(np.abs(c.x))) for c in curves) * 1.05
            drawings.append(
                Drawing(
                    f"Error by {quantity}, between {places}.",
                    f"{_opened(label(test))}: rms of the force that the model lacks in "
                    f"each range, over the rms force of the test. Look where it begins.",
                    svg.plot(
                        curves,
                        svg.Axis(f"{quantity} [{unit}]", -reach, reach),
                        logarithmic_axis("missing force [-]", curves, 4),
                        title=f"Missing force by {quantity} between {places}",
                    ),
                )
            )
    return drawings


def restoring_force(models: Models) -> list[Drawing]:
    """Return the force in each joint over displacement and over velocity, each model's too."""
    index = loudest(models.before)
    drawings = []
    for joint in models.before.tests[index].joints:
        for by_velocity in (False, True):
            drawings += _forces(models, index, joint.between, by_velocity=by_velocity)
    return drawings


def _forces(
    models: Models, index: int, between: tuple[str, str], *, by_velocity: bool
) -> list[Drawing]:
    shown = np.array([[1.0 if by_velocity else 1e3], [1.0], [1.0]])
    clouds = [
        (text, style, shown * cloud(motion, by_velocity=by_velocity))
        for text, style, c in models.each
        if (motion := same_joint(c.tests[index], between)) is not None
    ]
    clouds = [(text, style, rows) for text, style, rows in clouds if rows.size]
    if not clouds:  # no sample where the other is small: a motion that is no number
        return []
    limit = 1.05 * max(float(np.max(np.abs(rows[1:]))) for _, _, rows in clouds) or 1.0
    reach = 1.02 * max(float(np.max(np.abs(rows[0]))) for _, _, rows in clouds) or 1.0
    test = models.before.tests[index]
    places = " and ".join(between)
    quantity, other, unit = (
        ("velocity", "displacement", "m/s")
        if by_velocity
        else ("displacement", "velocity", "mm")
    )
    return [
        Drawing(
            f"Force over {quantity} between {places}, {text}.",
            f"{_opened(label(test))}, samples of little {other}. The grey dots are what "
            "holds the mass: a straight line is linear, a kink is a gap, a step is friction.",
            svg.plot(
                [
                    svg.Curve("measured", rows[0], rows[1], MEASURED, dots=True),
                    svg.Curve(text, rows[0], rows[2], style, dots=True),
                ],
                svg.Axis(f"{quantity} [{unit}]", -reach, reach),
                svg.Axis("force [N]", -limit, limit),
                title=f"Restoring force over {quantity} between {places}, {text}",
                height=260,
            ),
        )
        for text, style, rows in clouds
    ]


def cloud(motion: JointMotion, *, by_velocity: bool) -> FloatArray:
    """Return motion [m or m/s], measured and modelled force [N] where the other is small.

    What that small part adds is a straight line through the samples, and is taken away:
    else the spring would hide what depends on the velocity.
    """
    along, other = motion.displacement, motion.velocity
    if by_velocity:
        along, other = other, along
    near = np.flatnonzero(np.abs(other) <= _NEAR * np.max(np.abs(other)))
    if not near.size:
        return np.empty((3, 0))
    columns = np.array([other[near], along[near]]).T
    chosen = _evenly(along[near], DOTS)
    rows = [along[near][chosen]]
    for force in (motion.force[near], motion.force_model[near]):
        slope = float(np.linalg.lstsq(columns, force, rcond=None)[0][0])
        rows.append(force[chosen] - slope * other[near][chosen])
    return np.array(rows)


def _evenly(values: FloatArray, count: int) -> NDArray[np.int_]:
    """Return numbers of about so many samples, as many from each part of the range."""
    limits = np.linspace(values.min(), values.max(), _PARTS + 1)
    which = np.clip(np.searchsorted(limits, values) - 1, 0, _PARTS - 1)
    chosen = []
    for part in range(_PARTS):
        inside = np.flatnonzero(which == part)
        chosen.append(inside[:: max(1, inside.size * _PARTS // count)])
    return np.concatenate(chosen)


def error_in_time(models: Models) -> Drawing:
    """Return the error along the loudest test."""
    index = loudest(models.before)
    curves = [
        svg.Curve(text if i == 0 else "", time.time, row, style)
        for text, style, comparison in models.each
        for time in (comparison.tests[index].time,)
        for i, row in enumerate(time.error)
    ]
    end = max(float(c.x[-1]) for c in curves)
    return Drawing(
        f"Error along {label(models.before.tests[index])}.",
        "Level where the model is the same from start to end; a slope means that something "
        "drifts, such as a joint that loosens or warms.",
        svg.plot(
            curves,
            svg.Axis("time [s]", 0.0, 1.02 * end),
            logarithmic_axis("error [-]", curves, 5),
            title="Error along the loudest test",
        ),
    )


def harmonics(models: Models) -> list[Drawing]:
    """Return the harmonics of the loudest test that has tones."""
    tonal = [i for i in by_input(models.before) if models.before.tests[i].harmonics is not None]
    if not tonal:
        return []
    index = tonal[-1]
    test = models.before.tests[index]
    drawings = []
    for sensor, name in enumerate(test.measured.sensors):
        found = [(text, style, c.tests[index].harmonics) for text, style, c in models.each]
        rows = [(text, style, h[sensor].predicted) for text, style, h in found if h is not None]
        first = (test.harmonics or ())[sensor]
        rows.insert(0, ("measured", MEASURED, first.measured))
        curves = _beside(rows)
        names = {float(order): str(order) for order in range(1, first.measured.size + 1)}
        drawings.append(
            Drawing(
                f"{name}, {label(test)}: harmonics.",
                "Amplitude over the measured fundamental: odd orders alone mean a law that is "
                "the same on both sides, even ones that it is not.",
                svg.plot(
                    curves,
                    svg.Axis("harmonic order [-]", 0.5, first.measured.size + 0.5),
                    logarithmic_axis("amplitude [-]", curves, 5),
                    title=f"Harmonics of {name}",
                    names=names,
                ),
            )
        )
    return drawings


def _beside(rows: Sequence[tuple[str, int, FloatArray]]) -> list[svg.Curve]:
    """Return values over their order, those of one order beside each other."""
    return [
        svg.Curve(
            text,
            np.arange(1.0, values.size + 1.0) + 0.14 * (i - (len(rows) - 1) / 2),
            np.where(values > 1e-6, values, np.nan),
            style,
            points=True,
        )
        for i, (text, style, values) in enumerate(rows)
    ]
