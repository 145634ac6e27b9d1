"""Wishes of a plan, and one row of it for each test."""

from dataclasses import dataclass
from typing import Final, final

from shakerproc.planning.acquisition import (
    Averaging,
)
from shakerproc.planning.inputs import AbstractInput, TableMotion
from shakerproc.planning.joints import AbstractJoint, FreeJoint, Walls
from shakerproc.planning.limits import ShakerLimits
from shakerproc.planning.play import Play, Warming, Which
from shakerproc.planning.reach import Band, Reach
from shakerproc.testlog import Test

_FREE: Final = FreeJoint()

_UNLIMITED: Final = ShakerLimits()


@final
@dataclass(frozen=True, slots=True)
class PlanWish:
    """Assumptions of a plan.

    Attributes
    ----------
    joint : AbstractJoint
        What moves against what.
    limits : ShakerLimits
        Of the shaker.
    which : {"actual", "nominal"}
        Which clearance of the log counts.
    warming : Warming, optional
        Temperature of the joint.
    sample_rate, duration : float, optional
        Of tests whose log does not say them [Hz], [s].
    coherence : float
        Assumed for the random error of a gain [-].
    """

    joint: AbstractJoint = _FREE
    limits: ShakerLimits = _UNLIMITED
    which: Which = "actual"
    warming: Warming | None = None
    sample_rate: float | None = None
    duration: float | None = None
    coherence: float = 0.9


@final
@dataclass(frozen=True, slots=True)
class BaseTravel:
    """How the table moves in a test, and up to where that alone uses up the play.

    Attributes
    ----------
    motion : TableMotion
        Largest motion.
    rms_displacement : float, optional
        Of a random test [m].
    play : Play, optional
        Of the joint along the shaken axis.
    ratio : float, optional
        Displacement over half the play [-].
    both_sides_to_hz : float, optional
        Below it the amplitude is at least half the play (random: 3 sigma of what lies above
        it): a part that keeps still is hit on both sides [Hz].
    whole_play_to_hz : float, optional
        Below it the amplitude is at least the whole play [Hz].
    """

    motion: TableMotion
    rms_displacement: float | None
    play: Play | None
    ratio: float | None
    both_sides_to_hz: float | None
    whole_play_to_hz: float | None


@final
@dataclass(frozen=True, slots=True)
class Needed:
    """The level at which a test would just use up the play on both sides.

    Attributes
    ----------
    level : float
        In the unit of the test's own level, SI.
    text : str
        As the log would write it.
    allowed : bool, optional
        Whether the shaker's limits allow it; None without limits.
    bands_hz : tuple of (float, float)
        Where a sine within the shaker's limits would do it, inside the test's band [Hz].
    """

    level: float
    text: str
    allowed: bool | None
    bands_hz: tuple[Band, ...]


@final
@dataclass(frozen=True, slots=True)
class PlannedTest:
    """Prediction of one test.

    Attributes
    ----------
    test : Test
        The line of the log.
    shaken : AbstractInput, optional
        What the shaker does; None where the log does not say it.
    travel : BaseTravel, optional
        How the table moves; None for forces.
    walls : Walls, optional
        Free play to either side.
    reach : Reach, optional
        Where the joint gets.
    needed : Needed, optional
        What it would take.
    duration : float, optional
        Length of the run [s].
    swept_peak : float, optional
        Lowest share of the steady resonance that the sweep reaches, over the modes [-].
    averaging : Averaging, optional
        Of a random test.
    warnings : tuple of str
        A sentence each.
    """

    test: Test
    shaken: AbstractInput | None = None
    travel: BaseTravel | None = None
    walls: Walls | None = None
    reach: Reach | None = None
    needed: Needed | None = None
    duration: float | None = None
    swept_peak: float | None = None
    averaging: Averaging | None = None
    warnings: tuple[str, ...] = ()
