"""Traps and mistakes: half a second and 100 MB each; what is refused, with line and column."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows neither forks nor tells the peak")
def test_each_is_answered_in_half_a_second_and_100_mb():
    done = subprocess.run(
        [sys.executable, "-m", "tests.documents", "traps", "mistakes"],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    rows = {
        line.split(" | ")[0][2:]: line.split(" | ") for line in done.stdout.splitlines()[2:]
    }
    assert int(rows["traps"][1]) >= 40
    assert int(rows["mistakes"][2]) >= 100
