"""The commands on the shared recordings, as a person would type them."""

import json
import subprocess
import sys

import pytest
from tests.cli.test_frame import shakerproc

pytestmark = pytest.mark.shared


@pytest.mark.slow
@pytest.mark.parametrize("case", ["random_gap", "sweep_gap_5g"])
def test_the_thesis_tables_of_process_are_the_reference(shared, tmp_path, case):
    recording = shared / "reference" / "recordings" / f"{case}_5ch.tdms"
    done = shakerproc(
        "process", recording, "--thesis", "--no-figures", "--out", tmp_path, "--skip-s", "2"
    )
    assert done.returncode == 0, done.stderr
    checker = shared / "reference" / "check_reference.py"
    checked = subprocess.run(
        [sys.executable, checker, tmp_path / "thesis", "--case", case, "--strict"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 0, checked.stdout


def test_omega_e_of_the_reference_is_the_thesis_366_hz(shared, tmp_path):
    recording = shared / "reference" / "recordings" / "random_gap_5ch.tdms"
    done = shakerproc(
        "process", recording, "--excitation", "random", "--from-hz", "5", "--to-hz", "1000",
        "--no-figures", "--out", tmp_path, "--json", "-",
    )  # fmt: skip
    document = json.loads(done.stdout)
    peaks = {c["name"]: c["psd_peaks"][0]["frequency_hz"] for c in document["channels"]}
    assert abs(peaks["ch3"] - 366.67) < 5.56
    assert "crop" in {flag["kind"] for flag in document["flags"]}
