"""Models, runs and estimators that the checks of the thesis' statements share."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, final

import numpy as np

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.studies.kinds.grid import PeakOfRun, peak_of_run
from shakerproc.studies.results import Checked, Trend, Verdict, trends, verdict_of
from shakerproc.studies.study import Measure, StudyRun

PERIODOGRAM: Final = Measure()
WELCH: Final = Measure(estimator="welch", segment=2048)
SWEEP: Final = StudyRun("sine sweep", level=5.0, from_hz=0.0, to_hz=30.0, duration=30.0)
STIFFNESS: Final = 1000.0
DAMPING_RATIO: Final = 0.01


@final
@dataclass(frozen=True, slots=True)
class ClaimFinding:
    """Our number, and the checks that the statement must pass.

    Attributes
    ----------
    number : str
        What we find, for people.
    checks : tuple of Checked
        What was checked, and how it came out.
    """

    number: str
    checks: tuple[Checked, ...]

    @property
    def held(self) -> Verdict:
        """Whether the statement held, by its checks."""
        return verdict_of(self.checks)


def model(*effects: AbstractEffect) -> Model:
    """Return the thesis' model: 1 kg, held by these effects, a force on the mass."""
    elements = tuple(Element(effect, ("base", "mass")) for effect in effects)
    return Model("thesis", {"mass": 1.0}, elements, Excitation("force", "mass"))


def gap(
    clearance: float, stiffness: float = STIFFNESS, damping_ratio: float = DAMPING_RATIO
) -> Model:
    """Return free play between elastic walls (a spring without play), with damping.

    `clearance` is in [m], `stiffness` in [N/m], `damping_ratio` without unit [-].
    """
    wall = EFFECTS["spring"](stiffness=stiffness)  # type: ignore[call-arg]
    if clearance > 0.0:
        wall = EFFECTS["gap"](stiffness=stiffness, clearance=clearance)  # type: ignore[call-arg]
    return model(wall, EFFECTS["damper"](damping_ratio=damping_ratio))  # type: ignore[call-arg]


def jump_gap(clearance: float) -> Model:
    """Return the literal eq. 3.14, whose force jumps at the wall. `clearance` is in [m]."""
    return model(
        EFFECTS["jump_gap"](stiffness=STIFFNESS, clearance=clearance),  # type: ignore[call-arg]
        EFFECTS["damper"](damping_ratio=DAMPING_RATIO),  # type: ignore[call-arg]
    )


FORCE: Final = 10.0
"""Force of the power law in the listing [N]."""


def power_law(exponent: float, wall: float = 1e-3, relaxation: float = 1e-5) -> Model:
    """Return the power law of the listing, with its relaxation spring and its damping.

    `exponent` is without unit [-], `wall` and `relaxation` in [m].
    """
    return model(
        EFFECTS["power_law"](  # type: ignore[call-arg]
            force=FORCE, reference_displacement=wall, exponent=exponent
        ),
        EFFECTS["spring"](stiffness=relaxation),  # type: ignore[call-arg]
        EFFECTS["damper"](damping=2.0 * np.sqrt(FORCE) * 0.01),  # type: ignore[call-arg]
    )


def peak(shaken: Model, run: StudyRun, measure: Measure = PERIODOGRAM) -> PeakOfRun:
    """Return omega_e of one run, as a study of kind grid reads it."""
    return peak_of_run(shaken, run, measure)


@cache
def gap_peak(
    clearance: float, level: float = 5.0, *, down: bool = False, **changed: float
) -> PeakOfRun:
    """Return omega_e of a sweep over free play; several statements ask for the same.

    `clearance` is in [m], `level` in [N].
    """
    run = StudyRun("sine sweep", level=level, from_hz=0.0, to_hz=30.0, duration=30.0, down=down)
    return peak(gap(clearance, **changed), run)


def peaks(
    quantity: str,
    along: str,
    wanted: Trend,
    *rows: tuple[Sequence[float], Sequence[PeakOfRun]],
    scales: Sequence[float] = (),
) -> Checked:
    """Return whether omega_e falls, rises or changes with a parameter in every row.

    Parameters
    ----------
    quantity, along : str
        Names of what is read, with its unit, and of the parameter.
    wanted : str
        The trend.
    rows : pairs of (n,) sequences
        Parameter and peaks [any unit, Hz].
    scales : (n,) sequence
        What each peak, and its resolution, is divided by; by default 1 [Hz].
    """
    groups = []
    for x, run_peak in rows:
        by = np.array(scales or [1.0] * len(run_peak))
        values = np.array([one.value for one in run_peak]) / by
        finest = np.array([one.resolution for one in run_peak]) / by
        groups.append((np.array(x, np.float64), values, finest))
    return trends(quantity, groups, wanted, along)


def series(values: Sequence[float], digits: int = 3) -> str:
    """Return values as text: ``5.03, 4.97, 4.93``. `values` may be in any unit."""
    return ", ".join(f"{value:.{digits}f}" for value in values)


def values_of(run_peaks: Sequence[PeakOfRun]) -> list[float]:
    """Return omega_e of several runs [Hz]."""
    return [one.value for one in run_peaks]
