"""One mass on a spring in memory, shaken at random: simulated truths for the estimation."""

import numpy as np

from shakerproc.diagnosis.data import TestArrays, prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.hypotheses.hypothesis import addition, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import scales_of
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulation import simulate

RATE = 2000.0
BAND = (10.0, 150.0)
NOISE = 0.005
QUIET = 1000
JOINT = ("base", "mass")
STIFFNESS, DAMPING = 1e5, 12.0


def one_mass(stiffness=STIFFNESS, damping=DAMPING, effect=None):
    """Return 1 kg at 50 Hz, damped by 2 %, with an effect beside the spring."""
    effects = [EFFECTS["spring"](stiffness), EFFECTS["damper"](damping)]
    return Model(
        "one mass",
        {"mass": 1.0},
        tuple(Element(e, JOINT) for e in [*effects, *([effect] if effect else [])]),
        Excitation("base acceleration"),
        {"top": Sensor("mass")},
    )


def arrays_of(truth, *, levels=(2.0, 6.0), seconds=3.0, seed=3):
    """Return tests of a truth at rms levels [m/s^2], at rest for half a second at first."""
    rng = np.random.default_rng(seed)
    found = []
    for number, level in enumerate(levels, start=1):
        frequency = np.fft.rfftfreq(int(seconds * RATE), 1.0 / RATE)
        inside = (frequency > BAND[0]) & (frequency < BAND[1])
        shaken = np.fft.irfft(inside * (rng.standard_normal((2, frequency.size)).T @ (1.0, 1j)))
        shaken = np.concatenate([np.zeros(QUIET), level * shaken / shaken.std()])
        run = simulate(truth, shaken, RATE, growth=False, tolerance=1e-8)
        clean = np.array([run.outputs["top"]])
        noisy = [
            rows + NOISE * rows.std() * rng.standard_normal(rows.shape)
            for rows in (shaken[np.newaxis], clean)
        ]
        found.append(TestArrays(f"test {number}", RATE, *noisy, band=BAND))
    return found


def data_of(truth, **changed):
    """Return a truth's tests, ready for the residual."""
    return DataSet(one_mass(), prepared(arrays_of(truth, **changed)))


def added(data, kind, **values):
    """Return the hypothesis that an effect is missing, and x with the effect at values [SI]."""
    model = one_mass()
    at = scales_of(model, data.tests, JOINT, data.across(JOINT))
    one = addition(kind, JOINT, EFFECTS[kind].identification(at), values)
    hypothesis = hypothesis_of(model).with_added(one)
    return hypothesis, np.concatenate([np.zeros(2), one.transformed(values)])
