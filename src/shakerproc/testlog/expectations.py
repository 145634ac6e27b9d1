"""A recording against what the log says it must be."""

import math
from collections.abc import Iterator

from shakerproc.data import Recording
from shakerproc.errors import LogError
from shakerproc.testlog.one_test import Test
from shakerproc.units import is_same_unit, quoted

RATE_TOLERANCE = 1e-4
"""How far a sample rate may be off what the log expects, as a share [-]."""


def check_expectation(test: Test, recording: Recording) -> None:
    """Pass a recording that is what the log says.

    Raises
    ------
    LogError
        If it is not; with everything that differs.
    """
    found = list(_departures(test, recording))
    if found:
        raise LogError(
            f"{test.source}: test {test.id}: {'; '.join(found)}; correct the log, or look "
            "whether this is the recording of that test"
        )


def nominal_duration(test: Test) -> float | None:
    """Return how long the sweep of a test takes at its rate [s], None for other tests."""
    if test.from_hz is None or test.to_hz is None:
        return None
    if test.rate_oct_per_min is not None:
        return abs(math.log2(test.to_hz / test.from_hz)) / test.rate_oct_per_min * 60.0
    if test.rate_hz_per_s is not None:
        return abs(test.to_hz - test.from_hz) / test.rate_hz_per_s
    return None


def _departures(test: Test, recording: Recording) -> Iterator[str]:
    expect = test.expect
    if expect.duration is not None:
        yield from _apart("s", expect.duration, recording.duration, expect.duration_tolerance)
    if expect.sample_rate is not None:
        yield from _apart("Hz", expect.sample_rate, recording.sample_rate, RATE_TOLERANCE)
    if expect.channels is not None:
        yield from _other_count(expect.channels, recording)
    if expect.unit is not None:
        yield from _other_units(expect.unit, recording)
    if expect.sha256 is not None and recording.file is not None:
        yield from _other_hash(expect.sha256, recording.file.first_sha256())


def _apart(unit: str, wanted: float, found: float, tolerance: float) -> Iterator[str]:
    if abs(found - wanted) > tolerance * wanted:
        yield f"the log expects {wanted:.7g} {unit}, the recording has {found:.7g} {unit}"


def _other_count(wanted: int, recording: Recording) -> Iterator[str]:
    used = len(recording.channels)
    found = used if recording.in_file is None else recording.in_file
    if found != wanted:
        counted = f"all of them counted; {used} are used" if used != found else "all are used"
        yield f"the log expects {wanted} channels, the recording has {found} ({counted})"


def _other_units(wanted: str, recording: Recording) -> Iterator[str]:
    for channel in recording.channels:
        if not is_same_unit(channel.source_unit, wanted):
            yield (
                f"the log expects channel {quoted(channel.name)} in {wanted}, "
                f"the recording has it in {quoted(channel.source_unit)}"
            )


def _other_hash(wanted: str, found: str) -> Iterator[str]:
    if found != wanted:
        yield f"the log expects SHA-256 {wanted[:12]}..., the file has {found[:12]}..."
