"""The models and tests whose evidence is shown, and a comparison drawn as files."""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison import Comparison, JointMotion, TestComparison
from shakerproc.data import FloatArray
from shakerproc.models.motion import shown_in, unit_in
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MEASURED, BEFORE, AFTER, NOISE = 7, 1, 0, 6
"""Styles: a broad grey line, a dashed one, a thin one, and the noise floor."""

SHOWN: Final = 4
"""Tests whose response functions are drawn, the levels spread out."""

DOTS: Final = 1500
"""Samples of a restoring force that are drawn."""

_NEAR: Final = 0.12  # of the largest velocity or displacement: what counts as none

_PARTS: Final = 60
"""Parts of a range, from each of which as many samples are drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Models:
    """A model compared with a campaign, and if there is one, its successor.

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
        """Noise of every test, through the better model, which a contact may amplify."""
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
        number = numeral(float(number), 4)
    return f"{number} {unit}".strip().replace("^2", "²")


def same_joint(test: TestComparison, between: tuple[str, str]) -> JointMotion | None:
    """Return force and motion of the joint between two places, in this direction."""
    for joint in test.joints:
        if joint.between == between:
            return joint
        if joint.between == between[::-1]:
            return replace(
                joint,
                between=between,
                displacement=-joint.displacement,
                velocity=-joint.velocity,
                force=-joint.force,
                force_model=-joint.force_model,
            )
    return None


def capitalised(text: str) -> str:
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


def unit_of_sensor(comparison: Comparison, sensor: str) -> str:
    """Return the unit of a response function of a sensor, over that of the drive."""
    unit = comparison.model.sensor_unit(comparison.model.sensors[sensor])
    drive = comparison.model.drive_unit
    over = "/".join(f"({one})" if "/" in one or " " in one else one for one in (unit, drive))
    return "-" if unit == drive else over.replace("^2", "²")


def deciding(comparison: Comparison) -> int:
    """Return the loudest test that was held out, or the loudest of all."""
    rising = by_input(comparison)
    kept = [i for i in rising if comparison.tests[i].measured.test.hold_out]
    return (kept or rising)[-1]


def loudest(comparison: Comparison) -> int:
    """Return the test with the largest input."""
    return by_input(comparison)[-1]


