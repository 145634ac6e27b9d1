"""Blows on a structure that still rings: the damping is that of the structure, and no cable."""

import numpy as np
import pytest
import yaml
from scipy import signal

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.modal.from_measurements import analyse_test
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test, read_testlog

RATE, OVER, GAP = 1000.0, 8, 1.2
FREQUENCY, DAMPING = np.array([70.0, 130.0]), np.array([0.001, 0.002])
SHAPES = np.array([[1.0, 0.7], [0.8, -1.0]])


def ringing(seed, *, uneven):
    """Force and two displacements of six blows 1.2 s apart: mode 1 falls to 59 % between them.

    Each mode by the exact step of a force that is straight between points of 8 kHz.
    """
    rng = np.random.default_rng(seed)
    n, pulse = round((6 * GAP + 0.3) * RATE), np.hanning(6 * OVER + 1)
    force = np.zeros(n * OVER)
    for blow in range(6):
        late = rng.uniform(0.0, 0.08) if uneven else 0.0
        at = round((blow * GAP + 0.05 + late) * RATE) * OVER
        force[at : at + pulse.size] += pulse * (80.0 + 10.0 * rng.standard_normal())
    moved = np.zeros((2, n))
    for omega, zeta, shape in zip(2.0 * np.pi * FREQUENCY, DAMPING, SHAPES, strict=True):
        continuous = ([1e6], [1.0, 2.0 * zeta * omega, omega**2])
        above, below, _ = signal.cont2discrete(continuous, 1.0 / RATE / OVER, "foh")
        own = signal.lfilter(above.ravel(), below, force)[::OVER]
        moved += np.outer(shape * shape[0], own)
    moved += 1e-3 * np.abs(moved).max() * rng.standard_normal(moved.shape)
    return np.array([force[::OVER] + 0.05 * rng.standard_normal(n), *moved])


def modes_of(tmp_path, rows):
    channels = {
        name: {"role": "displacement" if name != "f" else "force", "unit": unit}
        for name, unit in (("f", "N"), ("a", "um"), ("b", "um"))
    }
    test = {"id": 1, "recording": "run.npz", "excitation": "hammer", "from": "20 Hz",
            "to": "300 Hz"}  # fmt: skip
    log = {"testlog": 1, "recordings": ".", "channels": channels,
           "processing": {"crop": "none"}, "tests": [test]}  # fmt: skip
    (tmp_path / "log.yaml").write_text(yaml.safe_dump(log))
    np.savez(tmp_path / "run.npz", **dict(zip("fab", rows, strict=True)), fs=RATE)
    read = read_testlog(tmp_path / "log.yaml")
    return analyse_test(read, read.find(1), read.modal).modes


@pytest.mark.parametrize("uneven", [False, True])
def test_damping_of_blows_on_a_structure_that_rings_is_that_of_the_structure(tmp_path, uneven):
    modes = modes_of(tmp_path, ringing(1, uneven=uneven))
    assert modes.poles.size == 2
    np.testing.assert_allclose(modes.frequency, FREQUENCY, rtol=2e-5)
    np.testing.assert_allclose(modes.damping, DAMPING, rtol=0.01)
    assert any("left at the end of the blocks" in note for note in modes.notes)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("uneven", [False, True])
def test_intervals_of_ringing_blows_hold_the_truth(tmp_path, uneven):
    """40 draws of two modes: 95 % of 80, less three standard deviations."""
    inside = []
    for seed in range(40):
        modes = modes_of(tmp_path, ringing(seed, uneven=uneven))
        low, high = modes.damping_bounds
        inside += [a <= zeta <= b for a, zeta, b in zip(low, DAMPING, high, strict=True)]
    assert np.mean(inside) > 0.87


def test_a_sensor_that_rings_through_a_weak_blow_has_no_broken_cable():
    """The sixth blow is weak; the same sensor, unplugged for that blow, is named."""
    rows = ringing(2, uneven=False)
    channels = [Channel(n, "um" if i else "N", n, "um", "displacement" if i else "force")
                for i, n in enumerate("fab")]  # fmt: skip
    quiet = np.random.default_rng(5).standard_normal(rows.shape[1]) * rows[2, :20].std()
    off = np.array(rows)
    off[2, 5000:] = quiet[5000:]
    weak = np.array(rows)
    weak[2, 5980:] = rows[2, 5980:] - 0.9 * (rows[2, 5980:] - rows[2, 4780 : 4780 + 1520])
    test = Test(1, excitation="hammer", from_hz=20.0, to_hz=300.0, processing=Processing())
    for samples, named in ((off, True), (weak, False)):
        result = process_recording(recording_of_arrays("run", channels, samples, RATE), test)
        (blows,) = [one for one in result.analyses if one.kind == "blows"]
        assert any("look at its cable" in text for text in blows.problems) is named
