"""Modes of a hammer test: those of the structure, whatever the window and the bad blows."""

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose
from tests.struck import MODES, RATE, struck

from shakerproc.modal.from_measurements import analyse_test
from shakerproc.testlog import read_testlog

WINDOWS = [{"length": "1.9 s"}, {"length": "0.8 s", "exponential": "1 %"}]


@pytest.mark.parametrize("sensors", [1, 2])
@pytest.mark.parametrize("hammer", WINDOWS)
def test_noise_that_sensors_share_and_windows_smear_makes_no_modes(tmp_path, hammer, sensors):
    """Noise of the force is the same in every function; the first seed, and one more."""
    log = {
        "testlog": 1,
        "recordings": ".",
        "channels": {
            name: {"role": role, "unit": unit}
            for name, role, unit in (
                ("f", "force", "N"), ("a", "response", "m/s^2"),
                ("b", "response" if sensors == 2 else "ignore", "m/s^2"),
            )
        },
        "processing": {"hammer": hammer},
        "tests": [
            {"id": 1, "recording": "run.npz", "excitation": "hammer", "from": "20 Hz",
             "to": "350 Hz"}
        ],
    }  # fmt: skip
    (tmp_path / "log.yaml").write_text(yaml.safe_dump(log))
    read = read_testlog(tmp_path / "log.yaml")
    for seed in (1, 3):
        blows = [(0.5 + 2.0 * k, 100.0 + 10.0 * k) for k in range(5)]
        rows = struck(blows, 10.5, noise=(0.2, 0.1), seed=seed)
        np.savez(tmp_path / "run.npz", **dict(zip("fab", rows, strict=True)), fs=RATE)
        modes = analyse_test(read, read.find(1), read.modal).modes
        assert_allclose(modes.frequency, [mode[0] for mode in MODES], rtol=5e-4)
        for k, (_, zeta, *_) in enumerate(MODES):
            low, high = modes.damping_bounds[:, k]
            assert low * 0.99 < zeta < high * 1.01
            assert high / low < 1.05


@pytest.mark.parametrize("hammer", WINDOWS)
def test_modes_of_blows_are_those_of_the_structure(tmp_path, hammer):
    blows = [(0.5 + 2.0 * k, 100.0 + 10.0 * k) for k in range(5)]
    rows = struck([*blows, (4.57, 60.0)], 10.5, noise=(0.05, 0.005))  # one hits twice
    rows[1:, round(6.4 * RATE) : round(8.4 * RATE)] = 0.0  # a cable came off
    np.savez(tmp_path / "run.npz", **dict(zip(("f", "a", "b"), rows, strict=True)), fs=RATE)
    log = {
        "testlog": 1,
        "recordings": ".",
        "channels": {
            "f": {"role": "force", "unit": "N"},
            "a": {"role": "response", "unit": "m/s^2"},
            "b": {"role": "response", "unit": "m/s^2"},
        },
        "processing": {"hammer": hammer},
        "tests": [
            {"id": 1, "recording": "run.npz", "excitation": "hammer", "from": "20 Hz",
             "to": "350 Hz"}
        ],
    }  # fmt: skip
    (tmp_path / "log.yaml").write_text(yaml.safe_dump(log))
    read = read_testlog(tmp_path / "log.yaml")
    found = analyse_test(read, read.find(1), read.modal)
    assert_allclose(found.modes.frequency, [mode[0] for mode in MODES], rtol=2e-4)
    assert_allclose(found.modes.damping, [mode[1] for mode in MODES], rtol=0.01)
    shapes = np.array([[1.0, 0.8], [0.7, -0.9]])
    for shape, wanted in zip(found.modes.shapes.real, shapes, strict=True):
        assert abs(shape @ wanted) ** 2 > 0.9999 * (shape @ shape) * (wanted @ wanted)
    assert "3 of 5 blows are averaged" in found.notes
    assert (found.unexplained < 0.02).all()
