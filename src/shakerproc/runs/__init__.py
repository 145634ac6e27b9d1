"""One test of a log, processed: recording, crop, spectra, peaks, flags."""

from shakerproc.runs.averaging import averaged_blows
from shakerproc.runs.opening import open_path, open_test
from shakerproc.runs.processing import find_crop, process_recording, process_test
from shakerproc.runs.result import RunResult
from shakerproc.runs.roles import UnitOption, usual_roles
from shakerproc.runs.summarising import summary_of
from shakerproc.runs.summary import RunSummary, read_summary, write_summary
