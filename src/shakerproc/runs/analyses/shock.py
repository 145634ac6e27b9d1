"""Shock response spectra of accelerations, pseudo-velocity on four-coordinate paper."""

from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray, Recording
from shakerproc.runs.analyses import (
    AbstractAnalysis,
    accelerations,
    natural_frequencies,
    offset_free,
)
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.spectra.response_spectra import PARTS, QUANTITIES, ShockSpectra, shock_spectra

UNITS: Final = {
    "absolute_acceleration": ("g", 1.0 / STANDARD_GRAVITY),
    "relative_velocity": ("m_per_s", 1.0),
    "relative_displacement": ("mm", 1e3),
    "pseudo_velocity": ("m_per_s", 1.0),
    "equivalent_static_acceleration": ("g", 1.0 / STANDARD_GRAVITY),
}
"""Ending of a header, and how many of it are one SI unit."""


@final
class ShockAnalysis(AbstractAnalysis):
    """Shock response spectra of all kinds."""

    kind: ClassVar[str] = "shock"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the shock response spectra of the accelerations of a run."""
        wanted = result.test.processing.shock
        if wanted is None:
            return None
        rows = accelerations(result, self.kind)
        frequency = natural_frequencies(
            result, (wanted.low, wanted.high), wanted.per_octave, self.kind
        )
        blocks = offset_free(recording.select(rows), result, rows)
        spectra = shock_spectra(blocks, result.recorded.sample_rate, frequency, wanted.damping)
        names = [result.channels[i].name for i in rows]
        return Analysis(
            kind=self.kind,
            title=f"Shock response spectra, damping {100.0 * wanted.damping:g} %",
            columns=_columns(spectra, names),
            summary=tuple(_row(spectra, row, name) for row, name in enumerate(names)),
            panels=(
                _maximax(spectra, names),
                _primary_and_residual(spectra, names, _loudest(result, rows)),
                _four_coordinates(spectra, names),
            ),
        )


def _loudest(result: RunResult, rows: list[int]) -> int:
    return rows.index(result.averages.loudest) if result.averages.loudest in rows else 0


def _columns(spectra: ShockSpectra, names: list[str]) -> dict[str, FloatArray]:
    columns = {"frequency_hz": spectra.frequency}
    for row, name in enumerate(names):
        for quantity in QUANTITIES:
            unit, factor = UNITS[quantity]
            for part in PARTS:
                values = spectra.values[quantity][part][row] * factor
                columns[f"{quantity}_{part}_{name}_{unit}"] = values
    return columns


def _row(spectra: ShockSpectra, row: int, name: str) -> dict[str, Cell]:
    """Return the largest values of a channel, and of which oscillators they are."""
    cells: dict[str, Cell] = {"channel": name}
    for quantity in ("absolute_acceleration", "pseudo_velocity", "relative_displacement"):
        unit, factor = UNITS[quantity]
        values = spectra.values[quantity]["maximax"][row]
        at = int(np.argmax(values))
        cells[f"{quantity}_{unit}"] = float(values[at] * factor)
        cells[f"{quantity}_at_hz"] = float(spectra.frequency[at])
    return cells


def _maximax(spectra: ShockSpectra, names: list[str]) -> Panel:
    values = spectra.values["absolute_acceleration"]["maximax"] / STANDARD_GRAVITY
    return Panel(
        name="shock_maximax",
        title="Shock response, maximax of the absolute acceleration",
        caption="Largest acceleration of an oscillator of each natural frequency.",
        x=PanelScale("natural frequency [Hz]"),
        y=PanelScale("acceleration [g]"),
        lines=tuple(
            PanelLine(name, spectra.frequency, values[row], channel=name)
            for row, name in enumerate(names)
        ),
    )


def _primary_and_residual(spectra: ShockSpectra, names: list[str], row: int) -> Panel:
    parts = spectra.values["absolute_acceleration"]
    return Panel(
        name="shock_primary_residual",
        title=f"Shock response of {names[row]}, primary and residual",
        caption="While the shock lasts and after it, each way, of the absolute acceleration.",
        x=PanelScale("natural frequency [Hz]"),
        y=PanelScale("acceleration [g]"),
        lines=tuple(
            PanelLine(
                part.replace("_", " "),
                spectra.frequency,
                parts[part][row] / STANDARD_GRAVITY,
                style=i,
            )
            for i, part in enumerate(PARTS[:4])
        ),
    )


def _four_coordinates(spectra: ShockSpectra, names: list[str]) -> Panel:
    values = spectra.values["pseudo_velocity"]["maximax"]
    rising, falling = _paper(spectra.frequency, values)
    return Panel(
        name="shock_pseudo_velocity",
        title="Pseudo-velocity on four-coordinate paper",
        caption=(
            "Grey, rising: constant displacement, upwards "
            f"{', '.join(line.label for line in rising)}; falling: constant acceleration, "
            f"upwards {', '.join(line.label for line in falling)}."
        ),
        x=PanelScale("natural frequency [Hz]"),
        y=PanelScale("pseudo-velocity [m/s]"),
        lines=(
            *rising,
            *falling,
            *(
                PanelLine(name, spectra.frequency, values[row], channel=name)
                for row, name in enumerate(names)
            ),
        ),
    )


def _paper(
    frequency: FloatArray, velocity: FloatArray
) -> tuple[list[PanelLine], list[PanelLine]]:
    """Return the lines of constant displacement, ωd, and of constant acceleration, a/ω.

    Those that cross the decades of the velocities, a decade from one to the next.
    """
    x = np.geomspace(frequency[0], frequency[-1], 60)
    omega = 2.0 * np.pi * x
    positive = velocity[velocity > 0.0]
    if not positive.size:
        return [], []
    low, high = (10.0 ** f(np.log10(v)) for f, v in
                 ((np.floor, positive.min()), (np.ceil, positive.max())))  # fmt: skip
    rows: list[list[PanelLine]] = []
    for of_unit, unit in ((omega, "m"), (STANDARD_GRAVITY / omega, "g")):
        first = np.floor(np.log10(low / of_unit.max())) + 1
        last = np.ceil(np.log10(high / of_unit.min())) - 1
        rows.append([
            PanelLine(_named(10.0**power, unit), x, 10.0**power * of_unit, look="paper")
            for power in np.arange(first, last + 1)
        ])
    return rows[0], rows[1]


def _named(value: float, unit: str) -> str:
    """Return a length in the prefix that suits it, an acceleration in g."""
    if unit == "g":
        return f"{value:g} g"
    for factor, prefixed in ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")):
        if value >= factor * (1.0 - 1e-9):
            return f"{value / factor:g} {prefixed}"
    return f"{value:.0e} m"
