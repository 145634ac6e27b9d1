"""One row of the plan for each test, with what to mind before the shaker is booked."""

from dataclasses import replace
from math import inf
from typing import Final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.numerals import numeral
from shakerproc.planning.acquisition import (
    averaging,
    duration_of_test,
    rate_at,
    sample_rate_of_test,
)
from shakerproc.planning.inputs import AbstractInput, RandomInput, input_of_test
from shakerproc.planning.joints import AbstractJoint, FreeJoint, Walls
from shakerproc.planning.plan import BaseTravel, Needed, PlannedTest, PlanWish
from shakerproc.planning.play import Play, Warming, Which, play_of_test
from shakerproc.planning.reach import Band, Reach, bands_within_limits, reach
from shakerproc.planning.remarks import remarks_on
from shakerproc.spectra.tones.passing import swept_peak
from shakerproc.testlog import PULSES, Test, TestLog
from shakerproc.testlog.excitation import LEVELS, LevelUnit

_SHOWN: Final = {
    "m/s^2": ("g", STANDARD_GRAVITY),
    "(m/s^2)^2/Hz": ("g^2/Hz", STANDARD_GRAVITY**2),
    "m/s^2 rms": ("g rms", STANDARD_GRAVITY),
}
"""Unit that a level is shown in, and its size in SI; others are shown in SI."""


def plan_campaign(log: TestLog, wish: PlanWish) -> tuple[PlannedTest, ...]:
    """Return a row for each test of a log, discarded ones bare, planned ones last."""
    return tuple(plan_test(test, wish) for test in (*log.tests, *log.planned))


def displacement_of_test(
    test: Test, which: Which = "actual", warming: Warming | None = None
) -> BaseTravel | None:
    """Return how the table moves in a test; None where its log does not say it."""
    shaken = input_of_test(test)
    if shaken is None or shaken.quantity == "force":
        return None
    motion = shaken.largest_motion()
    rms = shaken.rms_displacement if isinstance(shaken, RandomInput) else None
    play = play_of_test(test, which, warming)
    if play is None or play.total <= 0.0:
        return BaseTravel(motion, rms, play, None, None, None)
    return BaseTravel(
        motion,
        rms,
        play,
        motion.displacement / play.half,
        shaken.frequency_of_displacement(play.half),
        shaken.frequency_of_displacement(play.total),
    )


def plan_test(test: Test, wish: PlanWish) -> PlannedTest:
    """Return the prediction of one test."""
    if test.discarded:
        return PlannedTest(test)
    shaken = input_of_test(test)
    duration = duration_of_test(test, wish.duration)
    if shaken is None:
        unclear = (_unclear(test),)
        return PlannedTest(test, duration=duration, warnings=unclear)
    play = play_of_test(test, wish.which, wish.warming)
    walls = _walls(wish.joint, play)
    possible = walls is not None and (
        shaken.quantity == "base acceleration" or not isinstance(wish.joint, FreeJoint)
    )
    found = reach(wish.joint, shaken, walls) if possible and walls is not None else None
    rate = sample_rate_of_test(test, wish.sample_rate)
    averages = None
    if isinstance(shaken, RandomInput) and duration is not None and rate is not None:
        averages = averaging(test.processing.welch, duration, rate, wish.coherence)
    modes = [m for m in wish.joint.modes() if shaken.low <= m.frequency <= shaken.high]
    peaks = [
        swept_peak(speed, mode.frequency, mode.damping_ratio)
        for mode in modes
        if mode.damping_ratio > 0.0 and (speed := rate_at(test, mode.frequency)) is not None
    ]
    planned = PlannedTest(
        test,
        shaken,
        displacement_of_test(test, wish.which, wish.warming),
        walls,
        found,
        _needed(test, shaken, found, walls, wish) if found and walls else None,
        duration,
        min(peaks, default=None),
        averages,
    )
    told = tuple(remarks_on(planned, wish, rate, modes))
    return replace(planned, warnings=told)


def _walls(joint: AbstractJoint, play: Play | None) -> Walls | None:
    own = joint.walls()
    if own is not None:
        return own
    if play is None or play.total <= 0.0:
        return None
    return Walls(play.half, play.half)


def _needed(
    test: Test, shaken: AbstractInput, found: Reach, walls: Walls, wish: PlanWish
) -> Needed | None:
    factor = found.factor_both_sides
    if factor == inf or test.level is None or test.level_unit is None:
        return None
    power = 2.0 if LEVELS[test.level_unit][0] == "density" else 1.0
    level = test.level * factor**power
    known = wish.limits.known and shaken.quantity == "base acceleration"
    bands: tuple[Band, ...] = ()
    if known:
        band = (shaken.low, shaken.high)
        bands = bands_within_limits(wish.joint, wish.limits, band, walls.far)
    allowed = not wish.limits.exceeded_by(shaken.scaled(factor)) if known else None
    return Needed(level, level_text(level, test.level_unit), allowed, bands)


def level_text(level: float, unit: LevelUnit) -> str:
    """Return a level [unit] as people write it in a log."""
    shown, scale = _SHOWN.get(unit, (unit, 1.0))
    return f"{numeral(level / scale)} {shown}"


def _unclear(test: Test) -> str:
    if test.excitation is None:
        return "the log does not say what shakes it"
    if test.excitation == "measured":
        return "what shakes it stands in its recording alone"
    if test.excitation == "sine on random":
        return (
            "left out: how far tones on random vibration move table and joint is not planned; "
            "simulate plays them"
        )
    if test.excitation in PULSES:
        return (
            f"a {test.excitation}: its width is not in the log, so that its displacement is "
            "not known"
        )
    if test.level is None:
        return "the log does not say its level"
    return "the log does not say its frequencies"
