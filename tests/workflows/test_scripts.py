"""A script that calls the API as one writes it: a few lines, no `if __name__ == ...`."""

import os
import subprocess
import sys

import pytest
from tests.small_campaign import write_campaign

LINES = """
import shakerproc as sp
print("once")
log = sp.read_log({path!r})
found = sp.batch(log, out="out", figures=False)
print(*(run.status for run in found.runs))
"""


@pytest.mark.slow
@pytest.mark.parametrize("way", ["file", "event loop on standard input"])
def test_a_script_runs_once_whatever_processes_work_for_it(way, tmp_path):
    lines = LINES.format(path=str(write_campaign(tmp_path, 2)))
    if way == "event loop on standard input":
        inner = "".join(f"    {line}\n" for line in lines.splitlines())
        lines = f"import asyncio\nasync def cell():\n{inner}\nasyncio.run(cell())\n"
    script = tmp_path / "script.py"
    script.write_text(lines, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script if way == "file" else "-"],
        check=False, input=lines, cwd=tmp_path, capture_output=True, text=True, timeout=100.0,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == ["once", "done", "done"]
    assert (tmp_path / "out" / "report.html").exists()
