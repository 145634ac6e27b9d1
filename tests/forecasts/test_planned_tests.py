"""Planned tests and limits of a log: what is read, what is refused, who leaves them out."""

import pytest
from numpy.testing import assert_allclose

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

HEAD = """\
testlog: 1
channels: {control: {role: control}, r1: {role: response, name: ch3}}
"""
RUN = (
    "{id: 1, recording: a.tdms, excitation: random, level: 0.01 g^2/Hz, from: 20 Hz, to: 1 kHz}"
)
PLANNED = "id: 2, planned: true, excitation: random, level: 0.04 g^2/Hz, from: 20 Hz, to: 1 kHz"


def log_of(tmp_path, test=f"{PLANNED}, duration: 60 s", limits="{}"):
    (tmp_path / "recordings").mkdir(exist_ok=True)
    path = tmp_path / "log.yaml"
    text = f"{HEAD}limits: {limits}\ntests:\n  - {RUN}\n  - {{{test}}}\n"
    path.write_text(text, encoding="utf-8")
    return read_testlog(path)


def test_a_planned_test_is_no_test_that_was_run(tmp_path):
    log = log_of(tmp_path)
    assert [test.id for test in log.tests] == [test.id for test in log.active] == [1]
    (planned,) = log.planned
    assert (planned.id, planned.duration) == (2, 60.0)
    assert "test 2 is planned" in log.left_out[0]


@pytest.mark.parametrize(
    ("test", "told"),
    [
        (f"{PLANNED}, duration: 60 s, recording: b.tdms", "expected no recording"),
        (PLANNED, 'expected the key "duration"'),
        ("id: 2, planned: true, excitation: random, from: 20 Hz, to: 1 kHz, duration: 60 s",
         'expected the key "level" or "profile"'),
        ("id: 2, planned: true, excitation: sine sweep, level: 1 g, from: 20 Hz, to: 1 kHz",
         'expected the key "rate"'),
        ("id: 2, planned: true, excitation: shock, level: 1 g", "expected excitation"),
        ("id: 2, planned: true, level: 1 g", "got none"),
        ("id: 2, excitation: random, level: 1 g rms, from: 20 Hz, to: 1 kHz, duration: 60 s",
         "means something for planned: true only"),
        ("id: 2, planned: true, excitation: sine sweep, level: 1 g, from: 20 Hz, to: 1 kHz, "
         "rate: 2 oct/min, duration: 60 s", "beside rate"),
    ],
)  # fmt: skip
def test_a_planned_test_that_does_not_say_all_is_refused_at_its_line(tmp_path, test, told):
    with pytest.raises(DocumentError, match=told) as raised:
        log_of(tmp_path, test)
    assert raised.value.line == 6


def test_limits_are_read_in_si_with_what_they_are_of(tmp_path):
    limits = (
        "{ch3: [40 g peak, 8 g rms], joint base-coupon: 0.3 mm, joint m1-m2: 2 kN peak, "
        "force: 500 N, shaker: {force: 9 kN, velocity: 1.8 m/s}}"
    )
    found = log_of(tmp_path, limits=limits).limits
    assert [(one.whose, one.name, one.statistic, one.unit) for one in found] == [
        ("response", "ch3", "peak", "m/s^2"), ("response", "ch3", "rms", "m/s^2"),
        ("joint", "base-coupon", "peak", "m"), ("joint", "m1-m2", "peak", "N"),
        ("force", "", "peak", "N"), ("shaker", "force", "peak", "N"),
        ("shaker", "velocity", "peak", "m/s"),
    ]  # fmt: skip
    wanted = [40 * STANDARD_GRAVITY, 8 * STANDARD_GRAVITY, 3e-4, 2e3, 500.0, 9e3, 1.8]
    assert_allclose([one.value for one in found], wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        ("{ch4: 40 g}", 'got "ch4"; the log has control, ch3'),
        ("{ch3: 40}", "unit is missing"),
        ("{ch3: -40 g}", "expected more than 0"),
        ("{ch3: {peak: 40 g}}", "expected a limit such as 40 g peak"),
        ("{joint base-coupon: 3 g}", "expected a number with a unit of m"),
        ("{shaker: 9 kN}", "expected keys such as"),
        ("{shaker: {power: 9 kN}}", "expected one of force"),
    ],
)
def test_a_limit_that_cannot_be_judged_is_refused_at_its_line(tmp_path, limits, told):
    with pytest.raises(DocumentError, match=told) as raised:
        log_of(tmp_path, limits=limits)
    assert raised.value.line == 3
