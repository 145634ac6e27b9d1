"""The plan as columns of a table and as a document."""

from collections.abc import Sequence
from typing import Any

from shakerproc.numerals import numeral
from shakerproc.planning.plan import PlannedTest
from shakerproc.planning.reach import Band
from shakerproc.testlog.log import facts_of


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
