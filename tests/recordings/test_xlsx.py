"""XLSX of samples, as openpyxl writes it; oracle: the numbers that were written."""

from datetime import datetime, timedelta

import numpy as np
import openpyxl
import pytest
from numpy.testing import assert_array_equal

from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, open_recording

VALUES = np.random.default_rng(46).standard_normal((2, 40)).round(12)


@pytest.fixture
def save(tmp_path):
    def save(**sheets):
        book = openpyxl.Workbook()
        book.remove(book.active)
        for name, rows in sheets.items():
            sheet = book.create_sheet(name)
            for row in rows:
                sheet.append(row)
        book.save(tmp_path / "run.xlsx")
        return tmp_path / "run.xlsx"

    return save


def rows(step=0.001, head=("time [s]", "a [m/s^2]", "b, left [N]")):
    return [head, *([step * i, *map(float, row)] for i, row in enumerate(VALUES.T))]


def test_a_sheet_is_read_to_the_last_digit_and_the_others_are_told(save):
    with open_recording(save(About=[["operator", "J. Doe"]], Data=rows())) as recording:
        assert recording.sample_rate == 1000.0
        assert [channel.name for channel in recording.channels] == ["a", "b, left"]
        assert_array_equal(recording.samples(), VALUES)
        assert any("'About' holds no table" in note for note in recording.notes)


def test_sheets_with_tables_are_groups(save):
    path = save(Fast=rows(), Slow=rows(0.01)[:30])
    with pytest.raises(RecordingError, match=r"run.xlsx: 2 groups hold data: 'Fast'"):
        open_recording(path)
    with open_recording(path, part=FilePart("Slow")) as recording:
        assert recording.sample_rate == 100.0
        assert_array_equal(recording.samples(), VALUES[:, :29])


def test_dates_give_rate_and_start(save):
    begun = datetime(2026, 11, 27, 9, 30)  # noqa: DTZ001  a workbook knows no zones
    table = rows()
    table[1:] = [
        [begun + timedelta(milliseconds=10 * i), *row[1:]] for i, row in enumerate(table[1:])
    ]
    with open_recording(save(Data=table)) as recording:
        assert recording.sample_rate == 100.0
        assert recording.start_time.replace(tzinfo=None) == begun
        assert_array_equal(recording.samples(), VALUES)


def test_what_cannot_be_used_is_one_line(save, tmp_path):
    broken = rows()
    broken[7] = [0.006, "#REF!", 1.0]
    with pytest.raises(RecordingError, match=r"run.xlsx: line 8: '#REF!' in column 2"):
        open_recording(save(Data=broken))
    path = tmp_path / "run.xlsx"
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(RecordingError, match=r"run.xlsx: opening the workbook failed"):
        open_recording(path)
    path.write_bytes(b"\xd0\xcf\x11\xe0" + bytes(600))
    with pytest.raises(RecordingError, match=r"run.xlsx: is encrypted, or a workbook"):
        open_recording(path)
