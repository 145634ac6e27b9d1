"""The tests that a diagnosis asks for, as lines of the log."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import sqrt
from typing import Final

from shakerproc.errors import LogError
from shakerproc.numerals import numeral
from shakerproc.testlog import Expectation, Test, TestLog, level_of
from shakerproc.testlog.excitation import amplitude_unit

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
