"""A joint in one mode of a structure: no sensor sits there, and no spring tells its force."""

import numpy as np
import pytest

from shakerproc.diagnosis import TestArrays
from shakerproc.diagnosis.adding import add_to_arrays
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.simulation import simulate

RATE = 2000.0
IN_FIRST = ("base", "bending")


def beam(frequencies, *effects):
    """Return two modes that a force at the tip drives, each with a point of its own."""
    shapes = (2.0, 1.0, 1.0, 0.0), (-2.0, 1.5, 0.0, 1.0)
    modes = [
        StructureMode(f, 0.002, shape) for f, shape in zip(frequencies, shapes, strict=True)
    ]
    marks = [Element(EFFECTS["damper"](1e-3), ("base", at)) for at in ("bending", "second")]
    return Model(
        "beam", {}, (*marks, *(Element(one, IN_FIRST) for one in effects)),
        Excitation("force", "tip"), {"tip": Sensor("tip"), "middle": Sensor("middle")},
        structures={"beam": Structure(("tip", "middle", "bending", "second"), tuple(modes))},
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.long
def test_an_iwan_joint_in_a_mode_is_fitted_with_the_mode():
    rng, tests = np.random.default_rng(1), []
    truth = beam((60.0, 200.0), EFFECTS["iwan"](3e4, 1e-4))
    for level in (1.5, 6.0):
        frequency = np.fft.rfftfreq(6000, 1.0 / RATE)
        drawn = rng.standard_normal((2, frequency.size)).T @ (1.0, 1j)
        force = np.fft.irfft(((frequency > 20.0) & (frequency < 300.0)) * drawn)
        force = np.concatenate([np.zeros(1000), level * force / force.std()])
        run = simulate(truth, force, RATE, growth=False)
        rows = np.array([run.outputs["tip"], run.outputs["middle"]])
        noisy = [
            one + 0.003 * one.std(axis=1, keepdims=True) * rng.standard_normal(one.shape)
            for one in (force[np.newaxis], rows)
        ]
        tests.append(TestArrays(f"test {level}", RATE, *noisy, band=(20.0, 300.0)))
    found = add_to_arrays(Wanted("iwan", IN_FIRST), beam((60.6, 201.0)), tests)
    assert found.parameters["stiffness"].value == pytest.approx(3e4, rel=0.02)
    assert found.parameters["slip_displacement"].value == pytest.approx(1e-4, rel=0.03)
    assert found.linear["frequency beam, mode 1"].value == pytest.approx(60.0, rel=1e-3)
    assert found.errors.held_out.after < 0.01 * found.errors.held_out.before
