"""Faults of sensors that stop no comparison: told in a line, once, before the long work."""

from dataclasses import replace

import numpy as np
import pytest
from blind.structures import Joint, Structure
from tests.comparison.small_campaigns import campaign, drive, written
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.data import ArraySource
from shakerproc.diagnosis import adding
from shakerproc.errors import DiagnosisError
from shakerproc.recordings import open_recording, write_tdms
from shakerproc.workflows import comparison, diagnosis


def spiked(response):
    out = response.copy()
    out[out.size // 2] += 60.0 * np.std(out)
    return out


FAULTS = {
    "gain (ch3)": lambda x: 0.1 * x,
    "polarity (ch3)": lambda x: -x,
    "spike (ch3)": spiked,
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """One test of 9 s of a mass at 300 Hz: paths of log and model, and the samples."""
    place, omega = tmp_path_factory.mktemp("faulty"), 2.0 * np.pi * 300.0
    mass = Structure((0.4,), (Joint(-1, 0, 0.4 * omega**2, 0.02 * omega),))
    made = campaign(mass, drives=(drive(),), seconds=9.0)
    log, model = sorted(written(made, place), reverse=True)
    (file,) = place.glob("recordings/*/*.tdms")
    with open_recording(file) as recording:
        samples = recording.samples()
        return model, log, file, replace(recording, source=ArraySource(samples))


@pytest.fixture(params=FAULTS)
def faulty(request, sound):
    """The same, its response wrong."""
    model, log, file, recording = sound
    samples = recording.samples()
    row = [c.source_name for c in recording.channels].index("response 1")
    samples[row] = FAULTS[request.param](samples[row])
    spoiled = ArraySource(samples)
    write_tdms(file, replace(recording, source=spoiled, rows=tuple(range(len(samples)))))
    return model, log, request.param


LONG_WORK = {
    "compare": (comparison, "compare_tests"),
    "diagnose": (diagnosis, "diagnose_tests"),
    "add": (adding, "add_to_arrays"),
}


@pytest.mark.parametrize("command", LONG_WORK)
def test_a_fault_is_told_before_the_long_work(command, faulty, tmp_path, monkeypatch):
    model, log, fault = faulty

    def work(*_, **__):
        raise DiagnosisError("the long work begins")

    monkeypatch.setattr(*LONG_WORK[command], work)
    first = ("add", "gap") if command == "add" else (command,)
    last = ("-o", tmp_path / "new.yaml") if command == "add" else ("--out", tmp_path)
    result = CliRunner().invoke(build_app(), [str(a) for a in (*first, model, log, *last)])
    assert str(result.exception) == "the long work begins"
    told = [line for line in result.stderr.splitlines() if "warning: " in line]
    assert len(told) == 1
    assert f"test 1 (Acceleration.tdms): {fault}: " in told[0]


def test_what_was_told_stands_in_the_results_and_is_not_told_again(faulty, tmp_path):
    model, log, fault = faulty
    result = CliRunner().invoke(
        build_app(),
        [str(a) for a in ("compare", model, log, "--no-figures", "--out", tmp_path)],
    )
    assert result.exit_code == 0
    assert result.stderr.count(fault) == 1
    assert fault in (tmp_path / "compare.json").read_text()
    assert fault in (tmp_path / "report.html").read_text()
