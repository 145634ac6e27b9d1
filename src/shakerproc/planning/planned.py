"""One row of the plan for each test, with remarks before the shaker is booked."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import Final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.numerals import numeral
from shakerproc.planning.drive import (
    averaging,
    duration_of_test,
    rate_at,
    sample_rate_of_test,
)
from shakerproc.planning.joints import (
    AbstractJoint,
    FreeJoint,
    JointMode,
    Play,
    Walls,
    Warming,
    Which,
    play_of_test,
)
from shakerproc.planning.plan import BaseTravel, Needed, PlannedTest, PlanWish
from shakerproc.planning.reach import Band, Reach, bands_within_limits, reach
from shakerproc.planning.shaker import AbstractInput, RandomInput, input_of_test
from shakerproc.spectra.tones.passing import ENOUGH, fastest_rate, swept_peak, swept_shift
from shakerproc.testlog import PULSES, Multisine, Test, TestLog, ThresholdCrop
from shakerproc.testlog.excitation import LEVELS, LevelUnit

LINES_OF_A_MODE: Final = 4.0
"""Lines of a multisine within the half-power width of a mode: two are excited [-]."""

ENOUGH_PERIODS: Final = 3
"""Periods of a realisation: one for the transient, two for the noise [-]."""

ENOUGH_ERROR: Final = 0.1
"""Random error of a gain that calls for no remark [-]."""

_SHOWN: Final = {
    "m/s^2": ("g", STANDARD_GRAVITY),
    "(m/s^2)^2/Hz": ("g^2/Hz", STANDARD_GRAVITY**2),
    "m/s^2 rms": ("g rms", STANDARD_GRAVITY),
}
"""Unit that a level is shown in, and its size in SI; others are shown in SI."""


def remarks_on(
    planned: PlannedTest, wish: PlanWish, rate: float | None, modes: list[JointMode]
) -> Iterator[str]:
    """Yield remarks on a test before it is run.

    Parameters
    ----------
    planned : PlannedTest
        The row of the plan.
    wish : PlanWish
        What was asked.
    rate : float or None
        Sample rate of the recorder [Hz], where it is known.
    modes : list of JointMode
        Modes that the test may excite.
    """
    test, shaken = planned.test, planned.shaken
    assert shaken is not None  # noqa: S101 - narrows the type; the caller has checked
    yield from _about_sampling(shaken, rate, test)
    yield from wish.limits.exceeded_by(shaken)
    yield from _about_crop(test, shaken)
    yield from _about_sweep(test, shaken, modes)
    yield from _about_averages(planned, wish, rate, modes)
    yield from _about_play(planned, wish)


def _about_sampling(shaken: AbstractInput, rate: float | None, test: Test) -> Iterator[str]:
    if rate is None:
        return
    if shaken.high > 0.5 * rate:
        yield (
            f"{shaken.high:g} Hz lies beyond half the sample rate, {0.5 * rate:.5g} Hz: "
            f"sample faster or end there"
        )
    elif shaken.high > 0.45 * rate:
        yield (
            f"{shaken.high:g} Hz lies in the roll-off of the filters, above 0.45 of the sample "
            f"rate ({0.45 * rate:.5g} Hz)"
        )
    if test.excitation == "random":
        width = rate / test.processing.welch.segment
        if shaken.low < 2.0 * width and test.processing.detrend == "none":
            yield (
                f"the band begins at {shaken.low:g} Hz, within two bins of {numeral(width)} Hz "
                "from 0, where offsets leak: take a longer segment, or detrend: mean"
            )


def _about_crop(test: Test, shaken: AbstractInput) -> Iterator[str]:
    crop = test.processing.crop
    if not isinstance(crop, ThresholdCrop) or shaken.quantity == "force":
        return
    peak = shaken.largest_motion().acceleration
    threshold = crop.threshold / STANDARD_GRAVITY
    level = peak / STANDARD_GRAVITY
    if peak < crop.threshold:
        yield (
            f"the crop's threshold of {numeral(threshold)} g is above its {numeral(level)} g "
            "peak"
        )
    elif peak < 1.15 * crop.threshold and not crop.remove_offset:
        yield (
            f"its peak of {numeral(level)} g is only {numeral(level - threshold, 2)} g above "
            "the crop's threshold: an offset of the sensor may hide the run"
        )


def _about_sweep(test: Test, shaken: AbstractInput, modes: list[JointMode]) -> Iterator[str]:
    if not modes:
        yield from _about_unknown_damping(test, shaken)
    for mode in modes:
        rate = rate_at(test, mode.frequency)
        if rate is None or mode.damping_ratio <= 0.0:
            continue
        peak = swept_peak(rate, mode.frequency, mode.damping_ratio)
        if peak < ENOUGH:
            slower = fastest_rate(mode.frequency, mode.damping_ratio) / rate
            shown = (
                f"{numeral(test.rate_oct_per_min * slower)} oct/min"
                if test.rate_oct_per_min is not None
                else f"{numeral(rate * slower)} Hz/s"
            )
            shift = swept_shift(rate, mode.frequency, mode.damping_ratio)
            late = "low" if (test.from_hz or 0.0) > (test.to_hz or inf) else "high"
            yield (
                f"the sweep passes {numeral(mode.frequency, 4)} Hz too fast: it reaches "
                f"{numeral(100.0 * peak)} % of the resonance, {numeral(shift, 2)} Hz too "
                f"{late}; {shown} gives {100.0 * ENOUGH:.0f} %"
            )


def _about_unknown_damping(test: Test, shaken: AbstractInput) -> Iterator[str]:
    """Say from which Q on the peaks of a sweep are low, where no model says the damping."""
    sentences = []
    for frequency in (shaken.low, shaken.high):
        rate = rate_at(test, frequency)
        if rate is None or frequency <= 0.0:
            return
        # The fastest rate is as the square of the width: 1 Hz wide at 100 Hz is the measure.
        ratio = 0.01 * 100.0 / frequency * (rate / fastest_rate(100.0, 0.01)) ** 0.5
        sentences.append(f"{numeral(0.5 / ratio, 2)} at {numeral(frequency, 4)} Hz")
    yield (
        f"the sweep shows peaks more than {100.0 * (1.0 - ENOUGH):.0f} % too low from Q = "
        f"{' or '.join(dict.fromkeys(sentences))} on; --model with a damping says more"
    )


def _about_averages(
    planned: PlannedTest, wish: PlanWish, rate: float | None, modes: list[JointMode]
) -> Iterator[str]:
    if planned.test.multisine is not None:
        yield from _about_lines(planned.test.multisine, modes)
        return
    if not isinstance(planned.shaken, RandomInput) or rate is None:
        return
    welch = planned.test.processing.welch
    width = rate / welch.segment
    for mode in modes:
        half_power = 2.0 * mode.damping_ratio * mode.frequency
        if width > 0.25 * half_power:
            yield (
                f"bins of {numeral(width)} Hz are coarse for the {numeral(half_power)} Hz "
                f"half-power width at {numeral(mode.frequency, 4)} Hz: take segments of "
                f"{_next_power(4.0 * rate / half_power)} samples"
            )
    if planned.duration is None:
        return
    if planned.averaging is None:
        yield f"{numeral(planned.duration)} s hold less than two averages"
    elif planned.averaging.gain_error > ENOUGH_ERROR:
        longer = (planned.averaging.gain_error / ENOUGH_ERROR) ** 2 * planned.duration
        yield (
            f"{numeral(planned.averaging.averages)} averages leave the gain "
            f"{numeral(100.0 * planned.averaging.gain_error, 2)} % of random error at a "
            f"coherence of {wish.coherence:g}; {numeral(longer)} s would leave "
            f"{100.0 * ENOUGH_ERROR:.0f} %"
        )


def _about_lines(said: Multisine, modes: list[JointMode]) -> Iterator[str]:
    """Yield the limits of a multisine's periods and realisations."""
    for mode in modes:
        half_power = 2.0 * mode.damping_ratio * mode.frequency
        if 0.0 < half_power < LINES_OF_A_MODE / said.period:
            yield (
                f"lines {numeral(1.0 / said.period)} Hz apart are coarse for the "
                f"{numeral(half_power)} Hz half-power width at {numeral(mode.frequency, 4)} "
                f"Hz: take a period of {numeral(LINES_OF_A_MODE / half_power)} s or more"
            )
    if said.periods is not None and said.periods < ENOUGH_PERIODS:
        yield (
            f"periods: {said.periods} leaves no two that repeat after a transient, and without "
            f"these the noise is not known: take {ENOUGH_PERIODS} or more"
        )
    if said.lines != "odd with detection" and said.realisations == 1:
        yield "one realisation without odd detection lines does not tell odd distortion"


