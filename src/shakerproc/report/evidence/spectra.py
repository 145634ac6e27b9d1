"""Measured against the models in frequency: responses, error by band, harmonics."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.report.evidence.comparison import (
    MEASURED,
    NOISE,
    Models,
    by_input,
    capitalised,
    deciding,
    label,
    spread_out,
    unit_of_sensor,
)
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.runs.in_units import logarithmic_axis

HEARD: Final = 0.1
"""Coherence below which a phase is noise and is left out [-]."""

MOST_BINS: Final = 600
"""Bins of a response function that are drawn."""


def responses(models: Models) -> list[PageFigure]:
    """Return magnitude, phase and coherence of each sensor in a few tests."""
    sensors = models.before.tests[0].measured.sensors
    return [
        _response(models, index, sensor)
        for sensor in range(len(sensors))
        for index in spread_out(models.before)
    ]


def _response(models: Models, index: int, sensor: int) -> PageFigure:
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
    lowest = lowest_phase(own.h1[sensor][pick], own.coherence[sensor][pick])
    for text, style, whole, whole_coherence in rows:
        h1, coherence = whole[pick], whole_coherence[pick]
        wide = style == MEASURED
        heights.append(Curve(text, frequency, np.abs(h1), style, wide=wide))
        phase = phase_of(h1, coherence, lowest)
        phases.append(Curve(text, frequency, phase, style, wide=wide))
        coherences.append(Curve(text, frequency, coherence, style, wide=wide))
    x_axis = Axis("", 0.0, float(frequency[-1]))
    turn = Axis("phase [°]", lowest, lowest + 360.0, degrees=True)
    below = Axis("frequency [Hz]", 0.0, float(frequency[-1]))
    title = f"{name}, {label(test)}"
    error = "; ".join(
        f"{text}: residual rms {found.error:.1%}"
        + ("" if found.frac is None else f", FRAC {found.frac:.3f}")
        for text, found in ((text, c.tests[index].errors[sensor]) for text, _, c in models.each)
    )
    return PageFigure(
        f"{name}, {label(test)}.",
        f"{capitalised(error)}.",
        to_svg.plot(
            Plot(
                heights,
                x_axis,
                logarithmic_axis(f"|H1| [{unit_of_sensor(models.before, name)}]", heights, 5),
            ),
            title=f"Response function of {title}",
            height=210,
            keys=False,
        )
        + to_svg.plot(
            Plot(phases, x_axis, turn), title=f"Phase of {title}", height=130, keys=False
        )
        + to_svg.plot(
            Plot(coherences, below, Axis("coherence [-]", 0.0, 1.0)),
            title=f"Coherence of {title}",
            height=150,
        ),
    )


def picked(
    frequency: FloatArray, excited: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.int_]]:
    """Return the excited bins that are drawn, and their numbers. `frequency` is in [Hz]."""
    inside = np.flatnonzero(excited)
    step = max(1, -(-inside.size // MOST_BINS))
    return frequency[inside[::step]], inside[::step]


def phase_of(h1: ComplexArray, coherence: FloatArray, lowest: float) -> FloatArray:
    """Return the phase in degrees, broken where it is noise or jumps round the circle.

    `h1` is in any unit, `coherence` without [-], `lowest` in degrees [°].
    """
    phase = (np.degrees(np.angle(h1)) - lowest) % 360.0 + lowest
    out = np.where(coherence > HEARD, phase, np.nan)
    out[1:][np.abs(np.diff(phase)) > 180.0] = np.nan
    return out


def lowest_phase(h1: ComplexArray, coherence: FloatArray) -> float:
    """Return the angle to cut the circle at, so that the measured phase jumps least [°]."""
    clear = np.degrees(np.angle(h1[coherence > 0.5]))
    jumps = {
        lowest: np.sum(np.abs(np.diff((clear - lowest) % 360.0)) > 180.0)
        for lowest in (-180.0, -270.0, -90.0)
    }
    return min(jumps, key=lambda lowest: jumps[lowest])


def error_by_band(models: Models) -> list[PageFigure]:
    """Return the error over frequency in the test that counts most, with the noise."""
    index = deciding(models.before)
    test = models.before.tests[index]
    drawings = []
    for sensor, name in enumerate(test.measured.sensors):
        bands = models.before.bands
        driven = np.flatnonzero(bands.driven[index])
        shown = slice(driven[0], driven[-1] + 1)
        edges = bands.edges[driven[0] : driven[-1] + 2]
        curves = [
            _stairs(text, edges, c.bands.error[index, sensor, shown], style)
            for text, style, c in models.each
        ]
        floor = bands.floor[index, sensor, shown]
        if np.any(np.isfinite(floor) & (floor > 0.0)):
            curves.append(_stairs("noise", edges, floor, NOISE, thin=True))
        drawings.append(
            PageFigure(
                f"{name}, {label(test)}: error by band.",
                "Unexplained over measured rms in each third octave that the test drives. A "
                "good model comes down to the noise wherever there is response.",
                to_svg.plot(
                    Plot(
                        curves,
                        Axis(
                            "frequency [Hz]",
                            float(edges[0]),
                            float(edges[-1]),
                            logarithmic=True,
                        ),
                        logarithmic_axis("error [-]", curves),
                    ),
                    title=f"Error of {name} by third octave",
                ),
            )
        )
    return drawings


def _stairs(
    text: str, edges: FloatArray, values: FloatArray, style: int, *, thin: bool = False
) -> Curve:
    """Return a value over each band, so that its width is seen."""
    values = np.where(values > 0.0, values, np.nan)
    return Curve(text, np.repeat(edges, 2)[1:-1], np.repeat(values, 2), style, thin=thin)


def harmonics(models: Models) -> list[PageFigure]:
    """Return the harmonics of the loudest test that has tones."""
    tonal = [i for i in by_input(models.before) if models.before.tests[i].harmonics is not None]
    if not tonal:
        return []
    index = tonal[-1]
    test = models.before.tests[index]
    drawings = []
    for sensor, name in enumerate(test.measured.sensors):
        drawn = [(text, style, c.tests[index].harmonics) for text, style, c in models.each]
        rows = [(text, style, h[sensor].predicted) for text, style, h in drawn if h is not None]
        first = (test.harmonics or ())[sensor]
        rows.insert(0, ("measured", MEASURED, first.measured))
        curves = _by_order(rows)
        names = {float(order): str(order) for order in range(1, first.measured.size + 1)}
        drawings.append(
            PageFigure(
                f"{name}, {label(test)}: harmonics.",
                "Amplitude over the measured fundamental: odd orders alone mean a law that is "
                "the same on both sides, even ones that it is not.",
                to_svg.plot(
                    Plot(
                        curves,
                        Axis("harmonic order [-]", 0.5, first.measured.size + 0.5),
                        logarithmic_axis("amplitude [-]", curves, 5),
                        names=names,
                    ),
                    title=f"Harmonics of {name}",
                ),
            )
        )
    return drawings


def _by_order(rows: Sequence[tuple[str, int, FloatArray]]) -> list[Curve]:
    """Return values over their order, those of one order beside each other."""
    return [
        Curve(
            text,
            np.arange(1.0, values.size + 1.0) + 0.14 * (i - (len(rows) - 1) / 2),
            np.where(values > 1e-6, values, np.nan),
            style,
            points=True,
        )
        for i, (text, style, values) in enumerate(rows)
    ]
