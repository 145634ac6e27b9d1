"""An effect between one mode of a structure and the base, by a point that is the mode."""

import numpy as np
import pytest
import scipy.signal

from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.coordinates import coordinates_of
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.simulation import simulate

RATE, STIFFNESS, SLIP, DAMPING = 8000.0, 3e4, 1e-4, 0.002
OMEGA = 2.0 * np.pi * 60.0


def ring_down():
    """Return the acceleration at the tip of two modes, of which the first has an Iwan joint."""
    shapes = (60.0, (2.0, 1.0)), (200.0, (-2.0, 0.0))
    modes = [StructureMode(frequency, DAMPING, shape) for frequency, shape in shapes]
    iwan = EFFECTS["iwan"](STIFFNESS, SLIP)
    model = Model(
        "a joint in a mode", {}, (Element(iwan, ("base", "bending")),),
        Excitation("free decay"), {"tip": Sensor("tip")},
        structures={"beam": Structure(("tip", "bending"), tuple(modes))},
    )  # fmt: skip
    places = coordinates_of(model, ()).places
    begin = {
        "beam, mode 1": (5e-5 / places["bending"][0], 0.0),
        "beam, mode 2": (2e-6 / places["tip"][1], 0.0),
    }
    rest = np.zeros(round(2.0 * RATE))
    return simulate(model, rest, RATE, start=begin, growth=False).outputs["tip"]


def followed(rows, frequency, width, sample):
    """Return amplitude, frequency [Hz] and damping ratio of a mode around a sample."""
    band = [frequency - width, frequency + width]
    own = scipy.signal.butter(4, band, "band", fs=RATE, output="sos")
    turning = scipy.signal.hilbert(scipy.signal.sosfiltfilt(own, rows))
    omega = np.gradient(np.unwrap(np.angle(turning))) * RATE
    decay = -np.gradient(np.log(np.abs(turning))) * RATE / omega
    here = slice(sample - 200, sample + 200)
    return (
        float(np.abs(turning)[here].mean()),
        float(omega[here].mean()) / (2.0 * np.pi),
        float(decay[here].mean()),
    )


def test_its_frequency_and_damping_follow_amplitude_and_no_other_mode_does():
    r"""Secant and loop of Masing's rules: f(A)/A = k(1 - A/2z), 2kA^3/3z lost in a cycle."""
    rows = ring_down()
    for sample in (2400, 4000, 8000):
        acceleration, frequency, damping = followed(rows, 62.0, 12.0, sample)
        amplitude = acceleration / (2.0 * (2.0 * np.pi * frequency) ** 2)
        square = OMEGA**2 + STIFFNESS * (1.0 - amplitude / (2.0 * SLIP))
        lost = 2.0 / 3.0 * STIFFNESS * amplitude / SLIP / (2.0 * np.pi)
        assert frequency == pytest.approx(np.sqrt(square) / (2.0 * np.pi), rel=2e-4)
        wanted = (lost + DAMPING * OMEGA * np.sqrt(square)) / square
        assert damping == pytest.approx(wanted, rel=0.03)  # which is that of slow change
        _, frequency, damping = followed(rows, 200.0, 15.0, sample)
        assert frequency == pytest.approx(200.0, rel=2e-4)
        assert damping == pytest.approx(DAMPING, rel=0.05)