def _next_power(number: float) -> int:
    return int(2 ** max(3, int(number - 1.0).bit_length()))


def _about_play(planned: PlannedTest, wish: PlanWish) -> Iterator[str]:
    if planned.walls is None:
        play = planned.travel.play if planned.travel else None
        if play is None:
            yield "the log does not say its clearance"
        else:
            yield f"the joint has no play ({play.says})"
    elif planned.reach is not None and planned.reach.contact != "both sides":
        far = planned.walls.far
        yield f"{_shortfall(planned.reach, far, wish)}{_remedy(planned.needed)}"
    yield from _about_weight(planned, wish)


def _shortfall(extent: Reach, far: float, wish: PlanWish) -> str:
    what = "no contact" if extent.contact == "none" else "contact on one side only"
    peak = ""
    if extent.contacts_per_second is not None:
        what, peak = (
            f"{numeral(extent.contacts_per_second, 2)} contacts a second",
            "3 sigma is ",
        )
    elif isinstance(wish.joint, FreeJoint):
        what = "the table moves less than half the play"
    return f"{what}: {peak}{numeral(1e3 * extent.displacement)} mm of {numeral(1e3 * far)} mm"


def _remedy(needed: Needed | None) -> str:
    if needed is None:
        return ""
    if needed.allowed is not False:
        return f"; both sides from {needed.text}"
    text = f"; both sides from {needed.text}, which is beyond the shaker"
    if not needed.bands_hz:
        return text
    bands = " and ".join(
        f"{numeral(low, 4)}-{numeral(high, 4)} Hz" for low, high in needed.bands_hz
    )
    return f"{text}; a sine within its limits does it in {bands}"


def _about_weight(planned: PlannedTest, wish: PlanWish) -> Iterator[str]:
    if planned.travel is None or planned.walls is None:
        return
    if not isinstance(wish.joint, FreeJoint):
        return
    peak = planned.travel.motion.acceleration
    if peak < STANDARD_GRAVITY:
        yield (
            f"{numeral(peak / STANDARD_GRAVITY)} g does not lift a part that its weight holds "
            "on one side, however far the table moves"
        )


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
    extent = reach(wish.joint, shaken, walls) if possible and walls is not None else None
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
        extent,
        _needed(test, shaken, extent, walls, wish) if extent and walls else None,
        duration,
        min(peaks, default=None),
        averages,
    )
    remarks = tuple(remarks_on(planned, wish, rate, modes))
    return replace(planned, warnings=remarks)


def _walls(joint: AbstractJoint, play: Play | None) -> Walls | None:
    joint_walls = joint.walls()
    if joint_walls is not None:
        return joint_walls
    if play is None or play.total <= 0.0:
        return None
    return Walls(play.half, play.half)


def _needed(
    test: Test, shaken: AbstractInput, extent: Reach, walls: Walls, wish: PlanWish
) -> Needed | None:
    factor = extent.factor_both_sides
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
