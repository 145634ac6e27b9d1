"""Sensitivities and dates from a calibration sheet, as CSV and as XLSX."""

import zipfile
from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import completed

from shakerproc.comparison.measured import gain_spread
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import LogError, ShakerprocError
from shakerproc.recordings import write_tdms
from shakerproc.runs import open_test, process_recording
from shakerproc.testlog import read_testlog
from shakerproc.testlog.sheets import read_calibrations

HEADER = ["Serial number", "Sensitivity", "Unit", "Calibrated", "Valid until"]
ROWS = [
    ["4711", 10.2, "mV/g", date(2017, 5, 1), date(2018, 5, 1)],
    ["4712", 98.1, "mV/g", date(2018, 1, 31), date(2019, 1, 31)],
    ["F1", 2.0, "mV/N", date(2018, 1, 31), None],
]
LOG = """\
testlog: 1
recordings: r
calibration: {sheet}
channels:
  base: {{role: control, sensor: 4711}}
  tip: {{role: response, sensor: "4712"}}
  foot: {{role: response, sensor: 4712}}
processing: {{crop: none, welch: {{segment: 256}}}}
tests:
  - {{id: 1, recording: a.tdms}}
"""


def sheet_csv(path, rows=ROWS):
    lines = [HEADER, *([("" if c is None else str(c)) for c in row] for row in rows)]
    path.write_text("\n".join(",".join(line) for line in lines), encoding="utf-8")


def sheet_semicolons(path):
    sheet_csv(path)
    path.write_text("\n" + path.read_text(encoding="utf-8").replace(",", ";"), encoding="utf-8")


def sheet_xlsx(path, rows=ROWS):
    openpyxl = pytest.importorskip("openpyxl", reason="the extra xlsx is not installed")
    book = openpyxl.Workbook()
    for row in [HEADER, *rows]:
        book.active.append(row)
    book.save(path)


@pytest.fixture
def campaign(tmp_path):
    """Volts, volts, and a channel that the recorder has scaled itself."""
    samples = np.random.default_rng(1).standard_normal((3, 4000))
    units = {"base": "V", "tip": "V", "foot": "m/s^2"}
    channels = [Channel(name, unit, name, unit) for name, unit in units.items()]
    recording = recording_of_arrays("a", channels, samples, 1000.0)
    (tmp_path / "r").mkdir()
    start = datetime(2018, 6, 5, 8, tzinfo=UTC)
    write_tdms(tmp_path / "r" / "a.tdms", replace(recording, start_time=start))

    def opened(sheet, change=("", "")):
        text = LOG.format(sheet=sheet).replace(*change)
        (tmp_path / "testlog.yaml").write_text(text, encoding="utf-8")
        log = read_testlog(tmp_path / "testlog.yaml")
        return open_test(log, log.tests[0]), log.tests[0]

    return tmp_path, samples, opened


@pytest.mark.parametrize(
    ("name", "write"),
    [("s.csv", sheet_csv), ("t.csv", sheet_semicolons), ("s.xlsx", sheet_xlsx)],
)
def test_volts_are_scaled_by_the_sheet_and_what_has_expired_is_flagged(campaign, name, write):
    folder, volts, opened = campaign
    write(folder / name)
    recording, test = opened(name)
    with recording:
        factors = np.array([9.80665 / 10.2e-3, 9.80665 / 98.1e-3, 1.0])
        assert_allclose(recording.samples(), volts * factors[:, np.newaxis], rtol=1e-9)
        assert (
            "Channel tip: sensor 4712, 98.1 mV/g, calibrated 2018-01-31, "
            "valid until 2019-01-31."
        ) in recording.notes
        flags = [f for f in process_recording(recording, test).flags if f.kind == "calibration"]
    assert [(flag.channel, "expired on 2018-06-05" in flag.message) for flag in flags] == [
        ("base", True)
    ]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (("4711", "F1"), r"testlog.yaml:5:\d+: .*sensor \"F1\" has 2.0 mV/N .* role control"),
        (("4711", "471"), r"testlog.yaml:5:\d+: .*expected a sensor of the calibration sheet"),
        (("s.csv", "t.csv"), r"t\.csv: no such file"),
    ],
)
def test_a_sensor_that_does_not_fit_is_one_line(campaign, change, match):
    folder, _, opened = campaign
    sheet_csv(folder / "s.csv")
    with pytest.raises(ShakerprocError, match=match) as caught:
        opened("s.csv", change)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("row", "match"),
    [
        (["4711", "10", "g", "2017-05-01", ""], r"s\.csv:2: .*volts per unit.*\"10 g\""),
        (["4711", "10", "mV/g", "soon", ""], r"s\.csv:2: expected a date .*\"soon\""),
        (
            ["4711", "10", "mV/g", "2027-05-01", "2026-05-01"],
            r'"4711": expected valid until after calibrated, got 2026-05-01 and 2027-05-01',
        ),
        (["", "10", "mV/g", "", ""], r"s\.csv:2: no serial number"),
    ],
)
def test_a_row_that_cannot_be_used_is_named(campaign, row, match):
    folder, _, opened = campaign
    sheet_csv(folder / "s.csv", [row])
    with pytest.raises(ShakerprocError, match=match):
        opened("s.csv")