def evenly(values: FloatArray, count: int) -> NDArray[np.int_]:
    """Return indices of about so many samples, as many from each part of the range."""
    limits = np.linspace(values.min(), values.max(), _PARTS + 1)
    which = np.clip(np.searchsorted(limits, values) - 1, 0, _PARTS - 1)
    chosen = []
    for part in range(_PARTS):
        inside = np.flatnonzero(which == part)
        chosen.append(inside[:: max(1, inside.size * _PARTS // count)])
    return np.concatenate(chosen)


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
    chosen = evenly(along[near], DOTS)
    rows = [along[near][chosen]]
    for force in (motion.force[near], motion.force_model[near]):
        slope = float(np.linalg.lstsq(columns, force, rcond=None)[0][0])
        rows.append(force[chosen] - slope * other[near][chosen])
    return np.array(rows)


def draw_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Draw every figure that a comparison has, and return the files."""
    written = []
    for name, draw in figures_of(comparison).items():
        with style.look():
            written.append(save(draw(), folder / f"{_file_name(name)}.png"))
    return written


def _file_name(text: str) -> str:
    """Return a name that every file system takes: letters, digits and underscores."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in text)


def figures_of(comparison: Comparison) -> dict[str, "Callable[[], Figure]"]:
    """Return the figures that can be drawn, by the name of their file."""
    out: dict[str, Callable[[], Figure]] = {}
    for i, sensor in enumerate(comparison.tests[0].measured.sensors):
        out[f"response_{sensor}"] = partial(response_functions, comparison, i)
        out[f"error_map_{sensor}"] = partial(error_map, comparison, i)
    for k, joint in enumerate(comparison.tests[loudest(comparison)].joints):
        name = "_".join(joint.between)
        out[f"restoring_force_{name}"] = partial(restoring_force, comparison, k)
    out["error_in_time"] = partial(error_in_time, comparison)
    if any(test.harmonics is not None for test in comparison.tests):
        out["harmonics"] = partial(harmonics, comparison)
    return out


def response_functions(comparison: Comparison, sensor: int) -> "Figure":
    """Return measured and predicted response functions overlaid, and the coherence."""
    figure, (upper, lower) = style.figure(7.0, 5.2, 2, sharex=True)
    for k, test in enumerate(comparison.tests[i] for i in spread_out(comparison)):
        pair = test.pair
        f, lit = pair.frequency, pair.excited
        upper.plot(f[lit], np.abs(pair.h1[sensor, lit]), **_solid(k), label=label(test))
        upper.plot(f[lit], np.abs(pair.h1_model[sensor, lit]), **_dashed(k))
        lower.plot(f[lit], pair.coherence[sensor, lit], **_solid(k))
        lower.plot(f[lit], pair.coherence_model[sensor, lit], **_dashed(k))
    upper.plot([], [], color="#444444", linestyle="--", linewidth=1.0, label="model")
    upper.set_xscale("log")
    upper.set_yscale("log")
    _plain_frequencies(lower)
    first = comparison.tests[0].measured
    name = first.sensors[sensor]
    upper.set_title(f"{name}: measured (solid) and {comparison.model.title} (dashed)")
    upper.set_ylabel(f"response function H1 [{unit_of_sensor(comparison, name)}]")
    lower.set_ylabel("coherence [-]")
    lower.set_ylim(-0.03, 1.03)
    lower.set_xlabel("frequency [Hz]")
    upper.legend(loc="best")
    return figure


def _solid(k: int) -> dict[str, Any]:
    return {"color": style.COLOURS[k % 6], "linestyle": "-", "linewidth": 1.1}


def _dashed(k: int) -> dict[str, Any]:
    return {"color": style.COLOURS[k % 6], "linestyle": (0, (4, 2)), "linewidth": 1.1}


def _plain_frequencies(axis: "Axes") -> None:
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(ScalarFormatter())
    axis.xaxis.set_minor_formatter(NullFormatter())


def error_map(comparison: Comparison, sensor: int) -> "Figure":
    """Return the error of each test in each band, the loudest test on top."""
    from matplotlib.colors import LogNorm

    tests = by_input(comparison)
    bands = comparison.bands
    columns = np.flatnonzero(bands.driven.any(axis=0))
    shown = slice(columns[0], columns[-1] + 1)
    edges = bands.edges[columns[0] : columns[-1] + 2]
    error = np.where(bands.driven[tests, shown], bands.error[tests, sensor, shown], np.nan)
    height = min(7.0, 1.3 + 0.42 * len(tests))
    figure, (axis,) = style.figure(8.6, height)
    rows = np.arange(len(tests) + 1)
    mesh = axis.pcolormesh(
        edges,
        rows,
        np.maximum(error, 1e-3),
        norm=LogNorm(1e-3, 2.0),
        cmap="cividis",
        shading="flat",
    )
    if len(tests) <= 12:
        _write_cells(axis, edges, error, bands.share[tests, sensor, shown])
    axis.set_xscale("log")
    _plain_frequencies(axis)
    axis.set_xlim(edges[0], edges[-1])
    axis.set_yticks(rows[:-1] + 0.5, [label(comparison.tests[i]) for i in tests])
    axis.grid(visible=False)
    axis.set_xlabel("frequency [Hz]")
    name = comparison.tests[0].measured.sensors[sensor]
    axis.set_title(
        f"{name}: unexplained over measured rms by driven third octave [%] (bold: most)"
    )
    bar = figure.colorbar(mesh, ax=axis, pad=0.02, label="error [%]", extend="both")
    bar.ax.yaxis.set_major_formatter(lambda value, _: f"{100.0 * value:g}")
    return figure


def _write_cells(axis: "Axes", edges: FloatArray, error: FloatArray, share: FloatArray) -> None:
    """Write the error in per cent into each cell, bold where a fifth of the error lies."""
    middle = np.sqrt(edges[1:] * edges[:-1])
    for row, values in enumerate(error):
        for column, value in enumerate(values):
            if np.isfinite(value):
                axis.text(
                    middle[column], row + 0.5, _per_cent(value),
                    ha="center", va="center", fontsize=5.5,
                    weight="bold" if share[row, column] > 0.2 else "normal",
                    color="white" if value < 0.15 else "black",
                )  # fmt: skip


def _per_cent(value: float) -> str:
    if value < 5e-4:
        return "<0.1"
    return f"{100.0 * value:.1f}" if value < 0.0095 else f"{100.0 * value:.0f}"


def restoring_force(comparison: Comparison, joint: int) -> "Figure":
    """Return measured and modelled force of a joint against displacement and velocity."""
    test = comparison.tests[loudest(comparison)]
    motion = test.joints[joint]
    figure, (upper, lower) = style.figure(7.0, 6.4, 2)
    way = comparison.model.motion
    unit, factor = shown_in("m", way, float(np.max(np.abs(motion.displacement))))
    _scatter(upper, motion, by_velocity=False, factor=factor)
    _scatter(lower, motion, by_velocity=True, factor=1.0)
    places = " to ".join(motion.between)
    upper.set_title(f"{places}, {label(test)}: where the velocity is small")
    upper.set_xlabel(f"displacement [{unit}]")
    lower.set_title("where the displacement is small")
    lower.set_xlabel(f"velocity [{unit_in('m/s', way)}]")
    for axis in (upper, lower):
        axis.set_ylabel(f"force [{unit_in('N', way)}]")
    upper.legend(loc="upper left", markerscale=3.0)
    return figure


def _scatter(axis: "Axes", motion: JointMotion, *, by_velocity: bool, factor: float) -> None:
    """Draw measured and modelled force over a motion in the unit of the axis."""
    along, *forces = cloud(motion, by_velocity=by_velocity)
    for number, (text, force) in enumerate(zip(("measured", "model"), forces, strict=True)):
        axis.plot(
            factor * along, force, ".", markersize=1.6,
            color=style.COLOURS[number], label=text, rasterized=True,
        )  # fmt: skip


def error_in_time(comparison: Comparison) -> "Figure":
    """Return the error along each test, and its noise floor."""
    figure, (axis,) = style.figure(7.0, 3.6)
    for k, test in enumerate(comparison.tests[i] for i in spread_out(comparison)):
        for row in test.time.error:
            axis.plot(test.time.time, row, **_solid(k), marker=".")
        axis.plot([], [], **_solid(k), label=label(test))
        if np.isfinite(test.noise) and test.noise > 0.0:
            axis.axhline(test.noise, color=style.COLOURS[k % 6], linestyle=":", linewidth=0.9)
    axis.set_yscale("log")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("unexplained / measured [-]")
    axis.set_title("Error along the test, a line for each sensor (dotted: noise of all)")
    axis.legend(loc="best")
    return figure


def harmonics(comparison: Comparison) -> "Figure":
    """Return harmonics measured and predicted, for the loudest test that has tones."""
    tests = [comparison.tests[i] for i in by_input(comparison)]
    test = [test for test in tests if test.harmonics is not None][-1]
    test_harmonics = test.harmonics or ()
    figure, axes = style.figure(
        7.0, 1.2 + 2.0 * len(test_harmonics), len(test_harmonics), sharex=True
    )
    for axis, name, h in zip(axes, test.measured.sensors, test_harmonics, strict=True):
        _bars(axis, [h.measured, h.predicted, h.error])
        axis.set_ylabel(f"{name} [-]")
        axis.set_yscale("log")
        tallest = max(float(np.nanmax(row)) for row in (h.measured, h.predicted, h.error))
        axis.set_ylim(1e-4, 2.0 * max(1.0, tallest))
    axes[0].set_title(f"{label(test)}: amplitude over the measured fundamental")
    axes[0].legend(loc="upper right")
    axes[-1].set_xlabel("harmonic order")
    return figure


def _bars(axis: "Axes", rows: Sequence[FloatArray]) -> None:
    order = np.arange(1, rows[0].size + 1)
    for k, (row, text) in enumerate(zip(rows, ("measured", "model", "error"), strict=True)):
        shown = np.maximum(row, 1e-6)
        axis.bar(order + 0.26 * (k - 1), shown, 0.24, color=style.COLOURS[k], label=text)
    axis.set_xticks(order)
    axis.set_axisbelow(True)
