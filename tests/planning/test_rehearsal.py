"""A simulated campaign: what is written is what the log and the model say."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run

from shakerproc.comparison import compare, sentence
from shakerproc.data import STANDARD_GRAVITY as G
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import LogError
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.planning import Staging, rehearse, respond
from shakerproc.planning.rehearsal import low_passed
from shakerproc.recordings import open_recording
from shakerproc.runs import open_test
from shakerproc.simulation.pieces import finer
from shakerproc.testlog import read_testlog

RATE = 2560.0
MODEL = """\
model: 1
title: coupon
masses: {coupon: 28.6 g}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 3.6e4 N/m}
  - {kind: damper, between: [base, coupon], damping: 2.6 N s/m}
excitation: {base: acceleration}
sensors:
  ch3: {at: coupon, measures: acceleration}
  stretch: {at: coupon, measures: relative displacement}
"""
LOG = """\
testlog: 1
title: To be rehearsed
channels:
  control 1: {role: control}
  control 2: {role: control}
  response 1: {role: response, name: ch3, at: coupon}
  laser: {role: displacement, name: stretch, unit: um}
processing: {crop: {threshold: 0.2 g}}
expect: {sample_rate: 2560 Hz}
tests:
  - {id: 1, recording: T1/Acceleration.tdms, joint: radial, specimen: a, clearance: 0.1 mm,
     excitation: random, level: 0.01 g^2/Hz, from: 20 Hz, to: 800 Hz, expect: {duration: 7 s}}
  - {id: 2, recording: T2/Acceleration.tdms, joint: radial, specimen: a, clearance: 0.1 mm,
     excitation: sine sweep, level: 1 g, from: 100 Hz, to: 400 Hz, rate: 20 oct/min}
  - {id: 3, recording: T3/Acceleration.tdms, joint: radial, specimen: a, clearance: 0.1 mm,
     excitation: sine, level: 1 g, frequency: 100 Hz}
  - {id: 4, discarded: true, comment: operator error}
  - {id: 5, recording: T5/Acceleration.tdms, joint: radial, specimen: a, clearance: 0.1 mm,
     excitation: stepped sine, level: 1 g, from: 300 Hz, to: 100 Hz, rate: 30 oct/min}
  - {id: 6, recording: T6/Acceleration.tdms, joint: radial, specimen: a, clearance: 0.1 mm,
     excitation: random, level: 2 g rms, from: 20 Hz, to: 800 Hz, hold_out: true}