INSTRUMENTS = """\
report:
  instruments:
    - {instrument: recorder, serial: 77, valid_until: 2018-06-04}
    - {instrument: amplifier, valid_until: 2018-06-05}
    - {instrument: thermometer}
channels:"""
TOLD = "recorder, serial number 77, valid until 2018-06-04: it had expired on 2018-06-05"


def test_an_instrument_that_had_expired_is_flagged_in_every_place(campaign, tmp_path):
    folder, _, opened = campaign
    sheet_csv(folder / "s.csv")
    with opened("s.csv", ("channels:", INSTRUMENTS))[0]:
        pass  # the log is written
    out = tmp_path / "out"
    log = folder / "testlog.yaml"
    done = completed("batch", log, "--out", out, "--no-figures", merged=True)
    assert done.returncode == 0, done.stdout
    assert sum(TOLD in line for line in done.stdout.splitlines()) == 1
    assert "amplifier" not in done.stdout
    page = (out / "report.html").read_text(encoding="utf-8")
    table = page[page.index("<caption>Instruments") : page.index("</table>")]
    marks = [row for row in table.split("<tr>") if "expired when used" in row]
    assert len(marks) == 2
    assert "recorder" in marks[0]
    assert "sensor, 10.2 mV/g" in marks[1]
    assert TOLD in page[page.index('id="attention"') :]
    done = completed("check", out, "--against", out, merged=True)
    assert done.returncode == 0, done.stdout
    assert "note: test 1: a calibration had expired on the day of the test" in done.stdout


@pytest.mark.parametrize("more", [{"xl/media/image1.png": 40_000_000}, {}])
def test_a_sheet_that_unpacks_to_more_than_any_is_refused_before_it_is_read(tmp_path, more):
    """Zeros: 40 MB of them are 40 kB packed; or a row at the end of the sheet."""
    openpyxl = pytest.importorskip("openpyxl", reason="the extra xlsx is not installed")
    path = tmp_path / "s.xlsx"
    sheet_xlsx(path)
    for name, size in more.items():
        with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(name, bytes(size))
    if not more:
        book = openpyxl.load_workbook(path)
        book.active.cell(1_000_000, 1, "x")
        book.save(path)
    told = "40 MB once unpacked" if more else "at most 100000 rows"
    with pytest.raises(LogError, match=told):
        read_calibrations(path)


def test_half_of_the_expanded_uncertainty_is_that_of_the_channel_in_the_diagnosis(campaign):
    folder, _, opened = campaign
    lines = [
        "Serial number,Sensitivity [mV/g],Uncertainty (k=2) [%]",
        "4711,10.2,1.5",
        "4712,98,",
    ]
    (folder / "s.csv").write_text("\n".join(lines), encoding="utf-8")
    recording, _ = opened("s.csv")
    with recording:
        assert [channel.uncertainty for channel in recording.channels] == [0.015, None, None]
        assert "Channel base: sensor 4711, 10.2 mV/g +- 1.5 %." in recording.notes
        each = [gain_spread(recording, row) for row in range(3)]
        assert each == pytest.approx([0.0075, 0.01, 0.01])


@pytest.mark.parametrize("cell", ["0.015", "30", "small"])
def test_an_uncertainty_that_is_no_per_cent_is_named(campaign, cell):
    folder, _, opened = campaign
    lines = ["Serial number,Sensitivity [mV/g],Uncertainty [%]", f"4711,10.2,{cell}"]
    (folder / "s.csv").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(LogError, match=r"s\.csv:2: .* uncertainty \(k = 2\) of 0.1 to 20 %"):
        opened("s.csv")


def test_an_uncertainty_in_another_unit_is_read_as_before(campaign):
    folder, _, opened = campaign
    lines = [
        "Serial number,Sensitivity [mV/g],Uncertainty [dB]",
        "4711,10.2,0.2",
        "4712,98,0.2",
    ]
    (folder / "s.csv").write_text("\n".join(lines), encoding="utf-8")
    recording, _ = opened("s.csv")
    with recording:
        assert recording.channels[0].uncertainty is None
