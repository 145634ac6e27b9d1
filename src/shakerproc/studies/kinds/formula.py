"""Closed forms as curves: figures 3.1, 3.9, 3.10 and 5.14."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.simulation import closed_forms
from shakerproc.studies.kinds.base import AbstractKind, Drawing, JobFinding, StudyJob
from shakerproc.studies.results import Columns, StudyLine, StudyPanel
from shakerproc.studies.study import Study


def _magnification() -> tuple[StudyPanel, ...]:
    """Return amplitude and phase of the linear oscillator (eq. 3.10 and 3.11)."""
    ratio = np.linspace(0.0, 3.0, 601)
    damping = (0.05, 0.1, 0.2, 0.5, 1.0)
    gains = tuple(
        StudyLine(ratio, closed_forms.magnification(ratio, zeta), f"ζ = {zeta:g}", "line", i)
        for i, zeta in enumerate(damping)
    )
    lags = tuple(
        StudyLine(ratio, np.degrees(closed_forms.phase_lag(ratio, zeta)), "", "line", i)
        for i, zeta in enumerate(damping)
    )
    return (
        StudyPanel("frequency ratio r [-]", "X / δst [-]", gains),
        StudyPanel("frequency ratio r [-]", "lag [deg]", lags),
    )


def _duffing_response() -> tuple[StudyPanel, ...]:
    """Return figure 3.9: omega_n = F = 1, delta = 0.1, several mu."""
    lines = []
    amplitude = np.geomspace(0.02, 11.0, 4000)
    for i, cubic in enumerate((-0.003, 0.0, 0.01, 0.04, 0.1)):
        both = closed_forms.duffing_response_frequencies(
            amplitude, natural=0.5 / np.pi, damping_rate=0.1, cubic=cubic, force=1.0
        )
        for j, frequency in enumerate(both):
            label = f"μ = {cubic:g}" if j == 0 else ""
            known = np.isfinite(frequency) & (frequency < 0.5)
            lines.append(
                StudyLine(2.0 * np.pi * frequency[known], amplitude[known], label, "line", i)
            )
    return (StudyPanel("ω / ω_n [-]", "amplitude [m]", tuple(lines)),)


def _duffing_backbone() -> tuple[StudyPanel, ...]:
    """Return figure 3.10: eq. 3.49 and the exact frequency, omega_n = 1 and mu = 1."""
    amplitude = np.linspace(0.0, 4.0, 201)
    first = closed_forms.duffing_harmonic_free_frequency(amplitude, 0.5 / np.pi, 1.0)
    exact = closed_forms.duffing_free_frequency(amplitude, 0.5 / np.pi, 1.0)
    return (
        StudyPanel(
            "amplitude [m]",
            "ω / ω_n [-]",
            (
                StudyLine(amplitude, 2.0 * np.pi * first, "eq. 3.49"),
                StudyLine(
                    amplitude, 2.0 * np.pi * exact, "exact (elliptic functions)", "dashed", 1
                ),
            ),
        ),
    )


def _displacement() -> tuple[StudyPanel, ...]:
    """Return figure 5.14: table displacement at constant acceleration, clearance 0.1 mm."""
    frequency = np.geomspace(10.0, 1000.0, 301)
    lines = [
        StudyLine(
            frequency,
            1e3
            * closed_forms.displacement_amplitude(np.array(g * STANDARD_GRAVITY), frequency),
            f"{g:g} g",
            "line",
            i,
        )
        for i, g in enumerate((0.5, 1.0, 5.0, 10.0, 20.0))
    ]
    lines.append(StudyLine(frequency, np.full(frequency.size, 0.1), "a = 0.1 mm", "dashed", 6))
    panel = StudyPanel(
        "frequency [Hz]", "displacement of the table [mm]", tuple(lines), log_x=True, log_y=True
    )
    return (panel,)


def _power_law() -> tuple[StudyPanel, ...]:
    """Return figures 3.5 and 3.6: the power law of eq. 3.15 in dimensionless form."""
    ratio: FloatArray = np.linspace(-1.2, 1.2, 481)
    lines = tuple(
        StudyLine(ratio, np.clip(ratio ** (2 * n - 1), -4.0, 4.0), f"n = {n}", "line", i)
        for i, n in enumerate((1, 2, 5, 10, 25))
    )
    return (StudyPanel("x / a [-]", "F / κ [-]", lines),)


def _beyond_root_two(panels: Sequence[StudyPanel]) -> dict[str, float]:
    """Return the change with damping at r = 2, from the least to the most damped curve."""
    gains = [np.interp(2.0, line.x, line.y) for line in panels[0].lines]
    return {"gain_change_at_r_2": float(gains[-1] - gains[0])}


def _peaks_over_linear(panels: Sequence[StudyPanel]) -> dict[str, float]:
    """Return where the softening and the most hardening curve are tallest, over the linear."""
    softening, linear, hardening = (
        _tallest([line for line in panels[0].lines if line.style == style])
        for style in (0, 1, 4)
    )
    return {
        "softening_peak_ratio": softening / linear,
        "hardening_peak_ratio": hardening / linear,
    }


def _tallest(lines: Sequence[StudyLine]) -> float:
    x, y = (np.concatenate([getattr(line, name) for line in lines]) for name in ("x", "y"))
    return float(x[np.argmax(y)])


def _rise_of_backbone(panels: Sequence[StudyPanel]) -> dict[str, float]:
    first, exact = panels[0].lines
    at_one = np.interp(1.0, first.x, first.y) / np.interp(1.0, exact.x, exact.y) - 1.0
    return {
        "least_rise": float(np.min(np.diff(exact.y))),
        "error_of_eq_3_49_at_amplitude_1": float(at_one),
    }


def _wall_of_power_law(panels: Sequence[StudyPanel]) -> dict[str, float]:
    """Return the force of the steepest curve half-way to the wall and a twentieth beyond."""
    steepest = panels[0].lines[-1]
    return {
        "force_half_way": float(np.interp(0.5, steepest.x, steepest.y)),
        "force_a_twentieth_beyond": float(np.interp(1.05, steepest.x, steepest.y)),
    }


def _displacement_at_400_hz(panels: Sequence[StudyPanel]) -> dict[str, float]:
    """Return how far the table moves at 1 g and 400 Hz, the place that the text names."""
    line = panels[0].lines[1]
    at = np.interp(np.log(400.0), np.log(line.x), np.log(line.y))  # a straight line there
    return {"displacement_at_1_g_400_hz_m": 1e-3 * float(np.exp(at))}


@final
@dataclass(frozen=True, slots=True)
class ClosedForm:
    """A closed form that is drawn.

    Attributes
    ----------
    panels : function
        Returns what is drawn.
    read : function
        Returns what checks may be made of, from what is drawn.
    quantities : mapping of str to str
        Their names and SI units.
    """

    panels: Callable[[], tuple[StudyPanel, ...]]
    read: Callable[[Sequence[StudyPanel]], Mapping[str, float]]
    quantities: Mapping[str, str]


FORMULAS: Final[Mapping[str, ClosedForm]] = MappingProxyType({
    "magnification": ClosedForm(_magnification, _beyond_root_two, {"gain_change_at_r_2": "1"}),
    "duffing response": ClosedForm(
        _duffing_response,
        _peaks_over_linear,
        {"softening_peak_ratio": "1", "hardening_peak_ratio": "1"},
    ),
    "duffing backbone": ClosedForm(
        _duffing_backbone,
        _rise_of_backbone,
        {"least_rise": "1", "error_of_eq_3_49_at_amplitude_1": "1"},
    ),
    "shaker displacement": ClosedForm(
        _displacement, _displacement_at_400_hz, {"displacement_at_1_g_400_hz_m": "m"}
    ),
    "power law": ClosedForm(
        _power_law,
        _wall_of_power_law,
        {"force_half_way": "1", "force_a_twentieth_beyond": "1"},
    ),
})


@final
class Formula(AbstractKind):
    """One of the closed forms."""

    needs: ClassVar[tuple[str, ...]] = ("formula",)
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        name: unit for form in FORMULAS.values() for name, unit in form.quantities.items()
    })

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        form = FORMULAS[study.formula]
        panels = form.panels()
        lines = [line for panel in panels for line in panel.lines]
        sizes = [line.x.size for line in lines]
        columns = {
            "line": np.repeat(np.arange(len(lines)), sizes),
            "x": np.concatenate([line.x for line in lines]),
            "y": np.concatenate([line.y for line in lines]),
        }
        return JobFinding(
            columns, {**dict.fromkeys(self.quantities, np.nan), **form.read(panels)}
        )

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        return Drawing(tables[0], FORMULAS[study.formula].panels(), "closed form")
