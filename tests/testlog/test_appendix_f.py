"""The thesis' table F.1 as a log: every row of it, and what else the thesis says of it."""

import re
from collections import Counter
from pathlib import Path

import pytest

from shakerproc.errors import LogError
from shakerproc.testlog import nominal_duration, read_testlog

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
G = 9.80665


@pytest.fixture(scope="module")
def log():
    return read_testlog(CONFIGS / "appendix_f.yaml")


def test_the_table_has_98_rows_of_which_4_are_discarded(log):
    assert [test.id for test in log.tests] == [*range(1, 98), 99]
    assert [test.id for test in log.tests if test.discarded] == [6, 52, 53, 94]


def test_it_loads_without_recordings_and_each_test_says_so(log):
    assert not (CONFIGS / "recordings").exists()
    with pytest.raises(LogError, match=r"test 1: no recording .*Test_1/Acceleration\.tdms"):
        log.find(1).require_recording()


def test_counts_are_those_of_section_5_2_3(log):
    # "a total of 72 sine sweep tests", 12 random, 8 harmonic; fixed ones come on top
    free = [test for test in log.active if "fixture" not in test.tags]
    assert Counter(test.excitation for test in free) == {
        "sine sweep": 72, "random": 12, "sine": 8,
    }  # fmt: skip
    assert len(free) == 92
    assert [test.id for test in log.active if "fixture" in test.tags] == [44, 45]


def test_sweeps_are_those_of_table_5_5(log):
    ranges = {0.5: 5.0, 1.0: 15.0, 2.0: 15.0, 5.0: 25.0, 10.0: 50.0, 15.0: 50.0}
    swept = [t for t in log.active if t.excitation == "sine sweep" and "fixture" not in t.tags]
    groups = Counter((t.joint, t.specimen, t.orientation) for t in swept)
    assert set(groups.values()) == {6}
    assert len(groups) == 12
    for test in swept:
        assert test.band == (ranges[round(test.level / G, 9)], 500.0)
        assert test.rate_oct_per_min == pytest.approx(1.0)
    assert nominal_duration(log.find(1)) == pytest.approx(398.63, abs=0.01)


def test_random_tests_are_those_of_table_5_6(log):
    for test in log.active:
        if test.excitation == "random":
            assert test.level == pytest.approx(0.0002 * G**2)
            assert test.band == (5.0, 1000.0)


def test_harmonic_tests_are_those_of_section_5_2_3(log):
    harmonic = [test for test in log.active if test.excitation == "sine"]
    assert {test.specimen for test in harmonic} == {"a_0_10"}
    assert Counter((round(t.level / G, 9), t.frequency_hz) for t in harmonic) == {
        (level, frequency): 1 for level in (1.0, 10.0) for frequency in (50, 250, 315, 366)
    }
    for test in harmonic:  # table 5.7
        assert (test.processing.welch.segment, test.processing.welch.overlap) == (2048, 1024)
        assert test.notch_hz == test.frequency_hz


@pytest.mark.parametrize(
    ("joint", "specimen", "nominal", "actual"),
    [
        ("radial", "a_0_00", 0.00, 0.05),  # drilled 0.05 mm too wide
        ("radial", "a_0_05", 0.05, 0.05),
        ("radial", "a_0_10", 0.10, 0.10),
        ("slot", "a_0_00", 0.00, 0.00),
        ("slot", "a_0_05", 0.05, 0.05),
        ("slot", "a_0_10", 0.10, 0.08),  # 0.02 mm too short
    ],
)
def test_actual_clearances_are_those_of_appendix_d(log, joint, specimen, nominal, actual):
    tests = [t for t in log.tests if (t.joint, t.specimen) == (joint, specimen) and not t.tags]
    assert {round(t.clearance * 1e3, 9) for t in tests} == {nominal}
    assert {round(t.actual_clearance * 1e3, 9) for t in tests} == {actual}


def test_a_washer_leaves_no_clearance(log):
    assert {log.find(n).actual_clearance for n in (44, 45)} == {0.0}


def test_channels_are_the_five_that_matlab_took(log):
    assert [(use.key, use.role, use.name) for use in log.find(1).channels] == [
        (1, "control", "control 1"),
        (2, "control", "control 2"),
        (3, "response", "ch3"),
        (4, "response", "ch4"),
        (5, "response", "ch5"),
    ]


@pytest.mark.shared
def test_every_row_is_that_of_the_thesis(log, shared):
    text = (shared / "THESIS.txt").read_text(encoding="utf-8")
    table = text[text.index("## Shaker Test Log") : text.index("Table F.1: Shaker Test Log")]
    rows = re.findall(r"^\| Test(\d+) \|(.*)\|$", table, flags=re.MULTILINE)
    assert len(rows) == 98
    for number, rest in rows:
        coupon, orientation, level, band, comment = (
            cell.strip(" $") for cell in rest.split("|")
        )
        test = log.find(number)
        assert f"{test.joint} {test.specimen}".strip() == coupon.lower()
        assert test.orientation == orientation.lower()
        assert test.discarded == ("discarded" in comment)
        assert test.comment.replace(" ", "") == comment.replace(" ", "")
        if level:
            unit = G**2 if test.excitation == "random" else G
            assert test.level == pytest.approx(float(level) * unit)
            limits = [test.frequency_hz] if test.excitation == "sine" else test.band
            assert [f"{limit:g}" for limit in limits] == band.split("-")


@pytest.mark.shared
def test_every_dimension_is_that_of_appendix_d(shared):
    text = (shared / "THESIS.txt").read_text(encoding="utf-8")
    appendix = text[text.index("# Measured Dimensions") : text.index("## S355", 150_000)]
    written = (CONFIGS / "specimens.yaml").read_text()
    for table in ("radial", "slot"):
        part = appendix.split("Table D.1")[0 if table == "radial" else 1]
        section = written[written.index(f"  {table}:") :]
        for name in ("a_0_00", "a_0_05", "a_0_10"):
            cells = next(
                [cell.strip() for cell in line.split("|")[2:-1]]
                for line in part.splitlines()
                if line.startswith(f"| {name}")
            )
            row = section[section.index(name) :].split("}")[0]
            assert float(re.search(r"hole: ([\d.]+)", row)[1]) == float(cells[1])
            assert float(re.search(r" thickness: ([\d.]+)", row)[1]) == float(cells[-1])
