"""Breakpoint profiles of a log: what they mean, and each mistake in one line."""

import math

import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ShakerprocError
from shakerproc.testlog import read_testlog

G = 9.80665
POINTS = (
    "[[20 Hz, 3 dB/oct], [80 Hz, 0.04 g^2/Hz], [350 Hz, 0.04 g^2/Hz], [2000 Hz, -3 dB/oct]]"
)


def log_of(folder, profile, test="excitation: random, profile: p", csv=None):
    if csv is not None:
        (folder / "p.csv").write_text(csv)
    text = f"testlog: 1\nprofiles:\n  p: {profile}\ntests:\n  - {{id: 1, {test}}}\n"
    (folder / "log.yaml").write_text(text)
    return folder / "log.yaml"


def profile_of(*args, **how):
    return read_testlog(log_of(*args, **how)).tests[0].profile


def test_slopes_are_followed_from_the_levels_beside_them(tmp_path):
    profile = profile_of(tmp_path, f"{{breakpoints: {POINTS}}}")
    assert profile.unit == "(m/s^2)^2/Hz"
    octaves = math.log2(2000.0 / 350.0)
    expected = [0.04 * 10**-0.6, 0.04, 0.04, 0.04 * 10 ** (-0.3 * octaves)]
    assert_allclose(profile.level, [v * G**2 for v in expected], rtol=1e-12)


def test_a_sweep_of_constant_displacement_rises_by_twelve_decibels_an_octave(tmp_path):
    profile = profile_of(
        tmp_path,
        "{breakpoints: [[5 Hz, 1 mm], [40 Hz, 1 mm], [500 Hz, 0 dB/oct]]}",
        "excitation: sine sweep, profile: p",
    )
    assert_allclose(profile.level[0], (2 * math.pi * 5.0) ** 2 * 1e-3)
    assert_allclose(
        20 * math.log10(profile.level[1] / profile.level[0]), 3 * 12.0412, rtol=1e-5
    )
    assert_allclose(profile.level[2], profile.level[1])


def test_tolerances_hold_up_to_the_next_breakpoint_that_has_its_own(tmp_path):
    header = "frequency [Hz],demand [g^2/Hz],alarm [dB],abort [dB]\n"
    csv = header + "20,0.01,,\n500,0.01,3,6\n2000,-3 dB/oct,,\n"
    profile = profile_of(tmp_path, "{file: p.csv, alarm: 1.5 dB}", csv=csv)
    assert profile.alarm_db == (1.5, 3.0, 3.0)
    assert profile.abort_db == (6.0, 6.0, 6.0)
    assert_allclose(profile.level[2], 0.01 * G**2 * 10**-0.6)


def test_a_csv_of_a_spreadsheet_with_semicolons_and_a_mark_of_its_encoding(tmp_path):
    csv = "\ufeff# transport\n\nFrequency [Hz];Demand [g]\n\n# ISO\n5;0.5\n500;0.5\n"
    profile = profile_of(
        tmp_path,
        "{file: p.csv}",
        "excitation: sine sweep, profile: p",
        csv=csv,
    )
    assert_allclose(profile.level, 0.5 * G)


def test_the_test_excites_what_its_profile_covers(tmp_path):
    (test,) = read_testlog(log_of(tmp_path, f"{{breakpoints: {POINTS}}}")).tests
    assert test.band == (20.0, 2000.0)


