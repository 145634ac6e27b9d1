"""The simulated campaign: it reads, its facts hold, and its script makes it bit for bit."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import yaml
from nptdms import TdmsFile
from scipy import integrate, signal

from shakerproc.testlog import nominal_duration, read_testlog
from shakerproc.units import to_si

FOLDER = Path(__file__).resolve().parents[2] / "sample_data"
NAMES = ["control 1", "control 2", "response 1", "response 2"]


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location(
        "make_sample_data", FOLDER / "make_sample_data.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def log():
    return read_testlog(FOLDER / "testlog.yaml", strict=True)


def samples_of(test):
    """Return what nptdms reads of the group with all data, (4, n) array in g."""
    file = TdmsFile.read(test.require_recording())
    group = next(group for group in file.groups() if group.name.endswith(" - All Data"))
    length = min(len(channel) for channel in group.channels())
    return np.array([channel[:length] for channel in group.channels()], dtype=float)


def peak_of(test):
    """Return the frequency where the density of response 1 is largest, by scipy [Hz]."""
    frequency, density = signal.welch(samples_of(test)[2], 5688.9, "hann", 2048)
    low, high = test.band
    inside = (frequency > low) & (frequency < 1.2 * high)
    return frequency[inside][np.argmax(density[inside])]


def test_it_is_small():
    size = sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file())
    assert size < 8_000_000


def test_it_holds_what_a_laboratory_meets(log):
    assert len(log.active) == 14
    assert [test.id for test in log.tests if test.discarded] == [6]
    assert [test.id for test in log.tests if test.hold_out] == [15]
    assert {test.joint for test in log.active} == {"radial", "slot"}
    assert {test.clearance for test in log.active} == {0.0, 5e-5, 1e-4}
    assert {test.excitation for test in log.active} == {"random", "sine sweep", "sine"}
    random = {t.level for t in log.active if t.excitation == "random" and t.clearance == 1e-4}
    assert len(random) >= 3


def test_the_log_of_one_joint_is_part_of_it(log):
    for test in read_testlog(FOLDER / "one_joint.yaml", strict=True).tests:
        same = log.find(test.id)
        assert (test.recording, test.level, test.band, test.hold_out) == (
            same.recording, same.level, same.band, same.hold_out,
        )  # fmt: skip
        assert (same.joint, same.clearance) == ("radial", 1e-4)


def test_files_are_laid_out_as_signal_express_does(log, shared):
    real = TdmsFile.read_metadata(shared / "data" / "tdms_nptdms" / "Digital_Input.tdms")
    endings = [group.name.rpartition(" - ")[2] for group in real.groups()][:2]
    assert endings == ["All Data", "Decimated Data_Level1"]
    for test in log.active:
        file = TdmsFile.read_metadata(test.require_recording())
        found = [group.name.rpartition(" - ")[2] for group in file.groups()]
        assert found == (endings if test.id != 11 else endings[:1])
        for channel, name in zip(file.groups()[0].channels(), NAMES, strict=True):
            assert channel.name == name
            assert channel.properties["unit_string"] == "g"
            assert 1.0 / channel.properties["wf_increment"] == pytest.approx(5688.9)


def test_omega_e_falls_with_clearance(log):
    for tests in ((1, 2, 3), (7, 8, 9), (10, 11, 12)):
        peaks = [peak_of(log.find(n)) for n in tests]
        assert peaks[0] == pytest.approx(367.0, abs=4.0)  # the glued joint, within a bin
        assert peaks[0] - peaks[1] > 10.0
        assert peaks[1] - peaks[2] > 10.0


def test_omega_e_rises_with_level(log):
    peaks = [peak_of(log.find(n)) for n in (4, 3, 5)]
    assert np.all(np.diff(peaks) > 20.0)
    assert peaks[0] > np.sqrt(0.40) * 367.0 - 4.0  # the support alone: never below


def test_the_motion_exceeds_the_play(log):
    for test in log.active:
        # Far above the controller's lower limit the response alone gives the relative motion:
        # integrated twice, without what lies below 30 Hz.
        control, response = samples_of(test)[[0, 2]] * 9.80665
        high = signal.butter(4, 30.0, "high", fs=5688.9, output="sos")
        relative = signal.sosfiltfilt(high, response - control)
        for _ in range(2):
            relative = integrate.cumulative_trapezoid(relative, dx=1 / 5688.9, initial=0.0)
            relative = signal.sosfiltfilt(high, relative)
        assert np.max(np.abs(relative)) > 1.1 * test.clearance / 2.0


def test_controls_hold_the_level_of_the_log(log):
    for test in log.active:
        control = samples_of(test)[0] * 9.80665
        run = control[round(0.8 * 5688.9) : -round(0.5 * 5688.9)]
        if test.excitation == "random":
            frequency, density = signal.welch(run, 5688.9, "hann", 1024)
            inside = (frequency > 20.0) & (frequency < 950.0)
            assert np.mean(density[inside]) == pytest.approx(test.level, rel=0.05)
        elif test.id != 13:
            assert np.max(np.abs(run)) == pytest.approx(test.level, rel=0.02)


def test_one_recording_broke_off_and_one_has_an_early_spike(log):
    whole, cut = samples_of(log.find(12)), samples_of(log.find(11))
    assert cut.shape[1] < 0.9 * whole.shape[1]
    assert nominal_duration(log.find(11)) > cut.shape[1] / 5688.9 - 0.6
    spiked = samples_of(log.find(13))
    early = spiked[:, : round(1.2 * 5688.9)]
    assert np.max(early[1]) > 1.0
    assert np.max(early[[0, 2, 3]]) < 0.05
    assert np.argmax(early[1]) / 5688.9 == pytest.approx(0.2, abs=0.001)


def test_the_integrator_agrees_with_scipys_on_a_rattling_joint(script):
    """The last word on the physics: another method, another tolerance, the same motion."""
    rate, play = 32 * 5688.9, 5e-5
    time = np.arange(32 * 600) / rate
    base = 147.0 * np.sin(2.0 * np.pi * 150.0 * time)
    mass, damping, k = script.MASS, script.DAMPING, script.STIFFNESS
    joint = (mass, damping, 0.4 * k, 0.6 * k, play)
    found, acceleration = script.relative_motion(base, 2.0 / rate, joint)

    def force(z, v):
        return 0.4 * k * z + 0.6 * k * (z - np.clip(z, -play, play)) + damping * v

    def slope(t, state):
        return state[1], -force(*state) / mass - 147.0 * np.sin(2.0 * np.pi * 150.0 * t)

    wanted = integrate.solve_ivp(
        slope, (0.0, time[-1]), (0.0, 0.0), "DOP853", time[::2], rtol=1e-9, atol=1e-14,
        max_step=5e-5,
    ).y  # fmt: skip
    assert np.max(np.abs(found)) > 1.5 * play
    assert np.max(np.abs(found - wanted[0])) < 1e-4 * np.max(np.abs(wanted[0]))
    expected = -force(*wanted) / mass
    assert np.max(np.abs(acceleration - expected)) < 1e-3 * np.max(np.abs(expected))


@pytest.mark.slow
def test_the_script_makes_the_files_bit_for_bit(script, tmp_path):
    runs = tuple(run for run in script.RUNS if run.id in {9, 11, 13})
    for path, _ in script.make(tmp_path, runs):
        there = FOLDER / "recordings" / path.relative_to(tmp_path)
        assert path.read_bytes() == there.read_bytes(), path
    assert len(list(tmp_path.rglob("*.tdms"))) == 3


def test_the_model_is_the_glued_joint(script):
    model = yaml.safe_load((FOLDER / "model.yaml").read_text())
    mass = to_si(model["masses"]["coupon"], "kg")
    spring, damper = model["elements"]
    stiffness = to_si(spring["stiffness"], "N/m")
    damping = to_si(damper["damping"], "N s/m")
    assert np.sqrt(stiffness / mass) / (2.0 * np.pi) == pytest.approx(367.0, abs=0.1)
    assert damping == pytest.approx(2.0 * 0.02 * np.sqrt(stiffness * mass), rel=1e-3)
    assert (mass, stiffness) == (script.MASS, pytest.approx(script.STIFFNESS, rel=1e-4))
