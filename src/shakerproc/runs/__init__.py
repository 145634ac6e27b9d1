"""One test of a log, worked through: recording, crop, spectra, peaks, flags."""

from shakerproc.runs.opening import open_path, open_test, usual_uses
from shakerproc.runs.processing import find_crop, process_recording, process_test, welch
from shakerproc.runs.result import Flag, ResonancePeak, Responses, RunResult
from shakerproc.runs.summary import RunSummary, read_summary, write_summary
from shakerproc.runs.summing_up import summary_of

__all__ = [
    "Flag",
    "ResonancePeak",
    "Responses",
    "RunResult",
    "RunSummary",
    "find_crop",
    "open_path",
    "open_test",
    "process_recording",
    "process_test",
    "read_summary",
    "summary_of",
    "usual_uses",
    "welch",
    "write_summary",
]
