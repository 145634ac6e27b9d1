"""``python -m tests.campaign.light_batch LOG OUT``: a batch of light work, to be killed."""

import os
import sys
from pathlib import Path

from tests.campaign.light_work import light_work

from shakerproc.campaign.batch import Execution, run_batch
from shakerproc.campaign.collecting import write_tables
from shakerproc.campaign.jobs import Products
from shakerproc.campaign.lock import locked
from shakerproc.executors import Limits, ProcessExecutor
from shakerproc.testlog import read_testlog


def main(log: Path, out: Path):
    with locked(out):
        campaign = run_batch(
            read_testlog(log),
            out,
            Products(),
            Execution(
                light_work,
                ProcessExecutor(int(os.environ.get("CHAOS_WORKERS", "2")), Limits(time=60.0)),
            ),
        )
        write_tables(campaign.runs, [], "", out)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
