"""Real and published sets: every log and model is read, and what was measured arrives in SI."""

import numpy as np
import pytest
from configs.benchmarks import convert
from tests.in_process import run

import shakerproc
from shakerproc.model_files import read_model
from shakerproc.runs import open_test
from shakerproc.testlog import read_testlog

RATES = {
    "silverbox": 610.35, "bouc_wen": 750.0, "emps": 1000.0, "mr_damper": 100.0,
    "friction_damper": 1024.0, "shaking_table": 120.0, "base_isolation": 200.0,
    "ringdown": 640.0, "f16": 400.0, "pcb_shaker": 1706.5,
}  # fmt: skip
"""Samples per second as SOURCES.md says them; the ring-down at an eightieth [Hz]."""

PEAKS = {
    "silverbox": {"V1": 0.15, "V2": 0.3},
    "bouc_wen": {"displacement": 2e-3},
    "emps": {"position": 0.25},
    "mr_damper": {"stroke": 0.026, "force": 240.0},
    "friction_damper": {"stroke": 0.025, "force": 12e3},
    "base_isolation": {"ground": 2.05, "floor6": 0.91},
}
"""Roughly the largest samples, from SOURCES.md and the plots of the authors [SI]."""


@pytest.mark.shared
@pytest.mark.parametrize("name", sorted(RATES))
def test_the_recordings_of_a_set_are_read_at_their_rate(shared, tmp_path, name):
    folder = convert.folder_of(name, tmp_path, shared / "data")
    for path in sorted(folder.glob("*.yaml")):
        if path.name.endswith("model.yaml"):
            continue
        log = read_testlog(path)
        for test in log.tests:
            with open_test(log, test) as recording:
                assert recording.sample_rate == pytest.approx(RATES[name], rel=1e-4)
                samples = recording.samples()
                assert np.all(np.isfinite(samples))
                for channel, row in zip(recording.channels, samples, strict=True):
                    most = PEAKS.get(channel.name)
                    if most is not None and name != "shaking_table":
                        assert 0.2 * most < np.abs(row).max() <= most


@pytest.mark.shared
def test_peaks_of_a_real_damper_are_fitted_where_modes_merge(shared, tmp_path):
    folder = convert.folder_of("mr_damper", tmp_path, shared / "data")
    log = read_testlog(folder / "testlog.yaml")
    assert shakerproc.process(log.tests[1]).to_pandas().size


@pytest.mark.shared
def test_the_file_of_silverbox_does_not_say_its_rate(shared, tmp_path):
    folder = convert.folder_of("silverbox", tmp_path, shared / "data")
    text = (folder / "testlog.yaml").read_text(encoding="utf-8")
    silent = folder / "silent.yaml"
    silent.write_text(text.replace("processing: {sample_rate: 610.35 Hz}\n", ""))
    log = read_testlog(silent)
    with pytest.raises(Exception, match="sample rate"), open_test(log, log.tests[0]):
        pass


def test_every_set_has_a_log_and_a_model():
    for name in set(convert.SETS) - {"three_masses"}:  # which its generator writes
        assert (convert.HERE / name / "testlog.yaml").exists()
        assert (convert.HERE / name / "model.yaml").exists()


def test_the_model_of_a_set_is_read(tmp_path):
    for name in ("silverbox", "bouc_wen", "emps", "shaking_table", "base_isolation"):
        model = read_model(convert.HERE / name / "model.yaml")
        assert model.sensors


def test_a_set_whose_recordings_are_absent_is_said(tmp_path):
    with pytest.raises(FileNotFoundError, match="silverbox"):
        convert.folder_of("silverbox", tmp_path, tmp_path / "nothing")


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_modes_of_an_aircraft_are_a_structure_that_answers_as_it_does(shared, tmp_path):
    """Response functions summed here from the structure, against the averaged periods."""
    folder = convert.folder_of("f16", tmp_path, shared / "data")
    out = folder / "modal"
    assert run("modal", folder / "modal.yaml", "--out", out, "--no-figures") == 0
    structure = read_model(folder / "model.yaml").structures["aircraft"]
    frequencies = [mode.frequency for mode in structure.modes]
    for published in (5.2, 7.3):
        assert min(abs(f - published) for f in frequencies) < 0.05
    held = np.load(folder / "recordings" / "level1.npz")
    spectra = {
        name: np.fft.rfft(held[name].reshape(9, -1)[1:].mean(axis=0))
        for name in ("force", "wing", "payload")
    }
    lines = np.fft.rfftfreq(8192, 1.0 / 400.0)
    band = (lines >= 2.0) & (lines <= 15.0)
    omega = 2.0 * np.pi * lines[band]
    for row, name in ((1, "wing"), (2, "payload")):
        said = sum(
            -(omega**2) * mode.shape[0] * mode.shape[row]
            / ((2 * np.pi * mode.frequency) ** 2 - omega**2
               + 4j * np.pi * mode.frequency * mode.damping_ratio * omega)
            for mode in structure.modes
        ) * spectra["force"][band]  # fmt: skip
        measured = spectra[name][band]
        assert np.linalg.norm(said - measured) < 0.14 * np.linalg.norm(measured)
