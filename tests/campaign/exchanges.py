"""``python -m tests.campaign.exchanges ROUNDS``: exchange recordings while a batch reads them.

In each round recordings are replaced, written over, shortened, removed, and put back with their
old times, at random moments of a batch and of the batch that resumes it. After each batch every
result that stands is compared with what it was really made from:

* light rounds: the work reads the recording by itself, slowly, and writes down the SHA-256 of
  what it read; that has to be the one that the result is filed under, whatever it read;
* real rounds: tables of small recordings are compared with those that a batch without any
  disturbance makes of the same bytes.

Prints how many results were looked at and fails if one is filed under other bytes.
"""

import hashlib
import json
import os
import random
import shutil
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tests.small_campaign import HEAD, ROW, write_recording

from shakerproc import files
from shakerproc.campaign.batch import Execution, run_batch
from shakerproc.campaign.jobs import SUMMARY, Products, check_recording
from shakerproc.campaign.result_folder import hashes
from shakerproc.errors import ShakerprocError
from shakerproc.executors import AbstractExecutor, TaskOutcome
from shakerproc.recordings import WatchedFile
from shakerproc.runs import RunSummary, write_summary
from shakerproc.testlog import read_testlog
from shakerproc.workflows.worker import work_through

PIECE, PAUSE = 1 << 13, 0.002
MADE_FROM = "made_from.json"


def slow_work(job):
    """Write down what was read, piece by piece, by the path alone."""
    path = job.test.require_recording()
    with WatchedFile(path, path.name, hashed=True) as watched:
        check_recording(job, watched)
        seen = digest_of_pieces(path)
        read = watched.sha256()
    return written(job, seen, read)


def trusting_work(job):
    """What must be found out: the work believes what it was told before."""
    return written(job, digest_of_pieces(job.test.require_recording()), job.sha256)


def digest_of_pieces(path):
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
            time.sleep(PAUSE)
    return digest.hexdigest()


def written(job, seen, read):
    files.write_json(job.folder / MADE_FROM, {"sha256": seen})
    summary = RunSummary(str(job.test.id), "done", recording=job.recording, sha256=read)
    write_summary(job.folder / SUMMARY, summary)
    paths = [job.folder / MADE_FROM, job.folder / SUMMARY]
    return {"outputs": hashes(job.root, paths), "sha256": read}


def hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


@dataclass
class Tally:
    rounds: int = 0
    changes: int = 0
    looked_at: int = 0
    refused: int = 0
    wrong: list = field(default_factory=list)

    def __str__(self):
        return (
            f"{self.rounds} rounds, {self.changes} changes to recordings, {self.refused} runs "
            f"refused, {self.looked_at} results looked at, {len(self.wrong)} filed under other "
            "bytes"
        )


class Threads(AbstractExecutor):
    """Two threads, in which a run that fails leaves the others alone."""

    def run(self, work, tasks):
        def attempt(argument):
            try:
                return {"value": work(argument)}
            except (ShakerprocError, OSError) as error:
                return {"cause": "input", "error": str(error)}

        with ThreadPoolExecutor(2) as pool:
            waiting = {pool.submit(attempt, task.argument): task.name for task in tasks}
            for done in as_completed(waiting):
                yield TaskOutcome(waiting[done], **done.result())


class Round:
    """A campaign of a few recordings, and what may take their places."""

    def __init__(self, folder, contents, rng, *, in_pieces):
        self.rng, self.contents, self.in_pieces = rng, contents, in_pieces
        self.out = folder / "out"
        self.paths = []
        rows = []
        for number in range(1, 5):
            path = folder / "recordings" / f"t{number}.tdms"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(rng.choice(contents))
            self.paths.append(path)
            rows.append(ROW.format(id=number, file=path.name, joint="radial", specimen="a",
                                   clearance="0.05", more=""))  # fmt: skip
        self.log = folder / "testlog.yaml"
        self.log.write_text(HEAD.format(title="Exchanges") + "".join(rows), encoding="utf-8")
        self.changes = 0

    def batch(self, work, **options):
        return run_batch(
            read_testlog(self.log),
            self.out,
            Products(figures=False),
            Execution(work, Threads()),
            **options,
        )

    @contextmanager
    def disturbed(self, longest):
        """Change recordings at random moments until the block ends, a few times at least."""
        done = threading.Event()

        def disturb():
            for number in range(40):
                if done.wait(self.rng.uniform(0.0, longest / 4)) and number > 1:
                    return
                self.change(self.rng.choice(self.paths))

        thread = threading.Thread(target=disturb)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()

    def change(self, path):
        """Change a recording, sometimes only for a moment, sometimes with its old times."""
        self.changes += 1
        times = path.stat()
        content = path.read_bytes()
        way = self.rng.choice((self.replace, self.write_over, self.shorten, self.move_aside,
                               self.write_over_and_back, self.remove_and_back))  # fmt: skip
        way(path, self.rng.choice(self.contents), content)
        if self.rng.random() < 0.5:
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def replace(self, path, other, _content):
        aside = path.with_suffix(".new")
        aside.write_bytes(other)
        aside.replace(path)

    def write_over(self, path, other, _content):
        if not self.in_pieces:
            path.write_bytes(other)
            return
        with path.open("wb") as file:
            for start in range(0, len(other), PIECE):
                file.write(other[start : start + PIECE])
                file.flush()
                time.sleep(self.rng.uniform(0.0, 2 * PAUSE))

    def shorten(self, path, _other, content):
        share = self.rng.uniform(0.0, 1.0) if self.in_pieces else 0.75
        os.truncate(path, int(share * len(content)))

    def move_aside(self, path, other, _content):
        aside = path.with_suffix(".aside")
        path.rename(aside)
        path.write_bytes(other)
        time.sleep(self.rng.uniform(0.0, 5 * PAUSE))
        aside.replace(path)

    def write_over_and_back(self, path, other, content):
        self.write_over(path, other, content)
        time.sleep(self.rng.uniform(0.0, 5 * PAUSE))
        self.write_over(path, content, other)

    def remove_and_back(self, path, _other, content):
        path.unlink()
        time.sleep(self.rng.uniform(0.0, 2 * PAUSE))
        self.replace(path, content, content)


