"""Group, channels, rate and units: what the file says, what the log says, and both."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.recordings.tdms_bytes import (
    METADATA,
    NEW_LIST,
    RAW,
    index,
    listed,
    metadata,
    segment,
)

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import UNKNOWN, ChannelNotFoundError, FilePart, open_recording
from shakerproc.recordings.si import parse_unit

A_SEGMENT = METADATA | NEW_LIST | RAW


@pytest.fixture
def write(tmp_path):
    def write(channels, name="run.tdms"):
        """Channels are (path, properties) or (path, properties, count)."""
        objects, raw = [], b""
        for path, properties, *count in channels:
            n = count[0] if count else 6
            objects.append(listed(path, index("f8", n), properties))
            raw += np.arange(1.0, n + 1.0).tobytes()
        file = tmp_path / name
        file.write_bytes(segment(metadata(objects), raw, A_SEGMENT))
        return file

    return write


def channel(name, group="All Data", unit="g", step=0.001, **more):
    said = {} if step is None else {"wf_increment": step}
    said |= {} if unit is None else {"unit_string": unit}
    return (f"/'{group}'/'{name}'", said | more)


def refused(path, match, **options):
    with pytest.raises(RecordingError, match=match) as caught, open_recording(path, **options):
        pass
    return str(caught.value)


def test_channels_come_by_name_or_number_in_the_order_of_the_log(write):
    path = write([channel("control 1"), channel("control 2"), channel("resp")])
    uses = [
        ChannelUse(3, "response", name="ch3", at="coupon"),
        ChannelUse("control 1", "control"),
        ChannelUse("no such channel", "ignore"),
    ]
    with open_recording(path, uses=uses, run="test 7") as recording:
        assert recording.run == "test 7"
        assert [c.name for c in recording.channels] == ["ch3", "control 1"]
        assert [c.source_name for c in recording.channels] == ["resp", "control 1"]
        assert [c.role for c in recording.channels] == ["response", "control"]
        assert recording.channels[0].at == "coupon"
        assert_allclose(
            recording.samples(), np.tile(np.arange(1.0, 7.0), (2, 1)) * STANDARD_GRAVITY
        )


def test_a_missing_channel_names_the_near_one_and_all_that_are_there(write):
    path = write([channel("control 1"), channel("response 1")])
    with pytest.raises(ChannelNotFoundError) as caught:
        open_recording(path, uses=[ChannelUse("Control_1", "control")])
    assert caught.value.wanted == "Control_1"
    assert caught.value.present == ("control 1", "response 1")
    assert "did you mean 'control 1'?" in str(caught.value)
    assert "The recording has 'control 1', 'response 1'" in str(caught.value)
    refused(path, "no channel '3'", uses=[ChannelUse(3, "control")])
    refused(path, "no channel '0'", uses=[ChannelUse(0, "control")])


def test_a_channel_is_used_once_and_named_once(write):
    path = write([channel("a"), channel("b")])
    refused(path, "used twice", uses=[ChannelUse("a", "control"), ChannelUse(1, "response")])
    uses = [ChannelUse("a", "control", name="x"), ChannelUse("b", "response", name="x")]
    refused(path, "two channels are named 'x'", uses=uses)
    refused(path, "no channel is used", uses=[ChannelUse("a", "ignore")])


def test_groups(write):
    groups = [
        channel("a", "one"),
        channel("b", "one"),
        channel("a", "two"),
        channel("c", "two"),
    ]
    path = write(groups)
    message = refused(path, "2 groups hold data: 'one' .2 channels at 1000 Hz.; 'two'")
    assert 'processing: {group: "one"}' in message
    refused(path, "2 groups", uses=[ChannelUse("a", "control")])
    refused(
        path, r"no group 'twoo'; did you mean 'two'\? The recording has", part=FilePart("twoo")
    )
    with open_recording(path, uses=[ChannelUse("c", "control")]) as recording:
        assert recording.channels[0].name == "c"
    with open_recording(path, part=FilePart("two")) as recording:
        assert [c.name for c in recording.channels] == ["a", "c"]


def test_decimated_copies_are_never_taken_by_themselves(write):
    title = "05/06/2024 07:08:09 AM - run"
    path = write([
        (f"/'{title} - Decimated Data_Level1'/'a'", {"wf_increment": 0.05}),
        channel("a", f"{title} - All Data"),
    ])
    with open_recording(path) as recording:
        assert recording.sample_rate == 1000.0
    with open_recording(path, uses=[ChannelUse("a", "control")]) as recording:
        assert recording.sample_rate == 1000.0
    path = write([channel("a", "x", DecimationLevel=1), channel("a", "y")])
    refused(path, "2 groups")  # the level of a channel is not that of its group


def test_rates_must_be_there_and_alike(write):
    path = write([channel("a"), channel("b", step=0.002)])
    refused(path, "'a' has 1000 samples per second, 'b' 500")
    with open_recording(path, uses=[ChannelUse("b", "control")]) as recording:
        assert recording.sample_rate == 500.0
    path = write([channel("a"), channel("b", step=None)])
    message = refused(path, "no sample rate for channel 'b'")
    assert "processing: {sample_rate: 1000 Hz}" in message
    with open_recording(path, sample_rate=1000.0) as recording:
        assert "is taken as given" in recording.notes[0]


def test_the_log_may_round_the_rate_but_not_contradict_it(write):
    path = write([channel("a", step=9.0 / 51200.0)])
    with open_recording(path, sample_rate=5688.9) as recording:
        assert recording.sample_rate == pytest.approx(51200.0 / 9.0, rel=1e-15)
        assert recording.notes == ()
    refused(
        path, "the file says 5688.88889 samples per second, the log 5690", sample_rate=5690.0
    )
    with pytest.raises(ValueError, match="sample_rate must be above 0 Hz"):
        open_recording(path, sample_rate=0.0)


def test_channels_of_unequal_length_give_the_rows_that_all_have_marked_incomplete(write):
    path = write([channel("a"), (*channel("b"), 5)])
    with open_recording(path) as recording:
        assert (recording.n_samples, recording.expected_samples) == (5, 6)
        assert any("'a' holds 6 samples, 'b' 5" in note for note in recording.notes)
    with open_recording(path, uses=[ChannelUse("b", "control")]) as recording:
        assert recording.n_samples == 5


@pytest.mark.parametrize(
    ("unit", "use", "expected", "si"),
    [
        ("g", {"role": "control"}, STANDARD_GRAVITY, "m/s^2"),
        ("m/s^2", {"role": "control"}, 1.0, "m/s^2"),
        ("mm/s^2", {"role": "response"}, 1e-3, "m/s^2"),
        ("kN", {"role": "force"}, 1e3, "N"),
        ("mm", {"role": "displacement"}, 1e-3, "m"),
        ("mm/s", {"role": "velocity"}, 1e-3, "m/s"),
        (None, {"role": "control", "unit": "g"}, STANDARD_GRAVITY, "m/s^2"),
        ("V", {"role": "control", "unit": "g", "override": True}, STANDARD_GRAVITY, "m/s^2"),
        ("m/s2", {"role": "control", "unit": "m/s^2"}, 1.0, "m/s^2"),
        ("g_n", {"role": "control", "unit": "g"}, STANDARD_GRAVITY, "m/s^2"),
        ("EU", {"role": "control", "unit": "g"}, STANDARD_GRAVITY, "m/s^2"),
        ("Acceleration", {"role": "control", "unit": "mg"}, STANDARD_GRAVITY / 1e3, "m/s^2"),
        (
            "g",
            {"role": "control", "unit": "V", "sensitivity": "100 mV/g", "override": True},
            10 * STANDARD_GRAVITY,
            "m/s^2",
        ),
        (
            "Volts",
            {"role": "control", "sensitivity": "100 mV/g"},
            10 * STANDARD_GRAVITY,
            "m/s^2",
        ),
        ("mV", {"role": "control", "sensitivity": "100 mV/g"}, STANDARD_GRAVITY / 100, "m/s^2"),
        (None, {"role": "control", "sensitivity": "10.2 mV/(m/s^2)"}, 1 / 0.0102, "m/s^2"),
        ("V", {"role": "force", "sensitivity": "11.2 mV/N"}, 1 / 0.0112, "N"),
        ("V", {"role": "displacement", "sensitivity": "8 V/mm"}, 1e-3 / 8, "m"),
        ("V", {"role": "velocity", "sensitivity": "4 V/(m/s)"}, 0.25, "m/s"),
    ],
)
def test_units_become_si(write, unit, use, expected, si):
    path = write([channel("a", unit=unit)])
    with open_recording(path, uses=[ChannelUse("a", **use)]) as recording:
        assert recording.channels[0].unit == si
        assert_allclose(recording.samples()[0], expected * np.arange(1.0, 7.0), rtol=1e-12)


@pytest.mark.parametrize(
    ("unit", "use", "match"),
    [
        (None, {"role": "control"}, "has no unit .* channels: {a: {role: control, unit: g}}"),
        ("Volts", {"role": "response"}, "{role: response, sensitivity: 100 mV/g}"),
        ("V", {"role": "force"}, "{role: force, sensitivity: 10 mV/N}"),
        (
            "mm",
            {"role": "control"},
            "give it role: displacement or role: ignore; or, where the file is wrong, .*"
            "{role: control, unit: g, override: true}}",
        ),
        ("g", {"role": "force"}, "give it role: control or role: response or role: ignore;"),
        ("EU", {"role": "control"}, "is in 'EU' but is used as control, which takes an acc"),
        (None, {"role": "control", "unit": "mm"}, "role control takes an acceleration"),
        (None, {"role": "control", "unit": "furlong"}, "role control takes an acceleration"),
        (None, {"role": "control", "unit": "V"}, "for volts add sensitivity: 100 mV/g"),
        (
            None,
            {"role": "control", "unit": "g", "sensitivity": "100 mV/g"},
            "the log gives its scale twice, unit: g and sensitivity: 100 mV/g",
        ),
        ("V", {"role": "control", "sensitivity": "100 mV/N"}, "Write it as 100 mV/g"),
        ("V", {"role": "control", "sensitivity": "0 mV/g"}, "a sensitivity of 0"),
    ],
)
def test_what_is_missing_or_contradicts_tells_the_entry_of_the_log(write, unit, use, match):
    refused(write([channel("a", unit=unit)]), match, uses=[ChannelUse("a", **use)])


@pytest.mark.parametrize(
    ("unit", "use", "instead"),
    [
        ("g", {"unit": "V", "sensitivity": "100 mV/g"}, "take unit and sensitivity out"),
        ("g", {"sensitivity": "100 mV/g"}, "take sensitivity out"),
        ("g", {"unit": "m/s^2"}, "take unit out"),
        ("mV", {"unit": "V", "sensitivity": "100 mV/g"}, "take unit out"),
        ("Volts", {"unit": "g"}, "{a: {role: response, sensitivity: 100 mV/g}}"),
        ("Voltage", {"unit": "g"}, "give it role: ignore"),
        ("Pa", {"unit": "mg"}, "give it role: pressure or role: ignore"),
        ("s", {"unit": "g"}, "give it role: ignore"),
        ("Deg C", {"unit": "g"}, "give it role: ignore"),
        ("N", {"unit": "g"}, "give it role: force or role: ignore"),
    ],
)
def test_a_log_that_contradicts_the_file_is_refused_until_it_overrides(
    write, unit, use, instead
):
    path = write([channel("a", unit=unit)])
    said = ", ".join(f"{key}: {value}" for key, value in use.items())
    message = refused(path, "in the file", uses=[ChannelUse("a", "response", **use)])
    assert f"is in '{unit}' in the file but {said} in the log" in message
    assert instead in message
    line = f"channels: {{a: {{role: response, {said}, override: true}}}}"
    assert line in message
    uses = [ChannelUse("a", "response", **use, override=True)]
    with open_recording(path, uses=uses) as recording:
        assert f"the file says '{unit}', the log says {said}" in recording.notes[0]


def test_without_a_log_an_unknown_unit_is_only_shown(write):
    with open_recording(write([channel("a", unit="Deg C")])) as recording:
        assert recording.channels[0].unit == UNKNOWN
        assert recording.channels[0].source_unit == "Deg C"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("g", ("m/s^2", STANDARD_GRAVITY)),
        (" g's ", ("m/s^2", STANDARD_GRAVITY)),
        ("m/s²", ("m/s^2", 1.0)),
        ("m/s2", ("m/s^2", 1.0)),
        ("in", ("m", 0.0254)),
        ("µm", ("m", 1e-6)),
        ("%", ("1", 0.01)),
        ("Hz", None),
        ("", None),
        ("EU", None),
        ("lb", None),
        ("__import__('os')", None),
        ("g" * 5000, None),
    ],
)
def test_spellings_of_units(text, expected):
    found = parse_unit(text)
    assert (found is None) == (expected is None)
    if expected is not None:
        assert found[0] == expected[0]
        assert found[1] == pytest.approx(expected[1], rel=1e-15)


def test_files_that_are_none(tmp_path):
    (tmp_path / "run.tdms").write_bytes(b"")
    (tmp_path / "notes.docx").write_bytes(b"x")
    refused(tmp_path / "rum.tdms", "no file .*; did you mean 'run.tdms'")
    refused(tmp_path / "nowhere" / "run.tdms", "no such folder either")
    refused(tmp_path, "is a folder")
    refused(tmp_path / "notes.docx", "no reader for .docx")
