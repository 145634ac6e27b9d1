"""The search against campaigns of an integrator of its own (Runge-Kutta on a fine grid)."""

import json

import numpy as np
import pytest
from numba import njit

from shakerproc.diagnose import TestArrays, diagnose_arrays
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor

RATE, SECONDS, FINE = 2048.0, 5.0, 8
MASS, FREQUENCY, RATIO = 0.05, 60.0, 0.02
STIFFNESS = MASS * (2.0 * np.pi * FREQUENCY) ** 2
DAMPING = 2.0 * RATIO * MASS * 2.0 * np.pi * FREQUENCY


def model(stiffness=1.05 * STIFFNESS, damping=0.75 * DAMPING):
    place = ("base", "coupon")
    return Model(
        "coupon", {"coupon": MASS},
        (
            Element(EFFECTS["spring"](stiffness=stiffness), place),
            Element(EFFECTS["damper"](damping=damping), place),
        ),
        Excitation("base acceleration"), {"ch3": Sensor("coupon")},
    )  # fmt: skip


def excitation(rng, level):
    n = int(RATE * SECONDS) * FINE
    frequency = np.fft.rfftfreq(n, 1.0 / (RATE * FINE))
    inside = (frequency > 5.0) & (frequency < 300.0)
    spectrum = inside * (
        rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    )
    y = np.fft.irfft(spectrum, n)
    t = np.arange(n) / (RATE * FINE)
    return level * y / np.std(y) * np.clip((t - 0.3) / 0.1, 0.0, 1.0)


@njit
def gap_force(z, wall, clearance):
    return wall * max(abs(z) - clearance, 0.0) * (1.0 if z > 0.0 else -1.0)


@njit
def respond(y, wall, clearance):
    """Response of the coupon: classical Runge-Kutta over two fine samples a step."""
    h = 2.0 / (RATE * FINE)
    z = v = 0.0
    out = np.empty(y.size // 2)
    for i in range(y.size // 2):
        a0 = -(STIFFNESS * z + DAMPING * v + gap_force(z, wall, clearance)) / MASS
        out[i] = a0
        if 2 * i + 2 >= y.size:
            break
        u0, u1, u2 = y[2 * i], y[2 * i + 1], y[2 * i + 2]
        a1 = a0 - u0
        z2, v2 = z + h / 2 * v, v + h / 2 * a1
        a2 = -(STIFFNESS * z2 + DAMPING * v2 + gap_force(z2, wall, clearance)) / MASS - u1
        z3, v3 = z + h / 2 * v2, v + h / 2 * a2
        a3 = -(STIFFNESS * z3 + DAMPING * v3 + gap_force(z3, wall, clearance)) / MASS - u1
        z4, v4 = z + h * v3, v + h * a3
        a4 = -(STIFFNESS * z4 + DAMPING * v4 + gap_force(z4, wall, clearance)) / MASS - u2
        z += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return out[:: FINE // 2]


def campaign(
    wall=0.0, clearance=1.0, *, seed=1, levels=(4.0, 8.0, 16.0, 12.0), share=0.005, spoil=None
):
    rng = np.random.default_rng(seed)
    tests = []
    for i, level in enumerate(levels):
        y = excitation(rng, level)
        x = respond(y, wall, clearance)
        if spoil is not None:
            x = spoil(x)
        base = y[::FINE]
        controls = base + share * base.std() * rng.standard_normal((2, base.size))
        noisy = x + share * x.std() * rng.standard_normal(x.size)
        tests.append(TestArrays(f"test {i}", RATE, controls, noisy[None], i == 3))
    return tests


@pytest.mark.slow
def test_finds_a_gap_and_its_clearance():
    clearance, stiffness = 6e-5, 1.5 * STIFFNESS
    found = diagnose_arrays(model(), campaign(stiffness, clearance))
    assert found.verdict == "effect found"
    assert found.effects[0].kind == "gap"
    parameters = found.effects[0].parameters
    assert parameters["clearance"].value == pytest.approx(clearance, rel=0.03)
    assert parameters["stiffness"].value == pytest.approx(stiffness, rel=0.05)
    errors = found.errors
    assert errors.held_out.after < 1.5 * errors.noise_floor
    assert errors.held_out.after < errors.held_out.before


@pytest.mark.slow
def test_finds_nothing_where_nothing_is_missing():
    found = diagnose_arrays(model(), campaign())
    assert found.verdict == "nothing missing"
    assert found.effects == ()
    assert found.linear["stiffness base-coupon"].value == pytest.approx(STIFFNESS, rel=2e-3)
    document = json.dumps(found.as_json(), allow_nan=False)
    assert json.loads(document)["schema"] == "shakerproc-diagnosis/1"
    again = diagnose_arrays(model(), campaign())
    assert json.dumps(again.as_json(), allow_nan=False) == document


@pytest.mark.slow
def test_a_clearance_that_never_closed_cannot_be_told():
    found = diagnose_arrays(model(), campaign(), clearances=(1.0,))
    assert found.verdict == "cannot tell"
    assert found.next_test


@pytest.mark.slow
def test_names_a_delay_and_no_physics():
    late = 1.2e-3

    def spoil(x):
        frequency = np.fft.rfftfreq(2 * x.size, 1.0 / RATE)
        turned = np.fft.rfft(x, 2 * x.size) * np.exp(-2j * np.pi * frequency * late)
        return np.fft.irfft(turned, 2 * x.size)[: x.size]

    found = diagnose_arrays(model(), campaign(spoil=spoil))
    assert found.verdict == "measurement fault"
    assert [effect.kind for effect in found.effects] == ["sensor_delay"]
    assert found.effects[0].parameters["delay"].value == pytest.approx(late, abs=1e-5)