"""
STAGING = Staging(duration=4.0)


@pytest.fixture
def campaign(tmp_path):
    (tmp_path / "model.yaml").write_text(MODEL)
    (tmp_path / "log.yaml").write_text(LOG)
    return tmp_path


def read(campaign):
    return read_model(campaign / "model.yaml"), read_testlog(campaign / "log.yaml")


def test_a_resting_lead_in_and_what_the_log_asks_for(campaign):
    model, log = read(campaign)
    made = rehearse(model, log.find(1), replace(STAGING, noise={}))
    recording = made.recording
    assert recording.duration == pytest.approx(7.0)
    assert [c.name for c in recording.channels] == [
        "control 1",
        "control 2",
        "response 1",
        "laser",
    ]
    control, _, response, stretch = recording.samples()
    lead = round(0.4 * RATE)
    assert np.max(np.abs(control[:lead])) < 1e-3 * np.max(np.abs(control))
    run_part = control[round(0.7 * RATE) : round(6.3 * RATE)]
    assert_allclose(np.std(run_part), np.sqrt(0.01 * 780.0) * G, rtol=0.05)
    # Newton: the acceleration of the coupon is the force of the joint over its mass.
    velocity = np.gradient(stretch, 1.0 / RATE)
    force = 3.6e4 * stretch + 2.6 * velocity
    inner = slice(lead, -lead)
    apart = np.std((response + force / 28.6e-3)[inner]) / np.std(response[inner])
    assert apart < 0.05  # of np.gradient at up to a third of the sample rate


def test_a_sine_settles_to_the_closed_form(campaign):
    model, log = read(campaign)
    response = rehearse(model, log.find(3), replace(STAGING, noise={})).recording.samples()[2]
    omega = 2.0 * np.pi * 100.0
    stiff = 3.6e4 + 2.6j * omega
    gain = abs(stiff / (stiff - 28.6e-3 * omega**2))
    middle = response[round(2.0 * RATE) : round(4.0 * RATE)]
    assert_allclose(np.sqrt(2.0) * np.std(middle), gain * G, rtol=1e-4)


def heard(control):
    """Times [s] and frequencies [Hz] of the periods of a signal, from where it crosses 0."""
    up = np.flatnonzero((control[:-1] < 0.0) & (control[1:] >= 0.0))
    crossings = (up - control[up] / (control[up + 1] - control[up])) / RATE
    return 0.5 * (crossings[1:] + crossings[:-1]), 1.0 / np.diff(crossings)


def test_sweep_and_steps_pass_their_frequencies_when_they_should(campaign):
    model, log = read(campaign)
    silent = replace(STAGING, noise={})
    time, frequency = heard(rehearse(model, log.find(2), silent).recording.samples()[0])
    inside = (time > 0.8) & (time < 6.2)
    expected = 100.0 * 2.0 ** ((time[inside] - 0.5) / 3.0)
    assert_allclose(frequency[inside], expected, rtol=0.05)
    steps = rehearse(model, log.find(5), silent).recording
    time, frequency = heard(steps.samples()[0])
    for at, wanted in ((0.56, 300.0), (steps.duration - 0.8, 100.0)):
        near = np.abs(time - at) < 0.02
        assert_allclose(np.mean(frequency[near]), wanted, rtol=0.03)
    assert np.max(np.abs(steps.samples()[0])) == pytest.approx(G, rel=0.02)


def test_the_same_seed_gives_the_same_and_another_test_changes_nothing(campaign):
    model, log = read(campaign)
    one, again = (rehearse(model, log.find(6), STAGING).recording.samples() for _ in range(2))
    other = rehearse(model, log.find(6), replace(STAGING, seed=1)).recording.samples()
    assert np.array_equal(one, again)
    assert not np.allclose(one, other, atol=1e-3)
    (campaign / "log.yaml").write_text(
        LOG.replace("  - {id: 4, discarded: true, comment: operator error}\n", "")
    )
    _, shorter = read(campaign)
    assert np.array_equal(one, rehearse(model, shorter.find(6), STAGING).recording.samples())


def test_noise_and_offset_are_those_asked_for(campaign):
    model, log = read(campaign)
    clean = replace(STAGING, noise={})
    noisy = replace(STAGING, noise={"m/s^2": 0.5, "m": 1e-6}, offset={"m/s^2": 3.0})
    apart = (
        rehearse(model, log.find(6), noisy).recording.samples()
        - rehearse(model, log.find(6), clean).recording.samples()
    )
    assert_allclose(np.std(apart, axis=1), [0.5, 0.5, 0.5, 1e-6], rtol=0.05)
    means = np.abs(np.mean(apart, axis=1))
    assert np.all(means[:3] > 0.05)
    assert means[3] < 1e-7


def test_compare_of_the_same_model_finds_nothing_missing(campaign):
    wide = "1,2,5,6"  # a lone sine tells nothing of the noise that the resonance lifts
    arguments = ("simulate", campaign / "model.yaml", campaign / "log.yaml", "--tests", wide)
    assert run(*arguments) == 0
    without_sine = LOG.replace("recording: T3/Acceleration.tdms, ", "")
    (campaign / "log.yaml").write_text(without_sine)
    found = compare(*read(campaign))
    told = sentence(found)
    assert told.startswith("The model explains every test"), told
    for test in found.tests:
        for error, floor in zip(test.errors, test.floor.share, strict=True):
            assert error.error < 1.5 * float(floor)


def test_batch_works_the_rehearsal_through(campaign, capsys):
    target = campaign / "rehearsed"
    arguments = ("simulate", campaign / "model.yaml", campaign / "log.yaml", "--out", target)
    assert run(*arguments, "--tests", "1,2,6", "--json", campaign / "truth.json") == 0
    truth = json.loads((campaign / "truth.json").read_text())
    assert [one["test"] for one in truth["recordings"]] == [1, 2, 6]
    assert truth["schema"] == "shakerproc-simulation/1"
    assert (target / "log.yaml").read_text() == LOG
    log = read_testlog(target / "log.yaml")
    for identity in (1, 2, 6):
        with open_test(log, log.find(identity)) as recording:
            assert recording.channels[3].source_unit == "um"
    few = LOG.replace("recording: T3/", "discarded: true, recording: T3/")
    few = few.replace("recording: T5/", "discarded: true, recording: T5/")
    (target / "log.yaml").write_text(few)
    assert run("batch", target / "log.yaml", "--out", campaign / "results", "--no-figures") == 0
    assert "3 processed" in capsys.readouterr().out


def test_what_is_there_is_not_replaced(campaign, capsys):
    model, log = campaign / "model.yaml", campaign / "log.yaml"
    there = campaign / "recordings" / "T3" / "Acceleration.tdms"
    there.parent.mkdir(parents=True)
    there.write_bytes(b"measured")
    assert run("simulate", model, log) == 1
    assert "are there already" in capsys.readouterr().err.replace("is there", "are there")
    assert there.read_bytes() == b"measured"
    assert [p.name for p in (campaign / "recordings").rglob("*.tdms")] == ["Acceleration.tdms"]
    assert run("simulate", model, log, "--tests", "3", "--overwrite") == 0
    assert there.read_bytes() != b"measured"


def test_a_campaign_that_is_refused_leaves_no_copy_of_its_log(campaign, capsys):
    mode = "{frequency: 9 kHz, damping_ratio: 0.01, shape: [1], participation: 1 sqrt(kg)}"
    arm = f"structures:\n  arm: {{points: [end], modes: [{mode}]}}\nelements:"
    model = (campaign / "model.yaml").read_text("utf-8").replace("elements:", arm)
    (campaign / "arm.yaml").write_text(model, "utf-8")
    given = (campaign / "arm.yaml", campaign / "log.yaml", "--tests", "6")
    assert run("simulate", *given, "--out", campaign / "refused") == 1
    assert "beyond half the sample rate" in capsys.readouterr().err
    assert not (campaign / "refused").exists()


def test_a_recording_shakes_another_model(campaign):
    assert run("simulate", campaign / "model.yaml", campaign / "log.yaml", "--tests", "6") == 0
    recorded = campaign / "recordings" / "T6" / "Acceleration.tdms"
    target = campaign / "again"
    assert (
        run("simulate", campaign / "model.yaml", recorded, "--out", target, "--noise", "0 g")
        == 0
    )
    with (
        open_recording(target / "Acceleration_simulated.tdms") as made,
        open_recording(recorded) as first,
    ):
        assert_allclose(made.samples()[2], first.samples()[2], atol=1.0)


def test_channels_by_number_and_in_volts_are_read_as_they_were_meant(campaign):
    (campaign / "log.yaml").write_text(
        LOG.replace("response 1: {", "4: {sensitivity: 100 mV/g, ").replace("laser", "2")
    )
    model, log = read(campaign)
    assert run("simulate", campaign / "model.yaml", campaign / "log.yaml", "--tests", "3") == 0
    with open_test(log, log.find(3)) as recording:
        by_name = dict(
            zip((c.name for c in recording.channels), recording.samples(), strict=True)
        )
    plain = rehearse(model, log.find(3), replace(STAGING, noise={}, duration=10.0))
    assert_allclose(by_name["ch3"], plain.simulation.outputs["ch3"][::4], atol=0.5)
    assert_allclose(by_name["stretch"], plain.simulation.outputs["stretch"][::4], atol=1e-7)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("level: 1 g, frequency", "level: 20 N, frequency", "drives the model"),
        ("response 1: {role: response, name: ch3, at: coupon}",
         "response 1: {role: response, name: ch9, at: rim}", "does not say what channel 'ch9'"),
        ("excitation: sine, level: 1 g, frequency: 100 Hz", "comment: none",
         "does not say what shakes it"),
        ("frequency: 100 Hz}", "frequency: 100 Hz, expect: {duration: 0.5 s}}",
         "before and after takes"),
    ],
)  # fmt: skip
def test_a_log_that_does_not_fit_is_told_in_one_line(campaign, old, new, message):
    assert old in LOG
    (campaign / "log.yaml").write_text(LOG.replace(old, new))
    model, log = read(campaign)
    with pytest.raises(LogError, match=message) as caught:
        rehearse(model, log.find(3), STAGING)
    assert "\n" not in str(caught.value)
    assert "log.yaml:" in str(caught.value)


def test_a_recording_without_controls_shakes_nothing(campaign):
    model, log = read(campaign)
    made = rehearse(model, log.find(3), STAGING).recording
    with pytest.raises(LogError, match="no channel with the role control"):
        respond(model, made.select([2, 3]), STAGING)


def test_a_recording_that_begins_in_motion_is_not_rung_at_its_ends():
    """There and back: finer steps of a sine that is cut off, then the recorder's filter."""
    time = np.arange(4000) / RATE
    wave = np.cos(2.0 * np.pi * 133.0 * time) + 0.3 * time
    fine = finer(wave, 4, 0, beyond=4 - 1)[0]
    expected = np.cos(2.0 * np.pi * 133.0 * np.arange(16000) / (4.0 * RATE))
    expected += 0.3 * np.arange(16000) / (4.0 * RATE)
    assert_allclose(fine[200:-200], expected[200:-200], atol=2e-3)
    assert_allclose(fine[:15996], expected[:15996], atol=0.05)
    assert_allclose(low_passed(fine, 4), wave, atol=0.05)


