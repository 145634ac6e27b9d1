"""A cluster of three worker processes on this machine: the same results, bit for bit."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from tests.campaign.bad_work import work
from tests.campaign.chaos import fingerprints
from tests.executors.on_cluster import KINDS
from tests.in_process import completed
from tests.small_campaign import write_campaign

from shakerproc.errors import ClusterError
from shakerproc.executors import ClusterExecutor, Limits, Task
from shakerproc.executors import cluster as cluster_executor
from shakerproc.executors.cluster import attempt, versions

ROOT = Path(__file__).parents[2]
CAUSES = {
    "good": "",
    "raise": "error",
    "unpicklable": "error",
    "killed": "killed",
    "hang": "time limit",
    "memory": "memory limit",
    "exit": "error",
    "not json": "error",
}
PLACES = os.pathsep.join(p for p in (str(ROOT), os.environ.get("PYTHONPATH")) if p)
ENVIRONMENT = os.environ | {"SOURCE_DATE_EPOCH": "1500000000", "PYTHONPATH": PLACES}


class Cluster:
    """A scheduler and its workers, each with its nanny in a session of its own."""

    def __init__(self, folder, n_workers=3):
        self.folder = folder
        self.file = folder / "scheduler.json"
        self.processes = [self._start("scheduler", "--port", "0", "--no-dashboard")]
        self._wait(self.file.exists)
        self.address = json.loads(self.file.read_text(encoding="utf-8"))["address"]
        self.workers = [
            self._start(
                "worker", "--nthreads", "1", "--no-dashboard", "--local-directory", folder
            )
            for _ in range(n_workers)
        ]
        self.processes += self.workers
        for i in range(1, n_workers + 1):
            self._wait(lambda i=i: "Registered to" in self.said(i))

    def _start(self, kind, *options):
        with (self.folder / f"{kind}_{time.monotonic_ns()}.log").open("wb") as log:
            command = ["-m", f"distributed.cli.dask_{kind}", "--scheduler-file", self.file]
            process = subprocess.Popen(
                [sys.executable, *command, *options],
                env=ENVIRONMENT,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        process.log = Path(log.name)
        return process

    def said(self, i):
        return self.processes[i].log.read_text(encoding="utf-8")

    def _wait(self, condition):
        until = time.monotonic() + 120.0
        while not condition():
            assert time.monotonic() < until, self.said(0)
            time.sleep(0.05)

    def kill_a_worker(self):
        """Kill one with its nanny and all its children: it does not come back."""
        kill(self.workers.pop())

    def close(self):
        for process in self.processes:
            kill(process)


def kill(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    if sys.platform == "win32":
        pytest.skip("POSIX sessions")
    found = Cluster(tmp_path_factory.mktemp("cluster"))
    yield found
    found.close()


def start(*command):
    return subprocess.Popen(
        [sys.executable, "-m", "shakerproc", *map(str, command)],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def done(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert "Traceback" not in err
    return out


def done_here(*command):
    ended = completed(*command, env=ENVIRONMENT)
    assert ended.returncode == 0, ended.stderr


def results(folder, *options):
    """Every file, without the options of the cluster in the command line that it tells."""
    told = "".join(f" {option}" for option in options).encode()
    for path in (folder / "report.html", folder / "report.json"):
        if told:
            path.write_bytes(path.read_bytes().replace(told, b""))
    return fingerprints(folder)


def n_done(out):
    path = out / "manifest.json"
    if not path.exists():
        return 0
    runs = json.loads(path.read_text(encoding="utf-8"))["runs"]
    return sum(entry["status"] == "done" for entry in runs.values())


@pytest.mark.slow
@pytest.mark.long
def test_a_batch_gives_the_same_files_though_a_worker_is_killed(tmp_path, cluster):
    log, out = write_campaign(tmp_path, 6), tmp_path / "out"
    done_here("batch", log, "--out", out, "--no-figures")
    alone = results(out)
    assert len(alone) > 20
    shutil.rmtree(out)
    process = start("batch", log, "--out", out, "--no-figures", "--scheduler", cluster.address)
    until = time.monotonic() + 200.0
    while not n_done(out) and time.monotonic() < until:
        time.sleep(0.02)
    assert 0 < n_done(out) < 6
    cluster.kill_a_worker()
    done(process)
    assert results(out, "--scheduler", cluster.address) == alone


@pytest.mark.slow
def test_recordings_are_fetched_through_fsspec(tmp_path, cluster):
    log, out = write_campaign(tmp_path, 3), tmp_path / "out"
    done_here("batch", "--no-figures", log, "--out", out)
    alone = results(out)
    (tmp_path / "recordings").rename(tmp_path / "elsewhere")
    place = ["--recordings", (tmp_path / "elsewhere").as_uri()]
    for options in (place, [*place, "--scheduler", cluster.address]):
        shutil.rmtree(out)
        done_here("batch", "--no-figures", log, "--out", out, *options)
        assert results(out, *options) == alone


@pytest.mark.slow
@pytest.mark.long
def test_a_study_gives_the_same_table(tmp_path, cluster):
    study = ROOT / "configs" / "studies" / "temperature.yaml"
    for name, more in (("alone", ()), ("cluster", ("--scheduler", cluster.address))):
        done_here("study", study, "--no-figures", "--out", tmp_path / name, *more)
    alone = fingerprints(tmp_path / "alone")
    assert len(alone) > 5
    assert fingerprints(tmp_path / "cluster") == alone


@pytest.mark.slow
@pytest.mark.long
def test_a_diagnosis_gives_the_same_numbers(tmp_path, cluster):
    done(start("init", tmp_path / "c"))
    files = (tmp_path / "c" / "model.yaml", tmp_path / "c" / "testlog.yaml")
    told = [
        done(start("diagnose", *files, "--out", tmp_path / "out", "--json", "-", *more))
        for more in ((), ("--scheduler", cluster.address))
    ]
    assert json.loads(told[0])["verdict"] == "effect found"
    assert told[1] == told[0]


@pytest.mark.slow
def test_one_bad_task_of_each_kind_leaves_the_others_done(cluster):
    ended = subprocess.run(
        [sys.executable, "-m", "tests.executors.on_cluster", cluster.address],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    outcomes = {outcome["name"]: outcome for outcome in json.loads(ended.stdout)}
    assert len(outcomes) == len(KINDS)
    for i, kind in enumerate(KINDS):
        outcome = outcomes[f"{i}"]
        assert outcome["cause"] == CAUSES[kind], outcome
        assert (outcome["value"] == {"kind": "good", "number": i**2}) == (kind == "good")


@pytest.mark.slow
def test_no_cluster_is_said_in_one_line(tmp_path):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    log = write_campaign(tmp_path, 1)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and nobody listens
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        ended = completed("batch", log, "--out", tmp_path / "out", "--scheduler", address)
    assert ended.returncode == 1
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"error: no scheduler answers at {address}")


def hang_up(listening):
    connection, _ = listening.accept()
    connection.close()


@pytest.mark.slow
@pytest.mark.parametrize("silent", [True, False])
def test_a_port_that_is_no_scheduler_is_said_within_seconds(tmp_path, silent, monkeypatch):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    assert cluster_executor._ANSWER <= 5.0
    monkeypatch.setattr(cluster_executor, "_ANSWER", 0.5)
    log = write_campaign(tmp_path, 1)
    with socket.create_server(("127.0.0.1", 0)) as listening:  # accepts by itself
        address = f"tcp://127.0.0.1:{listening.getsockname()[1]}"
        if not silent:
            threading.Thread(target=hang_up, args=(listening,), daemon=True).start()
        began = time.monotonic()
        ended = completed("batch", log, "--out", tmp_path / "out", "--scheduler", address)
        assert time.monotonic() - began < 60.0
    assert ended.returncode == 1
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"error: no scheduler answers at {address}: the port is open, but ")


def test_other_versions_on_a_worker_are_refused():
    wanted = versions() | {"numpy": "1.0", "shakerproc": "0.0"}
    outcome = attempt("7", b"", b"", Limits(), wanted)
    assert (outcome["name"], outcome["cause"]) == ("7", "error")
    assert re.search(r"shakerproc \S+ here, 0.0 there, numpy \S+ here, 1.0", outcome["error"])


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r'pip install "shakerproc\[cluster\]"'):
        list(ClusterExecutor("tcp://10.0.0.1:8786").run(work, [Task("1", {})]))


def test_nothing_to_do_needs_no_cluster():
    assert list(ClusterExecutor("tcp://10.0.0.1:8786").run(work, [])) == []
