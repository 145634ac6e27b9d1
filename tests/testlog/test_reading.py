"""What a log sheet becomes: SI numbers, defaults, overrides, measured specimens, columns."""

import math
import pickle
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shakerproc.data import ChannelUse
from shakerproc.documents import Section
from shakerproc.errors import DocumentError, LogError
from shakerproc.spectra.welch.windows import COSINE_TERMS
from shakerproc.testlog import (
    Processing,
    ThresholdCrop,
    TimeCrop,
    Welch,
    facts_of,
    read_testlog,
    schema,
)
from shakerproc.testlog.processing_sections import WINDOWS

G = 9.80665
RANDOM = "random, from: 5 Hz, to: 9 Hz"
CONFIGS = Path(__file__).resolve().parents[2] / "configs"


@pytest.fixture
def log(tmp_path):
    def read(text, head=""):
        path = tmp_path / "testlog.yaml"
        path.write_text(f"testlog: 1\n{head}tests:\n{text}")
        return read_testlog(path)

    return read


def test_the_log_of_the_design_is_read(tmp_path):
    path = tmp_path / "testlog.yaml"
    path.write_text("""\
testlog: 1
title: Thin POM C coupons
recordings: recordings              # folder beside this file; nothing outside it is ever read
channels:                           # name in the recording, or its number
  control 1:  {role: control}
  control 2:  {role: control}
  response 1: {role: response, name: ch3, at: coupon}
  response 2: {role: response, name: ch4, at: rim}
processing:                         # all optional; these are the defaults
  crop: {channel: control 2, threshold: 0.45 g}     # or {from: 2 s, to: 40 s}; or none
  sample_rate: 5688.9 Hz            # only where the recording does not say it
  welch: {segment: 1024, overlap: 512, window: hamming}
tests:
  - {id: 1, recording: Test_1/Acceleration.tdms, joint: radial, specimen: a_0_00,
     clearance: 0.00 mm, orientation: out of plane, excitation: sine sweep, level: 0.5 g,
     from: 5 Hz, to: 500 Hz, rate: 1 oct/min}
  - {id: 6, joint: radial, specimen: a_0_00, discarded: true, comment: operator error}
  - {id: 8, recording: Test_8/Acceleration.tdms, excitation: random, level: 0.0002 g^2/Hz,
     from: 5 Hz, to: 1000 Hz}
  - {id: 93, recording: b.tdms, excitation: sine, level: 1 g, frequency: 50 Hz, notch: 50 Hz}
  - {id: 31, recording: c.tdms, hold_out: true}   # never fitted to, only scored
""")
    log = read_testlog(path)
    assert log.title == "Thin POM C coupons"
    assert [test.id for test in log.tests] == [1, 6, 8, 93, 31]
    assert [test.id for test in log.active] == [1, 8, 93, 31]
    first, _, eighth, harmonic, scored = log.tests
    assert first.recording == tmp_path / "recordings" / "Test_1" / "Acceleration.tdms"
    assert (first.joint, first.specimen, first.clearance) == ("radial", "a_0_00", 0.0)
    assert (first.orientation, first.excitation) == ("out of plane", "sine sweep")
    assert (first.level, first.level_unit) == (pytest.approx(0.5 * G), "m/s^2")
    assert (first.from_hz, first.to_hz, first.rate_oct_per_min) == (5.0, 500.0, 1.0)
    assert first.band == (5.0, 500.0)
    assert first.channels[2] == ChannelUse("response 1", "response", "ch3", "coupon")
    assert first.processing == Processing(sample_rate=5688.9)
    assert (eighth.level, eighth.level_unit) == (pytest.approx(2e-4 * G**2), "(m/s^2)^2/Hz")
    assert (harmonic.frequency_hz, harmonic.notch_hz, harmonic.band) == (50.0, 50.0, None)
    assert scored.hold_out
    assert not first.hold_out


def test_a_log_may_say_very_little(log):
    found = log("  - {id: a}\n")
    assert found.title == "testlog"
    assert found.tests[0].processing == Processing()
    assert found.tests[0].channels == ()
    assert found.tests[0].recording is None


def test_defaults_are_those_of_the_design():
    assert Processing().crop == ThresholdCrop("control 2", 0.45 * G)
    assert Processing().welch == Welch(1024, 512, "hamming", None)


