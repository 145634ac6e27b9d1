"""Sine on random: tones and floor judged apart, against simulated truth."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.runs.test_multisine import G

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.runs import process_recording, summary_of
from shakerproc.testlog import Processing, Profile, Test, Welch
from shakerproc.testlog.excitation import DemandedTone

RATE, SECONDS, FLOOR = 1024.0, 20.0, 0.01
TIME = np.arange(int(RATE * SECONDS)) / RATE
CHANNELS = tuple(
    Channel(name, "m/s^2", name, "g", role)
    for name, role in (("table", "control"), ("ch3", "response"))
)
TONES = ((17.3, 2.5), (34.6, 1.5), (51.9, 1.0), (69.2, 0.8))
FLAT = Profile(
    "flat", "(m/s^2)^2/Hz", (10.0, 400.0), (FLOOR * G**2,) * 2, (3.0, 3.0), (6.0, 6.0)
)


def floor_of(seed=1, density=FLOOR):
    """White noise of a known one-sided density [g²/Hz]: variance over half the rate."""
    return np.random.default_rng(seed).normal(0.0, np.sqrt(density * RATE / 2.0), TIME.size)


def tones_of(tones=TONES):
    return sum(a * np.sin(2.0 * np.pi * hz * TIME + hz) for hz, a in tones)


def processed(
    control, excitation="sine on random", *, stated=TONES, profile=None, response=3.0
):
    rows = G * np.array([control, response * control])
    test = Test(
        1,
        excitation=excitation,
        from_hz=10.0,
        to_hz=400.0,
        level=None if profile else FLOOR * G**2,
        level_unit=None if profile else "(m/s^2)^2/Hz",
        profile=profile,
        tones=tuple(DemandedTone(hz, G * a) for hz, a in stated),
        processing=Processing(crop=None, welch=Welch(segment=1024, overlap=512)),
    )
    return process_recording(recording_of_arrays("run", CHANNELS, rows, RATE), test)


def tones_in(result):
    (one,) = [one for one in result.analyses if one.kind == "tones"]
    return one


@pytest.mark.parametrize("stated", [TONES, ()])
def test_tones_and_floor_are_those_that_were_simulated(stated):
    result = processed(floor_of() + tones_of(), stated=stated)
    rows = tones_in(result).summary
    assert_allclose([r["frequency_hz"] for r in rows], [hz for hz, _ in TONES], atol=2e-3)
    # the density over the length is the variance of the amplitude of a sine fitted to noise
    chance = np.sqrt(FLOOR / SECONDS)
    assert_allclose([r["amplitude"] for r in rows], [a for _, a in TONES], atol=3.5 * chance)
    assert_allclose([r["amplitude_error"] for r in rows], 1.96 * chance, rtol=0.5)
    assert {r["kept"] for r in rows} == ({True} if stated else {None})
    columns = tones_in(result).columns
    assert_allclose(
        columns["amplitude_ch3_g"], 3.0 * np.array(columns["amplitude_table_g"]), rtol=1e-6
    )
    assert result.averages.measured_level.shown[0] == pytest.approx(FLOOR, rel=0.03)
    assert summary_of(result, "1", {}, "", "").control.kept
    assert not {flag.kind for flag in result.flags} & {"level", "control density", "tones"}


def test_the_profile_is_kept_by_the_floor_and_broken_by_a_floor_that_is_wrong():
    def told(density, excitation, stated):
        control = floor_of(2, density) + tones_of()
        result = processed(control, excitation, stated=stated, profile=FLAT)
        return next(one.sentences[0] for one in result.analyses if one.kind == "profile")

    assert told(FLOOR, "sine on random", TONES) == "Profile flat: kept."
    assert "NOT KEPT" in told(FLOOR, "random", ())
    assert "NOT KEPT" in told(5.0 * FLOOR, "sine on random", TONES)


def test_a_tone_too_weak_and_one_that_is_not_there_are_told_each():
    control = floor_of(3) + tones_of(((17.3, 2.0), *TONES[1:3]))
    problems = tones_in(processed(control)).problems
    assert len(problems) == 2
    assert "demanded at 17.3 Hz is 2" in problems[0]
    assert "where 2.5 g is demanded (tolerance 15 %, 1 Hz)" in problems[0]
    assert "demanded at 69.2 Hz" in problems[1]


def test_a_tone_whose_amplitude_swells_is_said_not_to_be_fixed():
    swelling = (0.5 + 1.5 * TIME / SECONDS) * np.sin(2.0 * np.pi * 100.0 * TIME)
    (problem,) = tones_in(processed(floor_of(4) + swelling, stated=((100.0, 1.25),))).problems
    assert "moves by up to" in problem
    assert "Only fixed tones" in problem


def test_a_tone_that_sweeps_is_refused_with_what_to_declare():
    swept = 3.0 * np.sin(2.0 * np.pi * (20.0 + 2.0 * TIME) * TIME)
    with pytest.raises(SpectrumError, match="no tone of fixed frequency, and other tones"):
        processed(floor_of(5) + swept, stated=())


def test_tones_that_segments_do_not_tell_apart_ask_for_longer_ones():
    near = ((50.0, 1.0), (51.0, 1.0))
    with pytest.raises(SpectrumError, match=r"50 and 51 Hz are not told apart .* take longer"):
        processed(floor_of(6) + tones_of(near), stated=near)


def test_a_random_test_with_tones_is_told_what_to_declare():
    result = processed(floor_of() + tones_of(), "random", stated=())
    assert any("excitation: sine on random" in note for note in result.notes)
