"""Every test of a log processed, in processes or on a cluster, into a folder."""

from collections.abc import Collection
from pathlib import Path

from shakerproc.campaign.batch import UNTOLD, CampaignResult, Execution, Progress, run_batch
from shakerproc.campaign.jobs import Products
from shakerproc.campaign.remote import RemoteExecutor, RemoteHashes
from shakerproc.testlog import TestLog
from shakerproc.workflows.machines import Machines
from shakerproc.workflows.worker import prepare, work_through


def run_log(
    log: TestLog,
    root: Path,
    products: Products,
    machines: Machines,
    *,
    accept_changed: bool = False,
    only: Collection[int | str] | None = None,
    progress: Progress = UNTOLD,
) -> CampaignResult:
    """Return how every test of a log went, its results in a folder; see `run_batch`."""
    executor = machines.executor(prepare if products.figures else None)
    hashes = None
    if machines.recordings is not None:
        hashes = RemoteHashes(machines.executor(), machines.recordings)
    if machines.scheduler is not None or machines.recordings is not None:
        executor = RemoteExecutor(executor, machines.source(log))
    return run_batch(
        log,
        root,
        products,
        Execution(work_through, executor, hashes),
        accept_changed=accept_changed,
        only=only,
        progress=progress,
    )
