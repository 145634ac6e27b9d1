"""The table of usual units holds what the registry of units says, to the last bit."""

import subprocess
import sys

import pytest

from shakerproc import units
from shakerproc.units import USUAL


@pytest.mark.parametrize(("unit", "gravity"), USUAL)
def test_a_usual_unit_means_what_the_registry_says(unit, gravity):
    assert USUAL[unit, gravity] == units._read(unit, gravity)


def test_a_usual_log_is_read_without_the_registry(tmp_path):
    (tmp_path / "log.yaml").write_text(
        "testlog: 1\nchannels: {a: {role: control, unit: g}}\n"
        "processing: {crop: {threshold: 0.45 g}}\ntests:\n"
        "  - {id: 1, excitation: random, level: 0.02 g^2/Hz, from: 5 Hz, to: 1 kHz}\n"
        "  - {id: 2, excitation: sine sweep, level: 1 g, from: 5 Hz, to: 100 Hz, "
        "rate: 1 oct/min, clearance: 0.05 mm}\n"
    )
    code = (
        "import sys; from pathlib import Path; from shakerproc.testlog import read_testlog\n"
        "print(read_testlog(Path('log.yaml')).tests[0].level); print('pint' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    level, loaded = done.stdout.split()
    assert float(level) == pytest.approx(0.02 * 9.80665**2, rel=1e-14)
    assert loaded == "False"
