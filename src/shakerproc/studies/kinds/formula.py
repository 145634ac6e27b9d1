"""Closed forms as curves: figures 3.1, 3.9, 3.10 and 5.14."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.simulate import closed_forms
from shakerproc.studies.kinds.base import AbstractKind, Job, said
from shakerproc.studies.results import Columns, Line, Panel, StudyResult
from shakerproc.studies.study import Study


def _magnification() -> tuple[Panel, ...]:
    """Return amplitude and phase of the linear oscillator (eq. 3.10 and 3.11)."""
    ratio = np.linspace(0.0, 3.0, 601)
    damping = (0.05, 0.1, 0.2, 0.5, 1.0)
    gains = tuple(
        Line(ratio, closed_forms.magnification(ratio, zeta), f"ζ = {zeta:g}", "line", i)
        for i, zeta in enumerate(damping)
    )
    lags = tuple(
        Line(ratio, np.degrees(closed_forms.phase_lag(ratio, zeta)), "", "line", i)
        for i, zeta in enumerate(damping)
    )
    return (
        Panel("frequency ratio r [-]", "X / δst [-]", gains),
        Panel("frequency ratio r [-]", "lag [deg]", lags),
    )


def _duffing_response() -> tuple[Panel, ...]:
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
                Line(2.0 * np.pi * frequency[known], amplitude[known], label, "line", i)
            )
    return (Panel("ω / ω_n [-]", "amplitude [m]", tuple(lines)),)


def _duffing_backbone() -> tuple[Panel, ...]:
    """Return figure 3.10: eq. 3.49 and the exact frequency, omega_n = 1 and mu = 1."""
    amplitude = np.linspace(0.0, 4.0, 201)
    first = closed_forms.duffing_harmonic_free_frequency(amplitude, 0.5 / np.pi, 1.0)
    exact = closed_forms.duffing_free_frequency(amplitude, 0.5 / np.pi, 1.0)
    return (
        Panel(
            "amplitude [m]",
            "ω / ω_n [-]",
            (
                Line(amplitude, 2.0 * np.pi * first, "eq. 3.49"),
                Line(amplitude, 2.0 * np.pi * exact, "exact (elliptic functions)", "dashed", 1),
            ),
        ),
    )


def _displacement() -> tuple[Panel, ...]:
    """Return figure 5.14: table displacement at constant acceleration, clearance 0.1 mm."""
    frequency = np.geomspace(10.0, 1000.0, 301)
    lines = [
        Line(
            frequency,
            1e3
            * closed_forms.displacement_amplitude(np.array(g * STANDARD_GRAVITY), frequency),
            f"{g:g} g",
            "line",
            i,
        )
        for i, g in enumerate((0.5, 1.0, 5.0, 10.0, 20.0))
    ]
    lines.append(Line(frequency, np.full(frequency.size, 0.1), "a = 0.1 mm", "dashed", 6))
    panel = Panel(
        "frequency [Hz]", "displacement of the table [mm]", tuple(lines), log_x=True, log_y=True
    )
    return (panel,)


def _power_law() -> tuple[Panel, ...]:
    """Return figures 3.5 and 3.6: the power law of eq. 3.15 in dimensionless form."""
    ratio: FloatArray = np.linspace(-1.2, 1.2, 481)
    lines = tuple(
        Line(ratio, np.clip(ratio ** (2 * n - 1), -4.0, 4.0), f"n = {n}", "line", i)
        for i, n in enumerate((1, 2, 5, 10, 25))
    )
    return (Panel("x / a [-]", "F / κ [-]", lines),)


FORMULAS: Final[Mapping[str, Callable[[], tuple[Panel, ...]]]] = MappingProxyType({
    "magnification": _magnification,
    "duffing response": _duffing_response,
    "duffing backbone": _duffing_backbone,
    "shaker displacement": _displacement,
    "power law": _power_law,
})


@final
class Formula(AbstractKind):
    """One of the closed forms."""

    needs: ClassVar[tuple[str, ...]] = ("formula",)

    def compute(self, study: Study, job: Job) -> Columns:
        lines = [line for panel in FORMULAS[study.formula]() for line in panel.lines]
        sizes = [line.x.size for line in lines]
        return {
            "line": np.repeat(np.arange(len(lines)), sizes),
            "x": np.concatenate([line.x for line in lines]),
            "y": np.concatenate([line.y for line in lines]),
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        statement, verdict = said(study.claim)
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=found[0],
            panels=FORMULAS[study.formula](),
            method="closed form",
            statement=statement,
            verdict=verdict,
        )