HEAD = "frequency [Hz],demand [g^2/Hz]\n"
MISTAKES = {
    "unsorted": ("[[20 Hz, 1 g], [90 Hz, 1 g], [80 Hz, 1 g]]", "rising.*80 Hz after 90 Hz"),
    "repeated": ("[[20 Hz, 1 g^2/Hz], [20 Hz, 2 g^2/Hz]]", "rising.*20 Hz twice"),
    "one": ("[[20 Hz, 1 g^2/Hz]]", "at least 2"),
    "slopes alone": ("[[20 Hz, 3 dB/oct], [80 Hz, 3 dB/oct]]", "slopes alone"),
    "mixed": ("[[20 Hz, 1 g^2/Hz], [80 Hz, 1 g]]", "1 g"),
    "negative": (
        "[[20 Hz, 1 g^2/Hz], [80 Hz, -1 g^2/Hz]]",
        r'level of more than 0, got "-1 g\^2/Hz" at 80 Hz',
    ),
    "zero hertz": ("[[0 Hz, 1 g^2/Hz], [80 Hz, 1 g^2/Hz]]", "frequency of more than 0"),
    "number for a level": ("[[20 Hz, 1 g^2/Hz], [80 Hz, 1]]", r"breakpoints\.2: .*unit of.*1"),
    "number for a frequency": ("[[20 Hz, 1 g^2/Hz], [80, 1 g^2/Hz]]", "unit of Hz.*80"),
    "a slope of a hundred decades": (
        "[[20 Hz, 1 g^2/Hz], [80 Hz, 500 dB/oct]]", "at most 12 decades.*500 dB/oct over 2 oct"
    ),
    "no unit": ("[[20 Hz, '1'], [80 Hz, '1']]", "a density such as"),
}  # fmt: skip
FILES = {
    "unsorted": (HEAD + "20,1\n10,1\n", r"p\.csv:3: expected breakpoints at rising"),
    "short row": (HEAD + "20,1\n10\n", r"p\.csv:3: expected 2 cells, got 1"),
    "no number": (HEAD + "20,1\n30,x\n", r"p\.csv:3: .*x g\^2/Hz"),
    "no unit": ("frequency,demand\n20,1\n", r"p\.csv:1: expected a header"),
    "empty": ("", "empty file"),
    "header alone": (HEAD, "at least two breakpoints"),
    "alarm beyond abort": (
        "frequency [Hz],demand [g^2/Hz],alarm [dB],abort [dB]\n20,1,9,6\n30,1,,\n",
        "alarm at most abort, got 9 dB",
    ),
    "column twice": ("demand [g],demand [g]\n", "one column demand"),
}
USES = {
    "unknown": ("excitation: random, profile: q", 'no profile "q".*the log has p'),
    "sweep of a density": ("excitation: sine sweep, profile: p", "expected excitation: random"),
    "level too": (
        "excitation: random, profile: p, level: 1 g^2/Hz",
        "expected no level beside a profile",
    ),
}


def fails(path, match):
    with pytest.raises(ShakerprocError, match=match) as caught:
        read_testlog(path)
    assert "\n" not in str(caught.value)
    assert path.parent.name in str(caught.value)


@pytest.mark.parametrize(("points", "match"), MISTAKES.values(), ids=MISTAKES)
def test_wrong_breakpoints(tmp_path, points, match):
    fails(log_of(tmp_path, f"{{breakpoints: {points}}}"), match)


@pytest.mark.parametrize(("csv", "match"), FILES.values(), ids=FILES)
def test_wrong_files(tmp_path, csv, match):
    fails(log_of(tmp_path, "{file: p.csv}", csv=csv), match)


@pytest.mark.parametrize(("use", "match"), USES.values(), ids=USES)
def test_wrong_uses(tmp_path, use, match):
    fails(log_of(tmp_path, f"{{breakpoints: {POINTS}}}", use), match)


@pytest.mark.parametrize("file", ["../p.csv", "/etc/passwd", "missing.csv"])
def test_files_elsewhere_or_nowhere(tmp_path, file):
    fails(log_of(tmp_path, f"{{file: {file}}}"), "expected a path below|no file")


def test_a_notch_outside_the_profile(tmp_path):
    notch = "[{from: 3000 Hz, to: 4000 Hz, depth: 6 dB}]"
    fails(
        log_of(tmp_path, f"{{breakpoints: {POINTS}, notches: {notch}}}"), "within the profile"
    )