def made_from_of(folder, filed, _known):
    """Whether a light result says that it was made of what it is filed under."""
    return json.loads((folder / MADE_FROM).read_text(encoding="utf-8"))["sha256"] == filed


def same_table(folder, filed, known):
    """Whether a real result is the one that an undisturbed batch makes of these bytes."""
    return known.get(filed) == hash_of(folder / "spectra.csv")


def look(one, campaign, agrees, known, tally):
    """Hold every result that stands against what it was made from."""
    manifest = json.loads((one.out / "manifest.json").read_text(encoding="utf-8"))
    for run in campaign.runs:
        entry = manifest["runs"][f"test_{run.test}"]
        if run.status != "done":
            tally.refused += 1
            continue
        tally.looked_at += 1
        folder = one.out / "runs" / f"test_{run.test}"
        told = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["sha256"]
        if not (told == run.sha256 == entry["recording_sha256"]):
            tally.wrong.append((tally.rounds, run.test, "told differently"))
        elif not agrees(folder, told, known):
            tally.wrong.append((tally.rounds, run.test, told))


def play(folder, contents, rng, tally, *, work, agrees, known, longest):
    """One round: a disturbed batch, one that resumes it disturbed, and one in peace."""
    one = Round(folder, contents, rng, in_pieces=agrees is made_from_of)
    for options in ({}, {"accept_changed": rng.random() < 0.5}):
        with one.disturbed(longest):
            campaign = one.batch(work, **options)
        look(one, campaign, agrees, known, tally)
    for path in one.paths:
        if rng.random() < 0.5 or known:
            one.replace(path, rng.choice(contents), b"")
    campaign = one.batch(work, accept_changed=True)
    look(one, campaign, agrees, known, tally)
    for run, path in zip(campaign.runs, one.paths, strict=True):
        if run.status != "done" or run.sha256 != hash_of(path):
            tally.wrong.append((
                tally.rounds,
                run.test,
                run.error or "not of the file in peace",
            ))
    tally.rounds += 1
    tally.changes += one.changes


def light_contents(rng):
    return [rng.randbytes(rng.randrange(4, 10) * PIECE) for _ in range(5)]


def real_contents(folder):
    """Small recordings, and the tables that a batch in peace makes of each, also shortened."""
    made = [
        write_recording(folder / f"r{i}.tdms", 200.0 + 40 * i, seconds=2.0, seed=i).read_bytes()
        for i in range(4)
    ]
    known = {}
    for number, content in enumerate([*made, *(c[: int(0.75 * len(c))] for c in made)]):
        one = Round(folder / f"calm{number}", [content], random.Random(1), in_pieces=False)
        run = one.batch(work_through).runs[0]
        if run.status == "done":
            table = one.out / "runs" / "test_1" / "spectra.csv"
            known[hashlib.sha256(content).hexdigest()] = hash_of(table)
    assert len(known) >= len(made)
    return made, known


def exchanges(folder, rounds, *, real_share=0.5, seed=1, work=slow_work, tell=None):
    """Return the tally of so many rounds, a share of them with the real work."""
    rng, tally = random.Random(seed), Tally()
    made, known = real_contents(folder / "made") if real_share else ([], {})
    for number in range(rounds):
        place = folder / f"round{number}"
        if rng.random() < real_share:
            how = {"work": work_through, "agrees": same_table, "known": known, "longest": 0.3}
            play(place, made, rng, tally, **how)
        else:
            how = {"work": work, "agrees": made_from_of, "known": {}, "longest": 0.1}
            play(place, light_contents(rng), rng, tally, **how)
        shutil.rmtree(place)
        if tell is not None and tally.rounds % 20 == 0:
            tell(tally)
    return tally


def say(tally):
    sys.stdout.write(f"{tally}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 200
        found = exchanges(Path(name), wanted, tell=say)
    say(found)
    sys.exit(bool(found.wrong))
