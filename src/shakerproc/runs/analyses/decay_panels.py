"""Figures of frequency and damping against amplitude."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.runs.analysis import Panel, PanelLine, PanelScale
from shakerproc.spectra.decays import DecayReading

MARGIN: Final = 0.03
"""Room above and below the limits in a figure, over the distance of both [-]."""

QUANTITIES: Final[Mapping[str, tuple[str, float]]] = {
    "frequency": ("natural frequency [Hz]", 1.0),
    "damping": ("damping ratio [%]", 100.0),
}
"""What is drawn: the label of its axis and the factor to its unit."""

Curve: TypeAlias = tuple[str, int, Sequence[DecayReading]]
"""Name, style and readings of a curve."""


@final
@dataclass(frozen=True, slots=True)
class Amplitude:
    """The quantity along the axis: its channel, its shown unit and the factor to that."""

    channel: str
    unit: str
    factor: float


def decay_panels(
    name: str,
    about: str,
    caption: str,
    amplitude: Amplitude,
    curves: Sequence[Curve],
    *,
    limited: int,
) -> list[Panel]:
    """Return two figures, frequency and damping, of curves overlaid.

    Parameters
    ----------
    name : str
        Of the files, before the quantity.
    about, caption : str
        Which mode, and what to look for.
    amplitude : Amplitude
        What lies along the axis.
    curves : sequence of Curve
        What is drawn.
    limited : int
        Of how many of them, the first, the 95 % limits are drawn.
    """
    along = PanelScale(f"amplitude of {amplitude.channel} [{amplitude.unit}]")
    panels = []
    for quantity, (label, factor) in QUANTITIES.items():
        lines = [_lines(one, quantity, (amplitude.factor, factor)) for one in curves]
        limits = [edge for edges, _ in lines[:limited] for edge in edges]
        drawn = (*limits, *(line for _, line in lines))
        title = f"{quantity.capitalize()} of {about}"
        panels.append(
            Panel(f"{name}_{quantity}", title, caption, along, _across(label, drawn), drawn)
        )
    return panels


def _lines(
    curve: Curve, quantity: str, factors: tuple[float, float]
) -> tuple[list[PanelLine], PanelLine]:
    """Return both limits of a curve, and the curve."""
    name, style, readings = curve
    x = factors[0] * np.array([one.amplitude for one in readings])
    y = factors[1] * np.array([getattr(one, quantity) for one in readings])
    half = factors[1] * np.array([getattr(one, f"{quantity}_error") for one in readings])
    limits = [PanelLine("", x, edge, look="paper") for edge in (y - half, y + half)]
    return limits, PanelLine(name, x, y, style=style)


def _across(label: str, lines: Sequence[PanelLine]) -> PanelScale:
    shown = [line.y for line in lines if line.y.size]
    low, high = min(y.min() for y in shown), max(y.max() for y in shown)
    margin = MARGIN * (high - low)
    return PanelScale(
        label, logarithmic=False, ends=(float(low - margin), float(high + margin))
    )
