"""Where a model fails, drawn: response functions, error map, restoring force, error in time."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from shakerproc.comparison import Comparison, JointMotion, TestComparison
from shakerproc.data import FloatArray
from shakerproc.models.motion import shown_in, unit_in
from shakerproc.report.evidence.models import evenly, unit_of_sensor
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN: Final = 4
"""Tests that are overlaid, the levels spread out."""

DOTS: Final = 3000
"""Samples of a restoring force that are drawn."""

_NEAR: Final = 0.12  # of the largest velocity or displacement: what counts as none


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
    for k, joint in enumerate(loudest(comparison).joints):
        name = "_".join(joint.between)
        out[f"restoring_force_{name}"] = partial(restoring_force, comparison, k)
    out["error_in_time"] = partial(error_in_time, comparison)
    if any(test.harmonics is not None for test in comparison.tests):
        out["harmonics"] = partial(harmonics, comparison)
    return out


def loudest(comparison: Comparison) -> TestComparison:
    """Return the test with the largest input."""
    return max(comparison.tests, key=lambda test: float(np.mean(test.prediction.input**2)))


def spread_out(comparison: Comparison) -> list[TestComparison]:
    """Return a few tests from the quietest to the loudest."""
    rising = sorted(comparison.tests, key=lambda t: float(np.mean(t.prediction.input**2)))
    if len(rising) <= SHOWN:
        return rising
    return [rising[round(i)] for i in np.linspace(0, len(rising) - 1, SHOWN)]


def label(test: TestComparison) -> str:
    """Return number and level of a test, and whether it was held out."""
    kept = ", held out" if test.measured.test.hold_out else ""
    level = test.measured.test.level_text
    return f"test {test.measured.name}{f', {level}' if level else ''}{kept}".replace("^2", "²")


def response_functions(comparison: Comparison, sensor: int) -> "Figure":
    """Return measured and predicted response functions overlaid, and the coherence."""
    figure, (upper, lower) = style.figure(7.0, 5.2, 2, sharex=True)
    tests = spread_out(comparison)
    for k, test in enumerate(tests):
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

    tests = sorted(
        range(len(comparison.tests)),
        key=lambda i: float(np.mean(comparison.tests[i].prediction.input ** 2)),
    )
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
    test = loudest(comparison)
    motion = test.joints[joint]
    figure, (upper, lower) = style.figure(7.0, 6.4, 2)
    way = comparison.model.motion
    unit, factor = shown_in("m", way, float(np.max(np.abs(motion.displacement))))
    _scatter(upper, motion, motion.displacement * factor, motion.velocity)
    _scatter(lower, motion, motion.velocity, motion.displacement)
    places = " to ".join(motion.between)
    upper.set_title(f"{places}, {label(test)}: where the velocity is small")
    upper.set_xlabel(f"displacement [{unit}]")
    lower.set_title("where the displacement is small")
    lower.set_xlabel(f"velocity [{unit_in('m/s', way)}]")
    for axis in (upper, lower):
        axis.set_ylabel(f"force [{unit_in('N', way)}]")
    upper.legend(loc="upper left", markerscale=3.0)
    return figure


def _scatter(axis: "Axes", motion: JointMotion, along: FloatArray, other: FloatArray) -> None:
    """Draw the samples where the other variable is near 0, its small part taken away.

    That part is a straight line through the drawn samples; without it, the spring would hide
    what depends on the velocity.
    """
    near = np.flatnonzero(np.abs(other) < _NEAR * np.max(np.abs(other)))
    picked = near[evenly(along[near], DOTS)]
    for values, number, text in (
        (motion.force, 0, "measured"),
        (motion.force_model, 1, "model"),
    ):
        columns = np.array([other[near], along[near]]).T
        slope = float(np.linalg.lstsq(columns, values[near], rcond=None)[0][0])
        axis.plot(
            along[picked], values[picked] - slope * other[picked], ".", markersize=1.6,
            color=style.COLOURS[number], label=text, rasterized=True,
        )  # fmt: skip


def error_in_time(comparison: Comparison) -> "Figure":
    """Return the error along each test, and its noise floor."""
    figure, (axis,) = style.figure(7.0, 3.6)
    for k, test in enumerate(spread_out(comparison)):
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
    tonal = [test for test in comparison.tests if test.harmonics is not None]
    test = max(tonal, key=lambda t: float(np.mean(t.prediction.input**2)))
    found = test.harmonics or ()
    figure, axes = style.figure(7.0, 1.2 + 2.0 * len(found), len(found), sharex=True)
    for axis, name, h in zip(axes, test.measured.sensors, found, strict=True):
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
