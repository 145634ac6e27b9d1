"""Sound pressure, strain and voltage beside accelerations, each in its own unit."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording
from shakerproc.report.runs.drawing import page_figures
from shakerproc.runs import open_test, process_recording
from shakerproc.runs.summarising import summary_of
from shakerproc.runs.tables import spectra_columns
from shakerproc.testlog import Processing, Test, read_testlog

GRAVITY, RATE = 9.80665, 2000.0
USES = (
    ChannelUse("table", "control"),
    ChannelUse("mic", "pressure"),
    ChannelUse("gauge", "strain"),
    ChannelUse("out", "voltage"),
)


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A table in g, and what it makes: 3 Pa/g in mPa, 20 µm/m/g in µm/m, 0.1 V/g in mV."""
    table = np.random.default_rng(1).standard_normal(8_000)
    columns = np.array([
        np.arange(table.size) / RATE,
        table,
        3e3 * table,
        20 * table,
        1e2 * table,
    ])
    path = tmp_path_factory.mktemp("units") / "run.csv"
    header = "time [s],table [g],mic [mPa],gauge [µm/m],out [mV]"
    np.savetxt(path, columns.T, "%.9g", ",", header=header, comments="", encoding="utf-8")
    test = Test(
        1, excitation="random", from_hz=10.0, to_hz=200.0, channels=USES,
        processing=Processing(crop=None),
    )  # fmt: skip
    with open_recording(path, uses=USES) as recording:
        return process_recording(recording, test)


def test_densities_and_response_functions_say_their_units(result):
    columns = spectra_columns(result)
    seen = columns["psd_table_g2_per_hz"]
    assert_allclose(columns["psd_mic_Pa2_per_hz"], 9.0 * seen, rtol=1e-6)
    assert_allclose(columns["psd_gauge_um2_per_m2_per_hz"], 400.0 * seen, rtol=1e-6)
    assert_allclose(columns["h1_mic_magnitude_Pa_per_g"], 3.0, rtol=1e-6)
    assert_allclose(columns["h1_gauge_magnitude_um_per_m_per_g"], 20.0, rtol=1e-6)
    assert_allclose(columns["h1_out_magnitude_V_per_g"], 0.1, rtol=1e-6)


def test_the_page_has_a_figure_for_each_unit(result):
    summary = summary_of(result, "1", {}, "run.csv", "")
    assert [c.unit for c in summary.channels] == ["g", "Pa", "µm/m", "V"]
    drawn = [d.kind for d in page_figures(summary)]
    assert drawn.count("psd") == 4
    assert drawn.count("gain") == 3
    text = "".join(str(d.drawing) for d in page_figures(summary))
    assert all(unit in text for unit in ("Pa²/Hz", "(µm/m)²/Hz", "Pa/g", "µm/m/g"))


def test_a_pressure_is_no_acceleration(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(
        "time [s],mic [Pa]\n" + "".join(f"{i / RATE},{i % 3}\n" for i in range(100))
    )
    with pytest.raises(RecordingError, match="role: pressure"):
        open_recording(path, uses=(ChannelUse("mic", "response"),))


@pytest.mark.parametrize(
    ("entry", "factor"),
    [
        ("role: pressure, sensitivity: 50 mV/Pa", 20.0),
        ("role: strain, sensitivity: 2 mV/(um/m)", 500e-6),
        ("role: velocity, sensitivity: 100 mV/(mm/s)", 0.01),
        ("role: pressure, unit: kPa, override: true", 1000.0),
        ("role: strain, unit: '%', override: true", 0.01),
    ],
)
def test_a_log_says_unit_or_sensitivity_of_any_quantity(tmp_path, entry, factor):
    volts = np.random.default_rng(2).standard_normal(100)
    rows = "".join(f"{i / RATE},{v!r}\n" for i, v in enumerate(volts.tolist()))
    (tmp_path / "run.csv").write_text("time [s],sensor [V]\n" + rows)
    log = tmp_path / "log.yaml"
    log.write_text(
        f"testlog: 1\nrecordings: .\nchannels: {{sensor: {{{entry}}}}}\n"
        "tests: [{id: 1, recording: run.csv}]\n"
    )
    read = read_testlog(log)
    with open_test(read, read.tests[0]) as recording:
        assert_allclose(recording.samples()[0], factor * volts, rtol=1e-12)
