"""Facts of a test in the log, as the columns of every table."""

from typing import Final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.testlog.excitation import LevelUnit
from shakerproc.testlog.one_test import Fact, Test

_LEVELS: Final[tuple[tuple[LevelUnit, str, float], ...]] = (
    ("m/s^2", "level_g", STANDARD_GRAVITY),
    ("(m/s^2)^2/Hz", "level_g2_per_hz", STANDARD_GRAVITY**2),
    ("m/s^2 rms", "level_g_rms", STANDARD_GRAVITY),
    ("N", "level_n", 1.0),
    ("N^2/Hz", "level_n2_per_hz", 1.0),
    ("N rms", "level_n_rms", 1.0),
    ("rad/s^2", "level_rad_per_s2", 1.0),
    ("(rad/s^2)^2/Hz", "level_rad2_per_s4_per_hz", 1.0),
    ("rad/s^2 rms", "level_rad_per_s2_rms", 1.0),
    ("N m", "level_nm", 1.0),
    ("(N m)^2/Hz", "level_nm2_per_hz", 1.0),
    ("N m rms", "level_nm_rms", 1.0),
)
_OTHERS: Final = ("test", "id", "recording", "channel", "status", "sha256", "error")
"""Further columns that tables have, from elsewhere."""


def facts_of(test: Test) -> dict[str, Fact]:
    """Return the columns of a test: units in the names, tags last, None where nothing is said.

    Levels stand in the column of their kind: ``level_g`` (amplitude), ``level_g2_per_hz``,
    ``level_g_rms``, ``level_n``, ``level_rad_per_s2``, ``level_nm`` and so on; ``level`` is as
    written.
    """
    return {
        "joint": test.joint,
        "specimen": test.specimen,
        "clearance_m": test.clearance,
        "actual_clearance_m": test.actual_clearance,
        "actual_axial_clearance_m": test.actual_axial_clearance,
        "orientation": test.orientation,
        "excitation": test.excitation or "",
        "level": test.level_text,
        **_level(test),
        "from_hz": test.from_hz,
        "to_hz": test.to_hz,
        "rate_oct_per_min": test.rate_oct_per_min,
        "excitation_hz": test.frequency_hz,
        "notch_hz": test.notch_hz,
        "hold_out": test.hold_out,
        "discarded": test.discarded,
        "comment": test.comment,
        **test.tags,
    }


def reserved_names() -> frozenset[str]:
    """Return the names that no tag may take: those of the columns that every table has."""
    plain = facts_of(Test(id=0))
    levels = [column for _, column, _ in _LEVELS]
    return frozenset([*plain, *levels, *_OTHERS])


def _level(test: Test) -> dict[str, Fact]:
    columns: dict[str, Fact] = {}
    for unit, column, scale in _LEVELS:
        if unit == test.level_unit and test.level is not None:
            # Twelve digits: 15 g written is 15 g shown, not 15.000000000000002.
            columns[column] = float(f"{test.level / scale:.12g}")
    return columns
