"""Rates that agree within what the digits of the files resolve are one rate."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from shakerproc.comparison.measured import Measured
from shakerproc.diagnosis.data.from_files import at_one_rate
from shakerproc.errors import DiagnosisError
from shakerproc.recordings import open_recording

RATE = 610.35
LOG = SimpleNamespace(path=SimpleNamespace(name="testlog.yaml"))


@pytest.fixture
def write(tmp_path):
    def write(name, n, digits, rate=RATE, start=0.0):
        """Write n samples whose times are printed to so many digits."""
        times = [f"{start + i / rate:.{digits}g}" for i in range(n)]
        path = tmp_path / name
        lines = ["time [s],a [g],b [g]", *(f"{t},{i % 7},{i % 5}" for i, t in enumerate(times))]
        path.write_text("\n".join(lines), encoding="utf-8")
        return path

    return write


def measured(name, path, **options):
    """Return a test with the rate of a file and nothing else."""
    with open_recording(path, **options) as recording:
        rate, doubt = recording.sample_rate, recording.rate_doubt
    empty = np.zeros((1, 2048))
    return Measured(
        SimpleNamespace(id=name), name, rate, empty, ("ch3",), empty, (1.0, 2.0), (1.0, 2.0),
        0, 2048, None, None, (1.0, 2.0), (), rate_doubt=doubt,
    )  # fmt: skip


@pytest.mark.parametrize("digits", [9, 7, 6])
def test_the_rate_is_within_what_its_digits_resolve(write, digits):
    for n, start in ((3000, 0.0), (4321, 1.3), (5000, 2.7)):
        with open_recording(write("a.csv", n, digits, start=start)) as recording:
            off = abs(recording.sample_rate / RATE - 1.0)
            assert off <= recording.rate_doubt < 50.0 * 10.0 ** (1 - digits)


@pytest.mark.parametrize("digits", [9, 7, 6])
def test_tests_whose_rates_differ_by_rounding_are_judged_at_one_rate(write, digits):
    lengths = {"1": 3000, "2": 4321, "3": 5000}
    tests = [measured(n, write(f"{n}.csv", size, digits)) for n, size in lengths.items()]
    assert len({test.sample_rate for test in tests}) > 1
    together = at_one_rate(LOG, tests)
    assert len({test.sample_rate for test in together}) == 1
    assert abs(together[0].sample_rate / RATE - 1.0) <= min(t.rate_doubt for t in tests)


def test_rates_that_differ_by_25_parts_in_a_million_are_one(write):
    one = measured("1", write("a.csv", 3000, 9))
    other = replace(one, test=SimpleNamespace(id="2"), sample_rate=one.sample_rate * 1.000025)
    assert {test.sample_rate for test in at_one_rate(LOG, [one, other])} == {one.sample_rate}


def test_the_rate_of_the_log_counts_where_the_file_resolves_no_difference(write):
    path = write("a.csv", 3000, 7)
    with open_recording(path, sample_rate=RATE) as recording:
        assert (recording.sample_rate, recording.rate_doubt) == (RATE, 0.0)
    with open_recording(path, sample_rate=RATE * (1.0 + 5e-5)) as recording:
        assert abs(recording.sample_rate / RATE - 1.0) < 1e-6  # the log rounds, the file knows


def test_rates_that_do_differ_are_told_to_the_digit(write):
    one = measured("1", write("a.csv", 3000, 9))
    other = replace(one, test=SimpleNamespace(id="2"), sample_rate=one.sample_rate * 1.0002)
    with pytest.raises(DiagnosisError, match=r"test 1 has 610\.35\d* .* test 2 610\.472"):
        at_one_rate(LOG, [one, other])
