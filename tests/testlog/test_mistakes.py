"""A hundred typical mistakes in a log sheet, each told in one line at its place."""

import subprocess
import sys
import time

import pytest

from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

GOOD = """\
testlog: 1
title: Thin coupons
recordings: recordings
channels:
  control 1: {role: control}
  control 2: {role: control}
  3: {role: response, name: ch3, at: coupon, unit: g}
processing:
  crop: {channel: control 2, threshold: 0.45 g, hold: 0.1 s, skip: 1 s}
  sample_rate: 5688.9 Hz
  welch: {segment: 1024, overlap: 512, window: hamming}
  detrend: none
  band: {from: 5 Hz, to: 500 Hz}
  peaks: {distance: 25 Hz, count: 5}
  notch: {width: 2 Hz, harmonics: [1, 2], trim: 0.5 s}
  tolerance: {alarm: 3 dB, abort: 6 dB}
expect: {duration: 6 min, unit: g}
specimens:
  radial:
    a_0_05: {nominal: 0.05 mm, hole: 9.85 mm, bushing: 9.80 mm}
tests:
  - id: 1
    recording: Test_1/Acceleration.tdms
    joint: radial
    specimen: a_0_05
    clearance: 0.05 mm
    orientation: out of plane
    excitation: sine sweep
    level: 0.5 g
    from: 5 Hz
    to: 500 Hz
    rate: 1 oct/min
    hold_out: true
    tags: {temperature: 23.5}
  - {id: 2, recording: Test_2.tdms, joint: radial, excitation: random, level: 2e-4 g^2/Hz,
     from: 5 Hz, to: 1 kHz}
  - {id: 3, recording: Test_3.tdms, excitation: sine, level: 1 g, frequency: 50 Hz,
     notch: 50 Hz}
  - {id: 4, discarded: true, comment: operator error}
"""

