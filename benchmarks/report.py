"""A report of 500 runs: its size, and how long a browser takes to open it.

Noisy recordings of 4 channels, 20 of them, each told as 25 tests; once as they are, once with
a spectrogram of each asked for.
"""

import resource
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Final

from tests.report.browser import FOUND, Browser
from tests.report.test_page import report_of
from tests.small_campaign import write_campaign

from shakerproc.report.page.page import write_report
from shakerproc.runs import process_test, summary_of
from shakerproc.testlog import TestLog, facts_of, read_testlog
from shakerproc.testlog.processing import ShownSpectrogram

N_RUNS: Final = 500
N_MADE: Final = 20
TRIES: Final = 3


def main() -> None:
    """Print sizes and times."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log = read_testlog(write_campaign(folder, N_MADE))
        _measure(log, "as they are", folder / "report.html")
        tests = tuple(
            replace(t, processing=replace(t.processing, spectrogram=ShownSpectrogram()))
            for t in log.tests
        )
        _measure(replace(log, tests=tests), "with spectrograms", folder / "more.html")


def _measure(log: TestLog, told: str, path: Path) -> None:
    """Write the report of a log and print its size, and how long it takes to open."""
    made = [
        summary_of(process_test(log, t), "1", facts_of(t), f"test_{t.id}.tdms", "ab" * 32)
        for t in log.tests
    ]
    runs = [replace(made[i % N_MADE], test=str(i + 1)) for i in range(N_RUNS)]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    write_report(path, report_of(runs))
    taken = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
    print(f"{N_RUNS} runs {told}: {path.stat().st_size / 1e6:.2f} MB, written in {taken:.1f} s")
    if FOUND is None:
        print("no Chromium, Chrome or Edge is installed to open it")
        return
    with Browser() as browser:
        times = sorted(browser.open(path) for _ in range(TRIES))
        print(f"until drawn, best of {TRIES}: {times[0]:.2f} s, worst {times[-1]:.2f} s")


if __name__ == "__main__":
    main()
