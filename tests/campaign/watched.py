"""``python -m tests.campaign.watched KILLS``: kill a watch again and again.

A process appends to TDMS files segment by segment; the watch of their folder is killed with
SIGKILL at random moments and started again. At the end every recording is in the log once, no
recording was told twice, and the results equal those of `batch` with the same log.
"""

import contextlib
import hashlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAUSE = 0.25
"""Time between two segments [s]; a recording that stands still for `SETTLE` is finished."""

SETTLE = 1.5


def start(*command):
    return subprocess.Popen(
        [sys.executable, "-m", *map(str, command)],
        cwd=ROOT,
        env=os.environ | {"SOURCE_DATE_EPOCH": "1500000000"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # it hears Ctrl-C even where the tests are run in the background of a shell
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
    )


def watch(folder, *more):
    options = ("--settle", SETTLE, "--every", 0.2, "--no-figures", "--workers", 1)
    return start("shakerproc", "watch", folder, *options, *more)


def results(folder):
    """Hash of every file; of the report, what does not say how it was asked for."""
    told = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    del told["command"]
    names = {".shakerproc.lock", "report.json", "report.html"}
    return told, {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in names
    }


def wait_until_busy(folder, rng, most):
    """Wait until log or results have changed some times, or for 15 s, and a bit."""
    left, seen, end = rng.randint(1, most), None, time.monotonic() + 15.0
    while left and time.monotonic() < end:
        now = written(folder)
        left -= now != seen
        seen = now
        time.sleep(0.05)
    time.sleep(rng.uniform(0.0, 0.3))


def written(folder):
    """Names and times of the log and of all results, also of those that are under way."""
    found = {}
    for place, _, names in os.walk(folder / "results"):  # which passes over what vanishes
        for path in (folder / "testlog.yaml", *(Path(place) / name for name in names)):
            with contextlib.suppress(OSError):
                found[path] = path.stat().st_mtime_ns
    return found


def done_in(folder):
    """How many results a folder holds."""
    path = folder / "manifest.json"
    runs = json.loads(path.read_text(encoding="utf-8"))["runs"] if path.exists() else {}
    return sum(entry["status"] == "done" for entry in runs.values())


def kill_and_compare(folder, kills, recordings, *, seed=1, pause=PAUSE, most=14):
    """Return how many files were compared, and how many results stood after each kill."""
    rng, said, stood = random.Random(seed), [], []
    (folder / "in").mkdir(parents=True)
    writer = start("tests.campaign.slow_writer", folder / "in", recordings, pause)
    for _ in range(kills):
        process = watch(folder / "in")
        wait_until_busy(folder / "in", rng, most)
        process.kill()
        out, errors = process.communicate()
        assert process.returncode == -9, errors
        said += out.splitlines()
        stood.append(done_in(folder / "in" / "results"))
    _, errors = writer.communicate(timeout=600)
    assert writer.returncode == 0, errors
    process = watch(folder / "in", "--idle", 1)
    out, errors = process.communicate(timeout=600)
    assert process.returncode == 0, (errors, out, said)
    said += out.splitlines()
    told = Counter(m[1] for line in said if (m := re.match(r"test (\d+) \(", line)))
    assert all(count == 1 for count in told.values()), told  # nothing twice
    batch = start(
        "shakerproc", "batch", folder / "in" / "testlog.yaml", "--no-figures",
        "--workers", 1, "--out", folder / "batch",
    )  # fmt: skip
    _, errors = batch.communicate(timeout=600)
    assert batch.returncode == 0, errors
    found, expected = results(folder / "in" / "results"), results(folder / "batch")
    assert found == expected
    runs = [run["recording"] for run in found[0]["runs"]]
    wanted = [f"Test_{number}/Acceleration.tdms" for number in range(1, recordings + 1)]
    log = (folder / "in" / "testlog.yaml").read_text(encoding="utf-8")
    assert len(runs) == recordings, runs
    assert all(log.count(f"recording: {name}") == 1 for name in wanted), log  # nothing lost
    return len(found[1]), stood


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        n_kills = int(sys.argv[1]) if len(sys.argv) > 1 else 20
        compared, stood = kill_and_compare(Path(name), n_kills, max(3, n_kills))
        sys.stdout.write(
            f"{n_kills} kills while {max(3, n_kills)} recordings were written, with "
            f"{', '.join(map(str, stood))} results standing after them; {compared} files equal "
            "those of batch, no recording lost, none processed twice\n"
        )
