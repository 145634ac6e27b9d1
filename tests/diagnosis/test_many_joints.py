"""Structures: which joint, softer joints, modes that are off, joints not told apart."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from shakerproc.diagnosis.api import diagnose_arrays
from shakerproc.diagnosis.data import TestArrays, prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import addition, hypothesis_of
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.selection.which_joint import indistinguishable, joint_notes, shared
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.identification import JointScales
from shakerproc.models.structure import Structure, StructureMode

RATE, SECONDS = 1000.0, 4.0
MASSES = np.array([0.5, 0.8, 0.6, 0.8, 0.5])
LINKS = (3e5, 3e5, 3e5, 3e5)
POINTS = tuple(f"p{i}" for i in range(MASSES.size))
FEET = {0: 1.2e5, 2: 2.0e5, 4: 1.2e5}  # N/m
DAMPING, LOSS = 6.0, 3e-5  # N s/m of a foot, s of the links
GAP, CLEARANCE = 1.5e5, 4e-5  # N/m, m; in foot p4
LEVELS = (1.0, 4.0, 2.0)  # m/s^2


def links():
    found = np.zeros((MASSES.size, MASSES.size))
    for i, stiffness in enumerate(LINKS):
        found[i : i + 2, i : i + 2] += stiffness * np.array([[1, -1], [-1, 1]])
    return found


def drive(test):
    """Band-limited noise as a sum of 160 cosines, and none in the first tenth."""
    rng = np.random.default_rng([5, test])
    frequency = np.linspace(15.0, 180.0, 160) + rng.uniform(-0.4, 0.4, 160)
    phase = rng.uniform(0.0, 2.0 * np.pi, frequency.size)
    size = LEVELS[test] * np.sqrt(2.0 / frequency.size)

    def at(t):
        ramp = np.clip((t - 0.4) / 0.1, 0.0, 1.0)
        return (
            ramp**2
            * (3 - 2 * ramp)
            * size
            * np.sum(np.cos(2.0 * np.pi * frequency * np.reshape(t, (-1, 1)) + phase), axis=1)
        )

    return at


@cache
def moved(test, feet, gap):
    """Absolute accelerations of all masses by scipy's integrator, (5, n), and the base's."""
    stiff, damp, wave = links(), LOSS * links(), drive(test)
    for i, k in feet:
        stiff[i, i] += k
        damp[i, i] += DAMPING
    fine = np.arange(0.0, SECONDS, 1.0 / (16.0 * RATE))
    table = wave(fine)

    def forces(x, v):
        f = stiff @ x + damp @ v
        z = x[4]
        f[4] += gap * (z - np.clip(z, -CLEARANCE, CLEARANCE))
        return f

    def slope(t, y):
        x, v = y[:5], y[5:]
        base = np.interp(t, fine, table)
        return np.concatenate([v, -forces(x, v) / MASSES - base])

    time = np.arange(round(SECONDS * RATE)) / RATE
    found = solve_ivp(
        slope, (0.0, SECONDS), np.zeros(10), "RK45", time, rtol=1e-7, atol=1e-12, max_step=2e-4
    )
    x, v = found.y[:5], found.y[5:]
    f = np.array([forces(a, b) for a, b in zip(x.T, v.T, strict=True)])
    return -(f / MASSES).T, wave(time)


def recorded(sensors, feet, gap):
    rng = np.random.default_rng(1)
    tests = []
    for test, level in enumerate(LEVELS):
        seen, base = moved(test, tuple(feet.items()), gap)
        rows = seen[list(sensors)] + 1e-3 * level * rng.standard_normal((
            len(sensors),
            base.size,
        ))
        controls = base + 1e-3 * level * rng.standard_normal((2, base.size))
        tests.append(
            TestArrays(f"test {test + 1}", RATE, controls, rows, test == 2, band=(15.0, 180.0))
        )
    return tests


def model(sensors, *, off=0.0, feet=FEET):
    """The modes of the free chain, their frequencies off by a share, on its feet."""
    squares, shapes = eigh(links(), np.diag(MASSES))
    omega = np.sqrt(np.maximum(squares, 0.0))
    signs = (0.0, 1.0, -1.0, 1.0, -1.0)
    modes = tuple(
        StructureMode(
            0.0 if i == 0 else w * (1.0 + off * sign) / (2.0 * np.pi),
            0.0 if i == 0 else LOSS * w / 2.0,
            tuple(shapes[:, i]),
        )
        for i, (w, sign) in enumerate(zip(omega, signs, strict=True))
    )
    elements = tuple(
        Element(law, ("base", POINTS[i]))
        for i, k in feet.items()
        for law in (EFFECTS["spring"](stiffness=k), EFFECTS["damper"](damping=DAMPING))
    )
    return Model(
        "chain", {}, elements, Excitation("base acceleration"),
        {f"s{i}": Sensor(POINTS[i]) for i in sensors},
        structures={"chain": Structure(POINTS, modes)},
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.long
def test_a_gap_in_a_foot_without_sensor_is_named_there_though_the_modes_are_off():
    sensors = (0, 1, 3)
    found = diagnose_arrays(model(sensors, off=0.01), recorded(sensors, FEET, GAP))
    assert found.verdict == "effect found", found.sentence
    (effect,) = found.effects
    assert (effect.kind, effect.between) == ("gap", ("base", "p4"))
    assert effect.parameters["clearance"].value == pytest.approx(CLEARANCE, rel=0.01)
    assert effect.parameters["stiffness"].value == pytest.approx(GAP, rel=0.02)
    truth = eigh(links(), np.diag(MASSES), eigvals_only=True)
    told = found.linear["frequency chain, mode 2"].value
    assert told == pytest.approx(np.sqrt(truth[1]) / (2.0 * np.pi), rel=0.002)


@pytest.mark.slow
@pytest.mark.long
def test_a_softer_foot_is_no_effect_and_is_told():
    sensors = (0, 1, 3)
    softer = {**FEET, 4: FEET[4] / 3.0}
    found = diagnose_arrays(model(sensors, off=0.01), recorded(sensors, softer, 0.0))
    assert found.verdict == "nothing missing", found.sentence
    assert found.linear["stiffness base-p4"].value == pytest.approx(FEET[4] / 3.0, rel=0.01)
    assert "stiffness base-p4 120000 N/m in the file, fitted 40000 N/m" in found.sentence


def test_feet_that_are_alike_by_symmetry_are_not_told_apart_and_a_sensor_is_named_that_would():
    known, n = model((2,)), 600  # the middle of a chain that is its own mirror image
    wave = np.random.default_rng(0).standard_normal(n)
    wave[:400] *= 1e-3
    tests = [
        TestArrays(f"{i}", RATE, np.array([wave, wave]), wave[None], i == 1) for i in (0, 1)
    ]
    data = DataSet(known, prepared(tests))
    whole = whole_tests(data, held_out=False)
    scores = []
    for foot in ("p0", "p4"):
        free = EFFECTS["gap"].identification(
            JointScales(
                displacement=1e-4, velocity=0.1, force=20.0, stiffness=1e5, mass=1.0,
                duration=1.0, band=400.0,
            )
        )  # fmt: skip
        one = addition("gap", ("base", foot), free, free.starts[0])
        hypothesis = hypothesis_of(known).with_added(one)
        x = np.concatenate([np.zeros(len(hypothesis.own)), one.transformed(free.starts[0])])
        found = fit(data, hypothesis, x, whole, rounds=0)
        scores.append(Score(found, np.log1p(found.rows)))
    assert_allclose(scores[0].logs, scores[1].logs, rtol=1e-6)
    assert indistinguishable(scores) == ("gap between base and p4",)
    assert shared(0.8, scores) == 0.4
    (note,) = joint_notes(SimpleNamespace(data=data), scores)
    assert note.startswith(
        "These tests do not tell whether it is between base and p0 or between base and p4: "
        "a sensor at p"
    )


def test_modes_that_are_off_become_numbers_of_the_model():
    known = model((0, 1))
    one = known.structures["chain"]
    off = replace(one.modes[1], frequency=1.01 * one.modes[1].frequency)
    hypothesis = hypothesis_of(known)
    x = np.zeros(hypothesis.size)
    place = [n.mode == ("chain", 1) and n.name == "frequency" for n in hypothesis.own]
    x[place] = np.log(1.01)
    assert hypothesis.model_at(x).structures["chain"].modes[1] == off
