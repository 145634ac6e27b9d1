"""A disc on a torsion spring: angles, torques and moments of inertia from file to model."""

import json

import numpy as np
import pytest
import scipy
from numpy.testing import assert_allclose

import shakerproc as sp
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import DocumentError
from shakerproc.model_files import add_element, model_text, read_model
from shakerproc.models.effects import Gap
from shakerproc.models.model import Element
from shakerproc.recordings import open_recording
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.processing import Orders

RATE = 1000.0
INERTIA, STIFFNESS, DAMPING = 0.02, 1200.0, 0.4

TURNING = f"""\
model: 1
masses: {{disc: {INERTIA} kg m^2}}
elements:
  - {{kind: spring, between: [base, disc], stiffness: {STIFFNESS} N m/rad}}
  - {{kind: damper, between: [base, disc], damping: {DAMPING} N m s/rad}}
excitation: {{base: acceleration}}
sensors: {{disc: {{at: disc, measures: acceleration}}}}
"""
MOVING = TURNING.replace("kg m^2", "kg").replace("N m/rad", "N/m").replace("N m s/rad", "N s/m")


def campaign(folder, unit):
    """A log with one run: the base shaken at random, and what a torsional oscillator does."""
    rng = np.random.default_rng(3)
    finer = 20  # the filter joins samples by straight lines
    time = np.arange(4000 * finer) / (finer * RATE)
    lines = rng.uniform(0.0, 2.0 * np.pi, 60)
    at = 2.0 * np.pi * (5.0 + np.arange(60))
    base = sum(np.cos(w * time + phase) for w, phase in zip(at, lines, strict=True))
    base *= np.minimum(1.0, time)  # from rest
    system = ([DAMPING, STIFFNESS], [INERTIA, DAMPING, STIFFNESS])
    b, a, _ = scipy.signal.cont2discrete(system, 1.0 / (finer * RATE), "foh")
    response = scipy.signal.lfilter(b[0], a, base)
    rows = np.array([time, base, response]).T[::finer]
    header = f"time [s],shaft [{unit}],disc [{unit}]"
    (folder / "recordings").mkdir(parents=True)
    np.savetxt(
        folder / "recordings" / "run.csv", rows, "%.12g", ",", header=header, comments=""
    )
    log = folder / "log.yaml"
    log.write_text(
        "testlog: 1\nrecordings: recordings\n"
        "channels: {shaft: {role: control}, disc: {role: response}}\n"
        "processing: {crop: none}\n"
        f"tests:\n  - {{id: 1, recording: run.csv, excitation: random, level: 5 {unit} rms, "
        "from: 5 Hz, to: 64 Hz}\n"
    )
    return log


def compared(folder, model, unit):
    log = campaign(folder, unit)
    (folder / "model.yaml").write_text(model)
    return sp.compare(sp.read_model(folder / "model.yaml"), sp.read_log(log))


def test_a_rotation_is_the_translation_with_the_same_numbers(tmp_path):
    (turned,) = compared(tmp_path / "turned", TURNING, "rad/s^2").found.tests[0].errors
    (moved,) = compared(tmp_path / "moved", MOVING, "m/s^2").found.tests[0].errors
    assert turned.error == pytest.approx(moved.error, rel=1e-6)  # nine digits of the files
    assert turned.error < 3e-3  # against that filter


def test_angles_in_degrees_are_served_in_radians(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time [s],disc [deg/s^2],torque [Nm]\n0,180,1\n0.001,0,2\n0.002,-90,3\n")
    with open_recording(path) as recording:
        assert [c.unit for c in recording.channels] == ["rad/s^2", "N m"]
        assert_allclose(recording.samples()[0], [np.pi, 0.0, -np.pi / 2.0], rtol=1e-15)


def test_a_rotational_model_is_written_as_it_is_read(tmp_path):
    path, out = tmp_path / "model.yaml", tmp_path / "new.yaml"
    path.write_text(TURNING)
    model = read_model(path)
    assert (model.motion, model.masses["disc"]) == ("rotation", INERTIA)
    add_element(path, Element(Gap(stiffness=3000.0, clearance=0.003), ("base", "disc")), out)
    assert "stiffness: 3000 N m/rad, clearance: 0.003 rad" in out.read_text()
    again = tmp_path / "again.yaml"
    again.write_text(model_text(read_model(out)))
    assert read_model(again).elements == read_model(out).elements


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        ("stiffness: 1200.0 N/m", "a number with a unit of N m/rad"),
        ("masses: {disc: 0.02 kg m^2, rim: 1 kg}", "all in kg, or all moments of inertia"),
        ("masses: {disc: -1 kg m^2}", "more than 0"),
        ("masses: {disc: 0.02}", "such as 0.02 kg m.2, got 0.02"),
        ("masses: {disc: 0.02, rim: 1 kg m^2}", "such as 0.02 kg m.2, got 0.02"),
    ],
)
def test_a_unit_of_the_other_motion_is_told_with_its_place(tmp_path, wrong, match):
    path = tmp_path / "model.yaml"
    key = wrong.partition(":")[0]
    right = next(part for part in (f"stiffness: {STIFFNESS} N m/rad", TURNING.splitlines()[1])
                 if part.startswith(key))  # fmt: skip
    path.write_text(TURNING.replace(right, wrong))
    with pytest.raises(DocumentError, match=match) as caught:
        read_model(path)
    assert caught.value.line == TURNING[: TURNING.index(right)].count("\n") + 1


def test_an_effect_of_a_rotation_says_its_units(tmp_path):
    log = campaign(tmp_path / "turned", "rad/s^2")
    path = tmp_path / "model.yaml"
    path.write_text(TURNING.replace(str(STIFFNESS), "1000.0"))
    found = sp.compare(sp.read_model(path), sp.read_log(log), fit=True)
    fitted = {(p.name, p.unit): p.value for p in found.found.refit.parameters}
    assert fitted["stiffness", "N m/rad"] == pytest.approx(STIFFNESS, rel=1e-3)
    json.dumps(found.as_json())


@pytest.mark.parametrize("unit", ["rad/s", "rad"])
def test_orders_follow_a_measured_speed_or_angle(unit):
    """A run-up from 600 to 1200 rev/min; order 2 has an amplitude of 3 m/s^2 throughout."""
    rate, time = 2048.0, np.arange(20480) / 2048.0
    speed = 2.0 * np.pi * (10.0 + time)
    angle = 2.0 * np.pi * (10.0 * time + 0.5 * time**2)
    channels = (
        Channel("shaft", unit, "shaft", unit, "tachometer"),
        Channel("bearing", "m/s^2", "bearing", "m/s^2", "response"),
    )
    rows = np.array([speed if unit == "rad/s" else angle, 3.0 * np.cos(2.0 * angle)])
    asked = Processing(crop=None, orders=Orders(tachometer="shaft", track=(1.0, 2.0)))
    test = Test(1, excitation="random", from_hz=5.0, to_hz=500.0, processing=asked)
    found = process_recording(recording_of_arrays("run", channels, rows, rate), test).analyses
    orders = next(one for one in found if one.kind == "orders").columns
    assert_allclose(orders["order_2_bearing_amplitude_g"] * 9.80665, 3.0, rtol=1e-4)
    assert orders["speed_rev_per_min"][[0, -1]] == pytest.approx([630.0, 1170.0], rel=0.02)
