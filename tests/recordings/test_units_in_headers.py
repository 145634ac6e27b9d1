"""A letter in a header is a unit only where it is one; what may be one is told, with what."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording

VALUES = np.random.default_rng(10).standard_normal((3, 40)).round(4)


@pytest.fixture
def write(tmp_path):
    def write(*headers, time="time"):
        rows = "".join(
            f"{i / 1000:.3f}," + ",".join(f"{v:.4f}" for v in row[: len(headers)]) + "\n"
            for i, row in enumerate(VALUES.T)
        )
        path = tmp_path / "run.csv"
        path.write_text(",".join([time, *headers]) + "\n" + rows)
        return path

    return write


@pytest.mark.parametrize(
    ("headers", "told"),
    [
        (
            ("acc_N", "acc_E", "acc_Z"),
            "'N' at the end of its name may be a unit or a direction",
        ),
        (
            ("table", "left_m", "right_m"),
            "'m' at the end of its name may be a unit or a position",
        ),
        (("table_V", "coupon_V", "coupon_H"), "may be a unit or a direction (vertical)"),
        (("X (40g)", "Y (40g)", "Z (40g)"), "'40g' in its header is taken for a range"),
        (("a (\u00b150 g)", "b [100 mV/g]", "c (2g)"), "is taken for a range"),
        (("Table (Z)", "Coupon (Z)", "Rim (X)"), "'Z' in its header is taken for a direction"),
        (("acc (N)", "acc (E)", "acc (Z)"), "'N' in its header may be a unit or a direction"),
        (("a (left)", "a (right)", "a (+X)"), "'left' in its header is taken for a direction"),
        (("a [G]", "b [G]", "c [G]"), "'G' may be g"),
    ],
)
def test_a_direction_a_position_or_a_range_is_no_unit_and_the_log_settles_it(
    write, headers, told
):
    path = write(*headers)
    with open_recording(path) as recording:
        assert all(channel.unit == "?" for channel in recording.channels)
        assert any(told in note for note in recording.notes)
        names = [channel.name for channel in recording.channels]
    with pytest.raises(RecordingError, match="takes an acceleration"):
        open_recording(path, uses=[ChannelUse(names[0], "response")])
    uses = [ChannelUse(name, "response", unit="g") for name in names]
    with open_recording(path, uses=uses) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)
        assert not any("override" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("time", "headers", "units"),
    [
        ("time_s", ("acc_g", "force_n", "weg_m"), ["m/s^2", "N", "m"]),
        ("time", ("Kraft_N", "disp_m", "drive_v"), ["N", "m", "V"]),
        ("t_s", ("x_m", "b_n", "c_g"), ["m", "N", "m/s^2"]),
        ("time", ("top_mm", "load_kN", "c_m_per_s2"), ["m", "N", "m/s^2"]),
        ("time [s]", ("a [g]", "b (N)", "c (V)"), ["m/s^2", "N", "V"]),
    ],
)
def test_letters_are_units_where_the_name_or_all_headers_say_so(write, time, headers, units):
    with open_recording(write(*headers, time=time)) as recording:
        assert [channel.unit for channel in recording.channels] == units


def test_a_channel_answers_to_its_name_without_the_letter_too(write):
    uses = [ChannelUse("left", "response", unit="g")]
    with open_recording(write("table", "left_m", "right_m"), uses=uses) as recording:
        assert_allclose(recording.samples()[0], VALUES[1] * STANDARD_GRAVITY, rtol=1e-12)


def test_a_unit_of_the_log_that_contradicts_one_in_capitals_is_refused(write):
    uses = [ChannelUse("a", "response", unit="m/s^2")]
    with pytest.raises(RecordingError, match="is in 'G' in the file but unit: m/s"):
        open_recording(write("a [G]"), uses=uses)
