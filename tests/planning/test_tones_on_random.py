"""Tones on random vibration before the test: played with the rest, and left out of the plan."""

import numpy as np
import pytest
from tests.in_process import completed

from shakerproc.errors import LogError
from shakerproc.planning.drive import drive_of_test
from shakerproc.planning.plan import PlanWish
from shakerproc.planning.planned import plan_campaign
from shakerproc.testlog import Test, read_testlog
from shakerproc.testlog.excitation import DemandedTone

G, RATE, SECONDS, FLOOR = 9.80665, 2048.0, 40.0, 0.01
TONES = ((17.25, 2.5), (34.5, 1.5))


def sine_on_random(tones=TONES):
    return Test(
        1, excitation="sine on random", level=FLOOR * G**2, level_unit="(m/s^2)^2/Hz",
        from_hz=10.0, to_hz=500.0, tones=tuple(DemandedTone(f, a and a * G) for f, a in tones),
    )  # fmt: skip


def test_tones_are_played_beside_the_random_vibration():
    """A periodogram of whole periods: amplitudes in the bins of the tones, the floor beside."""
    played = drive_of_test(sine_on_random(), SECONDS, RATE, np.random.default_rng(1)) / G
    middle = played[int(4 * RATE) : int(36 * RATE)]  # whole periods of each tone, unfaded
    lines = 2.0 * np.abs(np.fft.rfft(middle)) / middle.size
    places = [round(f * 32.0) for f, _ in TONES]
    chance = np.sqrt(FLOOR / 32.0)  # of an amplitude, from the density over the length
    assert lines[places] == pytest.approx([a for _, a in TONES], abs=4.0 * chance)
    density = float(np.mean(0.5 * lines[60 * 32 : 450 * 32] ** 2)) * 32.0
    assert density == pytest.approx(FLOOR, rel=0.05)


@pytest.mark.parametrize("tones", [(), ((17.25, None),)])
def test_tones_that_the_log_does_not_say_cannot_be_played(tones):
    with pytest.raises(LogError, match="frequency and level of every tone"):
        drive_of_test(sine_on_random(tones), SECONDS, RATE, np.random.default_rng(1))


LOG = """\
testlog: 1
channels: {table: {role: control}, coupon: {role: response, at: coupon}}
tests:
  - {id: 1, recording: a.tdms, excitation: sine on random, level: 0.01 g^2/Hz, from: 10 Hz,
     to: 500 Hz, tones: [{frequency: 17.25 Hz, level: 2.5 g}]}
  - {id: 2, recording: b.tdms, excitation: sine on random, level: 0.01 g^2/Hz, from: 10 Hz,
     to: 500 Hz}
  - {id: 3, recording: c.tdms, excitation: hammer}
  - {id: 4, recording: d.tdms, excitation: measured}
"""
MODEL = """\
model: 1
masses: {coupon: 200 g}
elements: [{kind: spring, between: [base, coupon], stiffness: 1.1e5 N/m}]
excitation: {base: acceleration}
sensors: {coupon: {at: coupon, measures: acceleration}}
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "log.yaml").write_text(LOG, encoding="utf-8")
    (tmp_path / "model.yaml").write_text(MODEL, encoding="utf-8")
    return tmp_path


def test_a_plan_leaves_tones_on_random_vibration_out_and_says_why(files):
    first, *_ = plan_campaign(read_testlog(files / "log.yaml"), PlanWish())
    assert first.shaken is None
    assert first.travel is None
    (told,) = first.warnings
    assert told.startswith("left out: how far tones on random vibration move table")


def test_simulate_leaves_out_what_no_log_says_and_plays_the_rest(files):
    left = completed(
        "simulate", files / "model.yaml", files / "log.yaml", "--out", files / "out",
        "--duration-s", "2",
    )  # fmt: skip
    assert left.returncode == 0, left.stderr
    assert [path.name for path in (files / "out").rglob("*.tdms")] == ["a.tdms"]
    told = [line for line in left.stderr.splitlines() if "left out" in line]
    assert [line.partition("left out: ")[2][:20] for line in told] == [
        "the log does not say", "a hammer: its width ", "what shakes it stand",
    ]  # fmt: skip


def test_a_test_that_is_asked_for_and_cannot_be_played_is_an_error(files):
    left = completed("simulate", files / "model.yaml", files / "log.yaml", "--tests", "3")
    assert left.returncode == 1
    assert len(left.stderr.strip().splitlines()) == 1
    assert (
        "test 3: a hammer: its width is no key of the log; leave this test out" in left.stderr
    )
    assert not list(files.glob("*.tdms"))
