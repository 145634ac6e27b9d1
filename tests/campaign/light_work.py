"""Work for batches under test: quick, and for one test as bad as the environment says."""

import hashlib
import os

from tests.campaign.bad_work import work as misbehave

from shakerproc import files
from shakerproc.campaign.jobs import SUMMARY, check_recording
from shakerproc.campaign.result_folder import hashes
from shakerproc.recordings import WatchedFile
from shakerproc.runs import RunSummary, write_summary
from shakerproc.testlog import facts_of


def light_work(job):
    """Write three files whose content follows from the recording alone."""
    kind = os.environ.get("BAD_WORK", "")
    if kind and str(job.test.id) == "4":
        misbehave({"kind": kind, "number": 1})
    path = job.test.require_recording()
    with WatchedFile(path, path.name, hashed=True) as watched:
        check_recording(job, watched)
        content = path.read_bytes()
        read = watched.sha256()
    written = []
    for name in ("a.csv", "b.png"):
        written.append(job.folder / name)
        digest = hashlib.sha256(content + name.encode()).hexdigest()
        files.write_text(written[-1], digest * 2000)
    written.append(job.folder / SUMMARY)
    summary = RunSummary(str(job.test.id), "done", facts_of(job.test), job.recording, read)
    write_summary(written[-1], summary)
    return {"outputs": hashes(job.root, written), "sha256": read}
