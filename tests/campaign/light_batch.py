"""``python -m tests.campaign.light_batch LOG OUT``: a batch of light work, to be killed."""

import os
import sys
from pathlib import Path

from tests.campaign.light_work import light_work
from tests.within import WithinExecutor

from shakerproc.campaign.batch import Execution, run_batch
from shakerproc.campaign.jobs import Products
from shakerproc.campaign.result_folder import locked
from shakerproc.campaign.tables import write_tables
from shakerproc.executors import Limits, ProcessExecutor
from shakerproc.testlog import read_testlog
from shakerproc.units import to_si

to_si("1 mm", "m")  # reads the definitions of units now, not in each process that is forked


def executor():
    """Return what the environment says: so many processes, or none."""
    n_workers = int(os.environ.get("CHAOS_WORKERS", "2"))
    return ProcessExecutor(n_workers, Limits(time=60.0)) if n_workers else WithinExecutor()


def main(log: Path, out: Path):
    with locked(out):
        campaign = run_batch(
            read_testlog(log),
            out,
            Products(),
            Execution(light_work, executor()),
        )
        write_tables(campaign.runs, [], "", out)


def main_with(environment, log: Path, out: Path):
    """Do so with more in the environment."""
    os.environ |= environment
    main(log, out)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
