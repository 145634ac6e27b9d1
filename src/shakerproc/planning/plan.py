"""Wishes of a plan, one row of it for each test, and the tests that a diagnosis asks for."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, Final, final

from shakerproc.errors import LogError
from shakerproc.numerals import numeral
from shakerproc.planning.drive import (
    Averaging,
)
from shakerproc.planning.joints import AbstractJoint, FreeJoint, Play, Walls, Warming, Which
from shakerproc.planning.reach import Band, Reach
from shakerproc.planning.shaker import AbstractInput, ShakerLimits, TableMotion
from shakerproc.testlog import Expectation, Test, TestLog, level_of
from shakerproc.testlog.excitation import amplitude_unit
from shakerproc.testlog.log import facts_of

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


def plan_columns(plans: Sequence[PlannedTest]) -> dict[str, list[Any]]:
    """Return a column of each quantity, a row for each test; units in the names."""
    rows = [_row(planned) for planned in plans]
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {name: [row.get(name) for row in rows] for name in names}


def plan_documents(plans: Sequence[PlannedTest]) -> list[dict[str, Any]]:
    """Return each test as a document, bands and warnings as lists."""
    return [
        {
            **_row(planned),
            "one_side_hz": planned.reach.one_side_hz if planned.reach else (),
            "both_sides_hz": planned.reach.both_sides_hz if planned.reach else (),
            "within_limits_hz": planned.needed.bands_hz if planned.needed else (),
            "warnings": planned.warnings,
        }
        for planned in plans
    ]


def bands_text(bands: Sequence[Band]) -> str:
    """Return bands as people write them [Hz]."""
    return ", ".join(
        f"{numeral(low, 4)}-{numeral(high, 4)}" if low < high else numeral(low, 4)
        for low, high in bands
    )


def _row(planned: PlannedTest) -> dict[str, Any]:
    test, reach, needed = planned.test, planned.reach, planned.needed
    return {
        "test": test.id,
        "status": "discarded" if test.discarded else "planned",
        **facts_of(test),
        "duration_s": planned.duration,
        **_travel(planned),
        "free_play_positive_m": planned.walls.positive if planned.walls else None,
        "free_play_negative_m": planned.walls.negative if planned.walls else None,
        "joint_displacement_m": reach.displacement if reach else None,
        "joint_displacement_at_hz": reach.at_hz if reach else None,
        "contact": reach.contact if reach else None,
        "one_side_hz": bands_text(reach.one_side_hz) if reach else None,
        "both_sides_hz": bands_text(reach.both_sides_hz) if reach else None,
        "contacts_per_second": reach.contacts_per_second if reach else None,
        "level_for_both_sides": needed.text if needed else None,
        "level_allowed": needed.allowed if needed else None,
        "swept_peak": planned.swept_peak,
        "averages": planned.averaging.averages if planned.averaging else None,
        "density_random_error": planned.averaging.density_error if planned.averaging else None,
        "gain_random_error": planned.averaging.gain_error if planned.averaging else None,
        "warnings": "; ".join(planned.warnings),
    }


def _travel(planned: PlannedTest) -> dict[str, Any]:
    travel = planned.travel
    if travel is None:
        return {}
    return {
        "table_acceleration_m_per_s2": travel.motion.acceleration,
        "table_velocity_m_per_s": travel.motion.velocity,
        "table_displacement_m": travel.motion.displacement,
        "table_rms_displacement_m": travel.rms_displacement,
        "play_m": travel.play.total if travel.play else None,
        "play_is": travel.play.says if travel.play else None,
        "table_over_half_play": travel.ratio,
        "table_half_play_to_hz": travel.both_sides_to_hz,
        "table_whole_play_to_hz": travel.whole_play_to_hz,
    }


SCHEMA: Final = "shakerproc-diagnosis/1"


def suggested_tests(document: object, log: TestLog, source: str) -> tuple[Test, ...]:
    """Return the tests that a diagnosis asks for, each like one of the log but for its level.

    Parameters
    ----------
    document : object
        The diagnosis, as its JSON says it.
    log : TestLog
        Lends joint and clearance, and frequencies where none are given: the test that is
        named, else the last of the same excitation, else the last of all.
    source : str
        File of the diagnosis, for messages.

    Raises
    ------
    LogError
        If it is no diagnosis, or asks for what the log knows nothing of.
    """
    if not isinstance(document, Mapping) or document.get("schema") != SCHEMA:
        raise LogError(
            f"{source}: expected a diagnosis ({SCHEMA}); write one with diagnose --json"
        )
    wanted = document.get("next_test", [])
    if not isinstance(wanted, list) or not all(isinstance(one, Mapping) for one in wanted):
        raise LogError(
            f"{source}: next_test is no list of tests; write it with diagnose --json"
        )
    return tuple(_test(one, number, log, source) for number, one in enumerate(wanted, 1))


def _test(one: Mapping[str, object], number: int, log: TestLog, source: str) -> Test:
    said, written = str(one.get("excitation", "")), str(one.get("level", ""))
    like = _like(str(one.get("like") or said), log) or _like(said, log)
    if like is None and log.active:
        last = replace(log.active[-1], rate_hz_per_s=None, frequency_hz=None)
        if said == "random":
            like = replace(last, excitation="random", rate_oct_per_min=None)
        elif said == "sine sweep":
            like = replace(last, excitation="sine sweep", rate_oct_per_min=1.0)
    if like is None:
        raise LogError(
            f"{source}: next_test {number} is shaken by {said!r}, but no test of {log.path} "
            f"is; give the log of the diagnosed campaign"
        )
    try:
        level, unit = level_of(written, like.excitation)
        text = written
    except ValueError:
        try:  # of a sine, an rms value says the amplitude
            level, unit = level_of(written, "random")
        except ValueError as error:
            raise LogError(f"{source}: next_test {number}: {error}") from error
        if not unit.endswith("rms"):
            raise LogError(
                f"{source}: next_test {number}: {written} is no level of a {like.excitation}"
            ) from None
        level *= sqrt(2.0)
        unit = amplitude_unit(unit)
        text = f"{written} (amplitude {numeral(sqrt(2.0), 4)} times that)"
    band = one.get("band_hz")
    if isinstance(band, Sequence) and len(band) == 2 and not one.get("like"):
        like = replace(like, from_hz=float(band[0]), to_hz=float(band[1]))
    separates = one.get("separates", ())
    named = [str(kind) for kind in separates] if isinstance(separates, Sequence) else []
    return replace(
        like,
        id=f"next {number}",
        recording=None,
        level=level,
        level_unit=unit,
        level_text=text,
        discarded=False,
        hold_out=False,
        expect=Expectation(sample_rate=like.expect.sample_rate, duration=like.expect.duration),
        comment=f"separates {' and '.join(named)}" if named else str(one.get("reason", "")),
        tags={},
    )


def _like(said: str, log: TestLog) -> Test | None:
    """Return the test that is named, or the last one of the same excitation."""
    active = log.active
    name = re.sub(r"^test\s+", "", said.strip(), flags=re.IGNORECASE)
    for test in active:
        if str(test.id) == name.split(" (")[0]:
            return test
    return next((test for test in reversed(active) if test.excitation == said), None)