# What stands in the good log, what somebody wrote instead (with § where the message has to
# point), and a part of the message (or one of two).
MISTAKES = [
    # the head
    ("testlog: 1", "testlog: §2", "testlog: expected 1, got 2"),
    ("testlog: 1", "testlog: §'1'", 'testlog: expected 1, got "1"'),
    ("testlog: 1\n", "§", 'expected the key "testlog", which is missing'),
    ("testlog: 1", "testlog: 1\n§version: 2", 'unknown key "version"'),
    ("title: Thin", "title: §5 #Thin", "title: expected text, got 5|is a comment"),
    ("title: Thin coupons", "title: Thin coupons§: new", 'a second ": "'),
    ("title: Thin", "§titel: Thin", 'unknown key "titel"; did you mean "title"'),
    ("recordings: recordings", "recordings: §../data", 'with ".."'),
    ("recordings: recordings", "recordings: §C:\\data", "a drive letter or a colon"),
    ("recordings: recordings", "recordings: §/data", "a slash in front"),
    ("recordings: recordings", "§recording: recordings", 'did you mean "recordings"'),
    # channels
    ("{role: control}\n  control 2", "{§rol: control}\n  control 2", 'did you mean "role"'),
    ("{role: response,", "{role: §respons,", 'got "respons"; did you mean "response"'),
    ("{role: response,", "{role: §Response,", 'did you mean "response"'),
    ("{role: response,", "{role: §input,", 'expected "control", "response"'),
    ("  control 2: {role: control}", "  §control 1: {role: control}", "duplicate key"),
    ("  control 2: {role: control}", "  control 2: §control", "expected a mapping"),
    ("  control 2: {role: control}", "  control 2: §{}", 'expected the key "role"'),
    ("name: ch3", "name: §control 1", 'a name of its own, got "control 1"'),
    ("name: ch3", "name: §3", "name: expected text, got 3; put it in quotes"),
    ("unit: g}", "unit: §G}", 'got "G"; no unit "G"; did you mean "g"'),
    ("unit: g}", "unit: §kg}", "no channel measures that"),
    ("unit: g}", "unit: V, sensitivity: §100 mV}", "volts per unit, such as 100 mV/g"),
    ("unit: g}", "unit: V, sensitivity: §10.21}", "such as 100 mV/g, got \"10.21\""),
    ("unit: g}", "unit: g, direction: §}", "expected a value after direction:, got nothing"),
    ("unit: g}", "unit: §g, sensitivity: 100 mV/g}", "take the sensitivity out if the numbers"),
    ("unit: g}", "override: §true}", "expected unit or sensitivity beside it"),
    ("unit: g}", "unit: g, override: §yes}", "did you mean true"),
    ("  3: {role", "  §0: {role", "at least 1"),
    # processing
    ("  detrend: none", "  time_unit: §msec", 'expected "s", "ms"'),
    ("  detrend: none", "  time_unit: §3", 'expected "s", "ms"'),
    ("  detrend: none", "  §timeunit: ms", 'did you mean "time_unit"'),
    ("  detrend: none", "  resample: §2000", "write it with its unit"),
    ("  detrend: none", "  resample: §0 Hz", "expected more than 0"),
    ("  detrend: none", "  resample: §2 s", '"s" is not such a unit'),
    ("  detrend: none", "  starts: §ignored", 'did you mean "ignore"'),
    ("sample_rate: 5688.9 Hz", "sample_rate: {value: §-1 Hz}", "expected more than 0"),
    ("sample_rate: 5688.9 Hz", "sample_rate: {value: §2}", "write it with its unit"),
    ("sample_rate: 5688.9 Hz", "sample_rate: {value: 2 kHz, override: §yes}",
     "did you mean true"),
    ("sample_rate: 5688.9 Hz", "sample_rate: {value: 2 kHz, §overide: true}",
     'did you mean "override"'),
    ("sample_rate: 5688.9 Hz", "sample_rate: §{override: true}", 'expected the key "value"'),
    ("sample_rate: 5688.9 Hz", "sample_rate: §[2 kHz]", "expected"),
    ("channel: control 2,", "channel: §control 3,", "got \"control 3\"; did you mean"),
    ("channel: control 2,", "channel: §Control 2,", 'did you mean "control 2"'),
    ("channel: control 2,", "§chanel: control 2,", 'did you mean "channel"'),
    ("threshold: 0.45 g", "threshold: §0.45", "write it with its unit, as 0.45 g"),
    ("threshold: 0.45 g", "threshold: 0,§45 g", "use a decimal point: 0.45 g"),
    ("threshold: 0.45 g", "threshold: §'0,45 g'", "use a decimal point: 0.45 g"),
    ("threshold: 0.45 g", "threshold: §0.45 mm", '"mm" is not such a unit'),
    ("threshold: 0.45 g", "threshold: §-0.45 g", "expected more than 0, such as 0.45 g"),
    ("threshold: 0.45 g,", "§treshold: 0.45 g,", 'did you mean "threshold"'),
    ("{channel: control 2, threshold: 0.45 g, hold: 0.1 s, skip: 1 s}", "§all", 'got "all"'),
    ("{channel: control 2, threshold: 0.45 g, hold: 0.1 s, skip: 1 s}",
     "{from: 40 s, to: §2 s}", "expected an end after the start"),
    ("{channel: control 2, threshold: 0.45 g, hold: 0.1 s, skip: 1 s}",
     "{from: 2 s, §threshold: 1 g}", 'unknown key "threshold"; the keys here are from, to'),
    ("hold: 0.1 s", "hold: §100", "write it with its unit, as 100 s"),
    ("skip: 1 s", "skip: §-1 s", "expected at least 0"),
    ("skip: 1 s", "absolute: §yes", "did you mean true"),
    ("sample_rate: 5688.9 Hz", "sample_rate: §5688.9", "as 5688.9 Hz"),
    ("sample_rate: 5688.9 Hz", "sample_rate: §5.6889 khz", 'did you mean "kHz"'),
    ("sample_rate: 5688.9 Hz", "§samplerate: 5688.9 Hz", 'did you mean "sample_rate"'),
    ("sample_rate: 5688.9 Hz", "§sample rate: 5688.9 Hz", 'did you mean "sample_rate"'),
    ("segment: 1024,", "segment: §1024.5,", "expected a whole number, got 1024.5"),
    ("segment: 1024,", "segment: §1 k,", 'expected a whole number, got "1 k"'),
    ("segment: 1024,", "segment: §4,", "at least 8"),
    ("overlap: 512,", "overlap: §1024,", "an overlap below the segment of 1024, got 1024"),
    ("overlap: 512,", "overlap: §50 %,", 'expected a whole number, got "50 %"'),
    ("window: hamming", "window: §haming", 'did you mean "hamming"'),
    ("window: hamming", "window: hann, n_fft: §512", "at least the segment of 1024, got 512"),
    ("detrend: none", "detrend: §linear", 'expected "none", "mean" or "segment mean"'),
    ("detrend: none", "detrend: §no", 'got "no"'),
    ("band: {from: 5 Hz, to: 500 Hz}", "band: {from: 500 Hz, to: §5 Hz}", "from below to"),
    ("band: {from: 5 Hz, to: 500 Hz}", "band: §{from: 5 Hz}", 'expected the key "to"'),
    ("band: {from: 5 Hz, to: 500 Hz}", "band: §5-500 Hz", "expected a mapping"),
    ("count: 5}", "count: §many}", 'expected a whole number, got "many"'),
    ("harmonics: [1, 2]", "harmonics: §2", "expected a list, got 2"),
    ("harmonics: [1, 2]", "harmonics: [1, §0]", "at least 1, got 0"),
    ("width: 2 Hz", "width: §0 Hz", "expected more than 0"),
    ("alarm: 3 dB", "alarm: §9 dB", "at most abort"),
    ("alarm: 3 dB", "alarm: §3 db", 'did you mean "dB"'),
    # what is expected of recordings, and specimens
    ("duration: 6 min", "duration: §6 Min", 'did you mean "min"'),
    ("duration: 6 min", "duration: §6:30", "a number with a unit of s"),
    ("duration: 6 min", "sha256: §abc", "64 hexadecimal digits"),
    ("  radial:\n    a", "  radial: §none\n  x:\n    a", "expected a mapping"),
    ("hole: 9.85 mm, bushing: 9.80 mm", "hole: 9.80 mm, bushing: §9.85 mm", "not larger"),
    ("hole: 9.85 mm", "clearance: §0.10 mm, hole: 9.85 mm", "hole less bushing, 0.05 mm"),
    ("nominal: 0.05 mm", "nominal: §0.05", "as 0.05 mm"),
    # tests
    ("tests:\n", "§test:\n", 'unknown key "test"; did you mean "tests"'),
    ("  - id: 1\n    recording", "  - §recording", 'tests.1: expected the key "id"'),
    ("{id: 2,", "{id: §1,", "an id of its own, got \"1\" as on line 22"),
    ("{id: 2,", "{id: §'1',", 'an id of its own, got "1"'),
    ("{id: 2,", "{id: §1.5,", "id: expected a whole number or text, got 1.5"),
    ("{id: 2,", "{id: §2/3,", "it becomes part of file names"),
    ("{id: 2,", "{§id:2,", "put a space after the colon: id: 2"),
    ("{id: 2,", "{§Id: 2,", 'did you mean "id"'),
    ("Test_1/Acceleration.tdms", "§../Test_1.tdms", 'with ".."'),
    ("Test_1/Acceleration.tdms", "§\\\\server\\share\\a.tdms", "a slash in front"),
    ("Test_1/Acceleration.tdms", "§D:/Test_1.tdms", "a drive letter"),
    ("recording: Test_3.tdms", "recording: §Test_2.tdms", "the recording of test 2 on line"),
    ("recording: Test_3.tdms", "recording: §nul.tdms", "the name of a device"),
    ("    joint: radial", "    joint: §5", "joint: expected text, got 5; put it in quotes"),
    ("Test_2.tdms, joint: radial", "Test_2.tdms, joint: §Radial", 'did you mean "radial", as'),
    ("clearance: 0.05 mm", "clearance: §0.05", "as 0.05 mm"),
    ("clearance: 0.05 mm", "clearance: §0.10 mm", "0.05 mm, the nominal clearance of radial"),
    ("clearance: 0.05 mm", "clearance: §0.05 g", '"g" is not such a unit'),
    ("clearance: 0.05 mm", "clearance: §-0.05 mm", "expected at least 0"),
    ("excitation: sine sweep", "excitation: §sin sweep", 'did you mean "sine sweep"'),
    ("excitation: sine sweep", "excitation: §sine-sweep", 'did you mean "sine sweep"'),
    ("excitation: sine sweep", "excitation: §Random", 'did you mean "random"'),
    ("excitation: sine sweep", "excitation: §noise", 'expected "sine sweep", "random"'),
    ("level: 0.5 g", "§levl: 0.5 g", 'unknown key "levl"; did you mean "level"'),
    ("level: 0.5 g", "level: §0.5", "write it with its unit, as 0.5 g"),
    ("level: 0.5 g", "level: §3,2 g", "use a decimal point: 3.2 g"),
    ("level: 0.5 g", "level:§", "got nothing"),
    ("level: 0.5 g", "level: §0 g", "expected more than 0"),
    ("level: 0.5 g", "level: §0.5 g rms", "a sine sweep test as an amplitude"),
    ("level: 0.5 g", "level: §0.01 g^2/Hz", "a sine sweep test as an amplitude"),
    ("level: 0.5 g", "level: §0.5 kg", "not such a unit"),
    ("level: 2e-4 g^2/Hz", "level: §0.5 g", "as a density, such as 0.0002 g^2/Hz"),
    ("level: 2e-4 g^2/Hz", "level: §2e-4", "such as 0.01 g^2/Hz"),
    ("level: 2e-4 g^2/Hz", "level: §2e-4 g2/Hz", "g2/Hz"),
    ("    from: 5 Hz\n", "    from: 5 Hz\n    §from: 5 Hz\n", "duplicate key"),
    ("    from: 5 Hz\n    to: 500 Hz", "    from: §5\n    to: 500 Hz", "as 5 Hz"),
    ("    from: 5 Hz\n    to: 500 Hz", "    from: 5 Hz\n    to: §5 Hz", "that differ"),
    ("from: 5 Hz, to: 1 kHz", "from: 1 kHz, to: §5 Hz", "only a sweep can go down"),
    ("from: 5 Hz, to: 1 kHz", "from: §5-1000 Hz", "not written as a unit"),
    ("rate: 1 oct/min", "rate: §1", "as 1 oct/min"),
    ("rate: 1 oct/min", "rate: §1 octave", "is not such a unit"),
    ("rate: 1 oct/min", "frequency: §50 Hz", "means nothing for excitation: sine sweep"),
    ("{id: 3, recording: Test_3.tdms, excitation: sine, level: 1 g, frequency: 50 Hz,\n    ",
     "§{id: 3, recording: Test_3.tdms, excitation: sine, level: 1 g,\n    ",
     'expected the key "frequency" for excitation: sine, such as frequency: 50 Hz'),
    ("{id: 3, recording: Test_3.tdms, excitation: sine, level: 1 g, frequency: 50 Hz",
     "§{id: 3, recording: Test_3.tdms, excitation: sine sweep, level: 1 g",
     'expected the key "from" for excitation: sine sweep, such as from: 5 Hz'),
    ("excitation: sine, level: 1 g", "excitation: sine, rate: §1 oct/min, level: 1 g",
     "means nothing for excitation: sine; take it out|means nothing"),
    ("frequency: 50 Hz", "frequency: §50 hz", 'did you mean "Hz"'),
    ("excitation: sine, level: 1 g, frequency: 50 Hz",
     "excitation: shock, from: §5 Hz, level: 1 g", 'both "from" and "to", or neither'),
    ("joint: radial\n    spec", 'joint: §"a\\nb"\n    spec', "expected one line of text"),
    ("excitation: random, level", "tones: §[{frequency: 17 Hz}], excitation: random, level",
     "means something for excitation: sine on random only"),
    *(("excitation: random, level", f"excitation: sine on random, tones: [{tone}], level", told)
      for tone, told in (
          ("{§frequenzy: 17 Hz}", 'unknown key "frequenzy"; did you mean "frequency"'),
          ("{frequency: §17}", "a number with a unit of Hz"),
          ("{frequency: §2 Hz}", "within the band of the test, 5 to 1000 Hz, got 2 Hz"),
          ("{frequency: 17 Hz, level: §2.5}", "as an amplitude|a unit"),
          ("{frequency: 17 Hz, level: §20 N}", "an amplitude of the signal of"),
          ("{frequency: 17 Hz, from: §5 Hz, to: 9 Hz}", "expected fixed tones only"),
          ("{frequency: 17 Hz}, {frequency: §17 Hz}", "expected each tone once"),
          ("§{level: 2 g}", 'expected the key "frequency"'),
      )),
    ("operator error", "§" + 6000 * "x", "at most 5000 characters"),
    ("notch: 50 Hz", "notch: §on", 'a number with a unit of Hz, such as 500 Hz, got "on"'),
    ("hold_out: true", "hold_out:§ ", "expected a value after hold_out:, got nothing"),
    ("hold_out: true", "hold_out: §yes", "did you mean true"),
    ("hold_out: true", "§holdout: true", 'did you mean "hold_out"'),
    ("hold_out: true", "§hold out: true", 'did you mean "hold_out"'),
    ("tags: {temperature: 23.5}", "§temperature: 23.5", 'unknown key "temperature"'),
    ("tags: {temperature: 23.5}", "tags: {temperature: §[1]}", "text or a whole number"),
    ("tags: {temperature: 23.5}", "tags: §[warm]", "expected a mapping"),
    ("discarded: true", "discarded: §1", "expected true or false, got 1"),
    ("comment: operator error", "comment: §run #3", "is a comment"),
    ("comment: operator error}\n", "comment: operator error\n§", 'expected "," or "}"'),
]  # fmt: skip