def test_every_key_is_explained_in_a_log_that_can_be_read():
    log = read_testlog(CONFIGS / "all_keys.yaml")
    first = log.find(1)
    # What stands there as the default is the default.
    assert first.processing == Processing()
    assert first.actual_clearance == pytest.approx(6e-5)
    assert log.find(2).actual_clearance is None
    assert log.find("3").processing.welch == Welch(2048, 1024)
    assert log.find(3).processing.crop == ThresholdCrop("control 2", pytest.approx(0.9 * G))
    assert [use.role for use in log.find(3).channels][-1] == "ignore"
    assert log.find(4).discarded
    assert first.tags == {"temperature": 23.5, "beeswax": "true"}


def test_every_key_of_the_schema_is_explained():
    text = (CONFIGS / "all_keys.yaml").read_text()
    sections = [
        section
        for section in vars(schema).values()
        if isinstance(section, type) and issubclass(section, Section) and section is not Section
    ]
    assert len(sections) >= 14
    for section in sections:
        for field, info in section.model_fields.items():
            known = f"{info.alias or field}:" in text
            assert known or section is schema.SpecimensFile, (section, field)


def test_windows_are_those_of_the_spectra():
    assert set(WINDOWS) == set(COSINE_TERMS)


@pytest.mark.parametrize(
    ("processing", "crop"),
    [
        ("crop: none", None),
        ("crop: {from: 2 s, to: 40 s}", TimeCrop(2.0, 40.0)),
        ("crop: {from: 2 s}", TimeCrop(2.0, None)),
        ("crop: {to: 0.5 min}", TimeCrop(0.0, 30.0)),
        ("crop: {threshold: 1 m/s^2}", ThresholdCrop("control 2", 1.0)),
        ("crop: {threshold: 20 N}", ThresholdCrop("control 2", 20.0)),
        ("crop: {hold: 100 ms}", ThresholdCrop("control 2", 0.45 * G, hold=0.1)),
        ("crop: {absolute: true}", ThresholdCrop("control 2", 0.45 * G, absolute=True)),
        (
            "crop: {remove_offset: true}",
            ThresholdCrop("control 2", 0.45 * G, remove_offset=True),
        ),
        ("crop: {channel: 4, skip: 3 s}", ThresholdCrop(4, 0.45 * G, skip=3.0)),
    ],
)
def test_a_crop_is_by_threshold_by_times_or_none(log, processing, crop):
    test = log(f"  - {{id: 1, processing: {{{processing}}}}}\n").tests[0]
    assert test.processing.crop == crop
    same = log("  - {id: 1}\n", head=f"processing: {{{processing}}}\n").tests[0]
    assert same.processing.crop == crop


def test_a_test_overrides_key_by_key(log):
    head = (
        "processing: {crop: {hold: 1 s}, welch: {window: hann, overlap: 700}, detrend: mean}\n"
    )
    found = log(
        "  - {id: 1, processing: {welch: {segment: 4096}, crop: {skip: 2 s}}}\n"
        "  - {id: 2, processing: {welch: {n_fft: 2048}, band: {from: 5 Hz, to: 90 Hz}}}\n"
        "  - {id: 3, processing: {peaks: {count: 2}, notch: {harmonics: [1, 3]}}}\n",
        head,
    ).tests
    assert found[0].processing.welch == Welch(4096, 2048, "hann")
    assert found[0].processing.crop == ThresholdCrop("control 2", 0.45 * G, hold=1.0, skip=2.0)
    assert found[0].processing.detrend == "mean"
    assert found[1].processing.welch == Welch(1024, 700, "hann", 2048)
    assert found[1].processing.band == (5.0, 90.0)
    assert found[2].processing.notch.harmonics == (1, 3)
    assert found[2].processing.peaks.count == 2


def test_a_test_says_anew_what_it_says_of_the_times(log):
    head = (
        "processing: {sample_rate: {value: 2 kHz, override: true}, time_unit: ms,"
        " resample: 1 kHz, starts: ignore}\n"
    )
    same, other = (
        test.processing
        for test in log(
            "  - {id: 1}\n"
            "  - {id: 2, processing: {sample_rate: 3 kHz, time_unit: us, resample: 500 Hz,"
            " starts: stated}}\n",
            head,
        ).tests
    )
    assert (same.sample_rate, same.override_rate, same.time_unit) == (2000.0, True, "ms")
    assert (same.resample, same.ignore_starts) == (1000.0, True)
    assert (other.sample_rate, other.override_rate, other.time_unit) == (3000.0, False, "us")
    assert (other.resample, other.ignore_starts) == (500.0, False)


def test_the_crop_takes_the_only_control_where_there_is_no_second(log):
    head = "channels: {1: {role: control, name: table}, 2: {role: response}}\n"
    found = log("  - {id: 1}\n  - {id: 2, channels: {3: {role: control}}}\n", head).tests
    assert found[0].processing.crop.channel == "table"
    assert found[1].processing.crop.channel == "table"


