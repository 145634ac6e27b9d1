"""The commands on the shared recordings, as a person would type them."""

import json
import shutil
import subprocess
import sys

import pytest
from tests.in_process import completed as shakerproc

pytestmark = pytest.mark.shared


def checked(shared, tables, case):
    """Return what the checker of the reference says of tables."""
    checker = shared / "reference" / "check_reference.py"
    return subprocess.run(
        [sys.executable, checker, tables, "--case", case, "--strict"],
        capture_output=True,
        text=True,
        check=False,
    )


CLIPPED = 11_379  # first sample that is kept, counted from 1
RATE = 5688.9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "options"),
    [
        ("random_gap__clip", ["--skip-s", repr((CLIPPED - 1) / RATE)]),
        ("sweep_gap_5g", []),
    ],
)
def test_the_thesis_tables_of_process_are_the_reference(shared, tmp_path, case, options):
    name = case.removesuffix("__clip")
    recording = shared / "reference" / "recordings" / f"{name}_5ch.tdms"
    done = shakerproc(
        "process", recording, "--thesis", "--no-figures", "--out", tmp_path, *options
    )
    assert done.returncode == 0, done.stderr
    told = checked(shared, tmp_path / "thesis", case)
    assert told.returncode == 0, told.stdout
    assert "not compared" not in told.stdout


LOG = """testlog: 1
recordings: .
channels:
  5: {{role: response, name: ch5}}
  1: {{role: control}}
  3: {{role: response, name: ch3}}
  2: {{role: control}}
  4: {{role: response, name: ch4}}
processing: {{crop: {{{crop}}}}}
tests:
  - {{id: 1, recording: random_gap_5ch.tdms}}
"""


@pytest.mark.slow
def test_the_manual_clip_of_appendix_c_is_had_by_times_and_channels_in_any_order(
    shared, tmp_path
):
    # the run cut by hand: the time of its first sample, and of the one after its last
    crop = f"from: {24_067 / RATE:.6f} s, to: {249_003 / RATE:.6f} s"
    recording = shared / "reference" / "recordings" / "random_gap_5ch.tdms"
    shutil.copy(recording, tmp_path)
    (tmp_path / "log.yaml").write_text(LOG.format(crop=crop))
    done = shakerproc("batch", tmp_path / "log.yaml", "--thesis", "--no-figures")
    assert done.returncode == 0, done.stderr
    (tables,) = tmp_path.glob("results/**/thesis")
    told = checked(shared, tables, "random_gap__clip")
    assert told.returncode == 0, told.stdout
    assert "not compared" not in told.stdout


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
