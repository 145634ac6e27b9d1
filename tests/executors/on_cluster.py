"""``python -m tests.executors.on_cluster ADDRESS``: a task of every bad kind; prints JSON."""

import json
import sys
from dataclasses import asdict

from tests.campaign.bad_work import work

from shakerproc.executors import ClusterExecutor, Limits, Task

KINDS = ("good", "raise", "unpicklable", "killed", "hang", "memory", "exit", "not json", "good")


def main(address):
    tasks = [Task(f"{i}", {"kind": kind, "number": i}) for i, kind in enumerate(KINDS)]
    executor = ClusterExecutor(address, Limits(time=3.0, memory=1e9))
    outcomes = [asdict(outcome) for outcome in executor.run(work, tasks)]
    sys.stdout.write(json.dumps(outcomes))


if __name__ == "__main__":
    main(sys.argv[1])