def place_of(marked):
    before = marked.partition("§")[0]
    return before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1


@pytest.fixture
def log(tmp_path):
    def write(text):
        path = tmp_path / "testlog.yaml"
        path.write_text(text)
        return path

    return write


def test_the_good_log_is_good(log):
    assert [test.id for test in read_testlog(log(GOOD)).tests] == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("old", "new", "match"), MISTAKES, ids=[new[:40] for _, new, _ in MISTAKES]
)
def test_a_mistake_is_told_at_its_place(log, old, new, match):
    assert GOOD.count(old) >= 1
    marked = GOOD.replace(old, new, 1)
    path = log(marked.replace("§", ""))
    start = time.process_time()
    with pytest.raises(DocumentError) as caught:
        read_testlog(path)
    assert time.process_time() - start < 0.5
    message = str(caught.value)
    assert any(part in message for part in match.split("|")), message
    assert (caught.value.line, caught.value.column) == place_of(marked), message
    assert message.startswith(f"{path}:{caught.value.line}:{caught.value.column}: ")
    assert message.isprintable()
    assert len(message) - len(str(path)) < 350


PROGRAM = """
import resource, sys
from pathlib import Path
from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3

before, refused = peak(), 0
for path in sorted(Path(sys.argv[1]).glob("*.yaml")):
    try:
        read_testlog(path)
    except DocumentError:
        refused += 1
print(refused, peak() - before)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not tell the peak memory")
def test_all_mistakes_together_take_less_than_100_mb(tmp_path):
    for number, (old, new, _) in enumerate(MISTAKES):
        text = GOOD.replace(old, new, 1).replace("§", "")
        (tmp_path / f"{number}.yaml").write_text(text)
    command = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    refused, megabytes = done.stdout.split()
    assert int(refused) == len(MISTAKES)
    assert float(megabytes) < 100.0


def test_there_are_a_hundred_mistakes():
    assert len(MISTAKES) >= 100