def test_a_mass_that_slides_all_along_is_recorded_as_a_square_wave_without_what_folds_back():
    r"""Dry friction alone: :math:`a = \pm F / m`, its Fourier series in closed form.

    The harmonic of order 59 lies 210 Hz below four times the sample rate.
    """
    mass, friction, frequency = 0.5, 2.0, 170.0
    laws = (EFFECTS["spring"](100.0), EFFECTS["coulomb_friction"](friction))
    model = Model(
        "sliding", {"m": mass}, tuple(Element(law, ("base", "m")) for law in laws),
        Excitation("base acceleration"), {"a": Sensor("m")},
    )  # fmt: skip
    time = np.arange(int(2.0 * RATE)) / RATE
    shaken = 40.0 * np.sin(2.0 * np.pi * frequency * time) * np.minimum(time / 0.3, 1.0)
    channel = Channel("control", "m/s^2", "control", "m/s^2", "control")
    recording = recording_of_arrays("shaken", [channel], shaken[np.newaxis], RATE)
    made = respond(
        model, recording, replace(STAGING, noise={"m/s^2": 0.0}, growth=False)
    ).recording
    row = made.samples()[-1, -int(RATE) :]
    lines = 2.0 * np.abs(np.fft.rfft(row)) / RATE
    first = 4.0 * friction / (np.pi * mass)
    assert_allclose(lines[[170, 510]], [first, first / 3.0], rtol=0.02)
    assert lines[210] < 0.1 * first / 59.0