def test_a_crop_channel_may_be_named_by_key_name_or_rank(log):
    head = "channels: {1: {role: control, name: table}, 2: {role: control}}\n"
    for channel in ("1", "table", "control 1", "control 2", "2"):
        text = f"  - {{id: 1, processing: {{crop: {{channel: {channel}}}}}}}\n"
        assert str(log(text, head).tests[0].processing.crop.channel) == channel


@pytest.mark.parametrize(
    ("excitation", "level", "si", "unit", "column", "shown"),
    [
        ("sine, frequency: 5 Hz", "1.0 g", G, "m/s^2", "level_g", 1.0),
        ("sine, frequency: 5 Hz", "20 N", 20.0, "N", "level_n", 20.0),
        ("shock", "15 g", 15 * G, "m/s^2", "level_g", 15.0),
        (RANDOM, "2e-4 g²/Hz", 2e-4 * G**2, "(m/s^2)^2/Hz",
         "level_g2_per_hz", 2e-4),
        (RANDOM, "0.45 g rms", 0.45 * G, "m/s^2 rms", "level_g_rms", 0.45),
        (RANDOM, "0.45 gRMS", 0.45 * G, "m/s^2 rms", "level_g_rms", 0.45),
        (RANDOM, "3 N^2/Hz", 3.0, "N^2/Hz", "level_n2_per_hz", 3.0),
        (RANDOM, "3 N rms", 3.0, "N rms", "level_n_rms", 3.0),
    ],
)  # fmt: skip
def test_a_level_has_the_unit_of_its_excitation(
    log, excitation, level, si, unit, column, shown
):
    test = log(f"  - {{id: 1, excitation: {excitation}, level: {level}}}\n").tests[0]
    assert test.level == pytest.approx(si, rel=1e-14)
    assert test.level_unit == unit
    assert facts_of(test)[column] == pytest.approx(shown, rel=1e-12)


def test_levels_that_are_the_same_read_the_same(log):
    tests = log("  - {id: 1, level: 1.0 g}\n  - {id: 2, level: 1  g}\n").tests
    assert [test.level_text for test in tests] == ["1 g", "1 g"]


def test_sweeps_are_logarithmic_or_linear_up_or_down(log):
    head = "  - {id: 1, excitation: sine sweep, from: 500 Hz, to: 5 Hz, rate: 2 oct/min}\n"
    down, linear = log(
        head + "  - {id: 2, excitation: sine sweep, from: 5 Hz, to: 500 Hz, rate: 2 Hz/s}\n"
    ).tests
    assert (down.band, down.rate_oct_per_min) == ((5.0, 500.0), pytest.approx(2.0))
    assert (linear.rate_hz_per_s, linear.rate_oct_per_min) == (2.0, None)


def test_dimensions_give_the_actual_clearance(log):
    head = (
        "specimens:\n  radial:\n"
        "    a: {nominal: 0 mm, hole: 9.85 mm, bushing: 9.80 mm,\n"
        "        thickness: 2.54 mm, bushing_thickness: 2.69 mm}\n"
        "    b: {clearance: 0.02 mm}\n"
    )
    a, fixed, b, other = log(
        "  - {id: 1, joint: radial, specimen: a}\n"
        "  - {id: 2, joint: radial, specimen: a, actual_clearance: 0 mm}\n"
        "  - {id: 3, joint: radial, specimen: b, clearance: 0.05 mm}\n"
        "  - {id: 4, joint: slot, specimen: a, clearance: 0.05 mm}\n",
        head,
    ).tests
    assert (a.clearance, a.actual_clearance) == (0.0, pytest.approx(5e-5))
    assert a.actual_axial_clearance == pytest.approx(1.5e-4)
    assert (fixed.actual_clearance, fixed.actual_axial_clearance) == (0.0, None)
    assert (b.clearance, b.actual_clearance) == (5e-5, 2e-5)
    assert (other.clearance, other.actual_clearance) == (5e-5, None)


def test_specimens_may_have_a_file_of_their_own(tmp_path):
    (tmp_path / "specimens.yaml").write_text(
        "specimens: 1\njoints:\n  radial:\n    a: {hole: 9.85 mm, bushing: 9.80 m}\n"
    )
    (tmp_path / "testlog.yaml").write_text("testlog: 1\nspecimens: specimens.yaml\ntests: []\n")
    with pytest.raises(
        DocumentError, match=r"specimens\.yaml:4:33: joints\.radial\.a\.bushing"
    ):
        read_testlog(tmp_path / "testlog.yaml")
    (tmp_path / "specimens.yaml").unlink()
    with pytest.raises(DocumentError, match=r"testlog\.yaml:2:12: specimens: no file"):
        read_testlog(tmp_path / "testlog.yaml")


