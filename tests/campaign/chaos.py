"""``python -m tests.campaign.chaos KILLS``: kill a batch at random moments, resume, compare.

A batch is killed with SIGKILL once or several times, then resumed to its end. After each kill
whatever stands under its final name must be whole, and at the end every file must equal that
of a batch that nobody disturbed. Prints how many were compared and fails if one is not.
"""

import hashlib
import json
import multiprocessing
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.campaign import light_batch
from tests.small_campaign import write_campaign

from shakerproc.files import TEMPORARY_PREFIX

LIGHT = (sys.executable, "-m", "tests.campaign.light_batch")
FORKED = ("a light batch, forked",)
REAL = (sys.executable, "-m", "shakerproc", "batch", "--no-figures", "--workers", "2")
ROOT = Path(__file__).parents[2]


class Forked:
    """A light batch without workers, forked from a process that has imported all it needs."""

    def __init__(self, log, out):
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([light_batch.__name__])
        environment = {"SOURCE_DATE_EPOCH": "1500000000", "CHAOS_WORKERS": "0"}
        self.process = context.Process(
            target=light_batch.main_with, args=(environment, log, out)
        )
        self.process.start()

    @property
    def returncode(self):
        return self.process.exitcode

    def wait(self, timeout):
        self.process.join(timeout)
        if self.process.is_alive():
            raise subprocess.TimeoutExpired(FORKED, timeout)

    def kill(self):
        self.process.kill()

    def communicate(self, timeout=None):
        self.process.join(timeout)
        return "", "what went wrong stands above"


def start(command, log, out):
    if command == FORKED:
        return Forked(log, out)
    environment = os.environ | {"SOURCE_DATE_EPOCH": "1500000000"}
    tail = [str(log), str(out)] if command == LIGHT else [str(log), "--out", str(out)]
    return subprocess.Popen(
        [*command, *tail],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def fingerprints(folder):
    """Hash of every file but the lock; nothing half-written may stand under a final name."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != ".shakerproc.lock"
    }


def finish(command, log, out):
    process = start(command, log, out)
    _, errors = process.communicate(timeout=3600)  # a busy machine may take its time
    assert process.returncode == 0, errors


def check_whole(folder, expected):
    """Whatever stands under its final name is whole, the manifest of what is done included."""
    found = fingerprints(folder)
    manifest = found.pop("manifest.json", None)
    if manifest is not None:
        json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    whole = {n: d for n, d in found.items() if not Path(n).name.startswith(TEMPORARY_PREFIX)}
    assert whole.items() <= expected.items(), sorted(set(whole.items()) - set(expected.items()))
    return len(whole)


def say(kills, stood, compared):
    sys.stdout.write(
        f"{kills} kills, {stood} files that stood after them, all whole; "
        f"{compared} files compared after the ends, 0 differ\n"
    )
    sys.stdout.flush()


def chaos(folder, n_kills, *, command=LIGHT, n_tests=6, seed=1, resumed=0.5, tell=None):
    """Return the kills, how many files stood after them, how many were compared at ends.

    A share `resumed` of the kills is followed by a batch that nobody disturbs.
    """
    log = write_campaign(folder, n_tests)
    finish(command, log, folder / "calm")  # compiled kernels and caches are there from now on
    shutil.rmtree(folder / "calm")
    began = time.monotonic()
    finish(command, log, folder / "calm")
    longest = time.monotonic() - began
    # the command line of a report names its folder, so every batch goes into the same one
    expected = fingerprints(folder / "calm")
    rng, kills, stood, compared, out = random.Random(seed), 0, 0, 0, folder / "calm"
    shutil.rmtree(out)
    while kills < n_kills:
        process = start(command, log, out)
        try:
            process.wait(timeout=rng.uniform(0.2, 1.1) * longest)
        except subprocess.TimeoutExpired:
            process.kill()
            kills += 1
        process.communicate()
        stood += check_whole(out, expected)
        if process.returncode == 0 or kills >= n_kills or rng.random() < resumed:
            finish(command, log, out)
            found = fingerprints(out)
            assert found == expected, sorted(set(found.items()) ^ set(expected.items()))
            compared += len(found)
            shutil.rmtree(out)
            if tell is not None:
                tell(kills, stood, compared)
    return kills, stood, compared


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 500
        chosen = REAL if "--real" in sys.argv else LIGHT
        chaos(Path(name), wanted, command=chosen, tell=say)