def test_tags_are_columns_after_the_usual_ones(log):
    facts = facts_of(log("  - {id: 1, tags: {lab: FFI, run: 3, dry: true, t: 1.5}}\n").tests[0])
    assert list(facts)[-4:] == ["lab", "run", "dry", "t"]
    assert [facts[key] for key in ("lab", "run", "dry", "t")] == ["FFI", 3, "true", 1.5]


def test_a_tag_may_not_take_the_name_of_a_column(log):
    with pytest.raises(DocumentError, match=r"3:27: tests\.1\.tags\.level: .* another name"):
        log("  - {id: 1, tags: {level: high}}\n")


def test_a_test_is_found_by_its_id(log):
    found = log("  - {id: 1}\n  - {id: 7b}\n")
    assert found.find("1").id == 1
    assert found.find(1).id == 1
    with pytest.raises(LogError, match=r'no test "7B"; did you mean "7b"\?; the log has 1, 7b'):
        found.find("7B")


def test_an_error_about_a_test_names_file_line_and_key(log):
    found = log("  - {id: 1}\n  - {id: 2, joint: radial}\n")
    error = found.error(found.tests[1], "expected another joint", "joint")
    assert str(error) == f"{found.path}:4:20: tests.2.joint: expected another joint"


def test_a_log_goes_to_another_process_and_back(log):
    found = pickle.loads(pickle.dumps(log("  - {id: 1, tags: {a: 1}}\n")))  # noqa: S301
    assert found.tests[0].tags == {"a": 1}
    assert found.document.line(("tests", 0)) == 3


numbers = st.floats(1e-3, 1e6).map(lambda x: float(f"{x:.6g}"))
words = st.text(st.characters(codec="utf-8", categories=("L", "N")), min_size=1, max_size=8)


@settings(deadline=None)
@given(
    st.lists(
        st.fixed_dictionaries({
            "joint": words, "level": numbers, "low": numbers, "factor": st.floats(1.01, 100.0),
            "clearance": numbers, "hold_out": st.booleans(), "tag": words | numbers,
        }),
        min_size=1, max_size=6,
    )
)  # fmt: skip
def test_what_is_written_is_read_back(tmp_path_factory, rows):
    rows = [row | {"joint": f"joint {i} {row['joint']}"} for i, row in enumerate(rows)]
    lines = [
        f"  - {{id: {i}, recording: r_{i}.tdms, joint: '{row['joint']}', excitation: random,\n"
        f"     level: {row['level']!r} g^2/Hz, from: {row['low']!r} Hz,\n"
        f"     to: {row['low'] * row['factor']!r} Hz, clearance: {row['clearance']!r} mm,\n"
        f"     hold_out: {str(row['hold_out']).lower()},\n"
        f"     tags: {{x: {_written(row['tag'])}}}}}\n"
        for i, row in enumerate(rows)
    ]
    path = tmp_path_factory.getbasetemp() / "round.yaml"
    path.write_text("testlog: 1\ntests:\n" + "".join(lines), encoding="utf-8")
    for test, row in zip(read_testlog(path).tests, rows, strict=True):
        assert test.joint == row["joint"]
        assert test.level == pytest.approx(row["level"] * G**2, rel=1e-14)
        assert test.band == (row["low"], row["low"] * row["factor"])
        assert math.isclose(test.clearance * 1e3, row["clearance"], rel_tol=1e-14)
        assert test.hold_out is row["hold_out"]
        assert test.tags == {"x": row["tag"]}


def _written(tag):
    return f"'{tag}'" if isinstance(tag, str) else repr(tag)


def test_five_thousand_rows_are_read(tmp_path):
    rows = "".join(
        f"  - {{id: {n}, recording: Test_{n}/Acceleration.tdms, joint: radial,\n"
        "     specimen: a_0_00, clearance: 0.00 mm, orientation: out of plane,\n"
        "     excitation: sine sweep, level: 0.5 g, from: 5 Hz, to: 500 Hz, rate: 1 oct/min}\n"
        for n in range(5000)
    )
    path = tmp_path / "testlog.yaml"
    path.write_text("testlog: 1\ntests:\n" + rows)
    assert len(read_testlog(path).tests) == 5000
