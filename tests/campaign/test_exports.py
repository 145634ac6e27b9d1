"""What other programs read from the exports, by value: pyuff, scipy, pandas against scipy."""

import numpy as np
import pandas as pd
import pytest
import pyuff
import scipy.io
import scipy.signal
from numpy.testing import assert_allclose
from tests.in_process import run

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import write_tdms
from shakerproc.recordings.response_functions import read_functions
from shakerproc.runs.result import shown_unit

pytestmark = pytest.mark.filterwarnings(  # pyuff leaves its files open
    "ignore::pytest.PytestUnraisableExceptionWarning"
)

G = 9.80665
RATE, SEGMENT = 1024.0, 256
NAMES = ("table", "tip", "laser", "cell")
UNITS = ("m/s^2", "m/s^2", "m", "N")
LENGTH = shown_unit("m")[0]
SHOWN = {
    "table": ("g", 1.0 / G),
    "tip": ("g", 1.0 / G),
    "laser": (LENGTH, {"m": 1.0, "mm": 1e3}[LENGTH]),
    "cell": ("N", 1.0),
}
LOG = """\
testlog: 1
recordings: .
channels:
  table: {role: control, direction: z}
  tip: {role: response, direction: -x}
  laser: {role: displacement, direction: [1, 1, 0]}
  cell: {role: force, direction: y}
processing:
  crop: none
  welch: {segment: 256}
  octaves: {}
  response_functions:
    - {input: cell, output: laser}
    - {input: tip, output: cell}
    - {input: controls, output: tip}
tests:
  - {id: 1, recording: run.tdms, excitation: random, level: 1 g rms, from: 20 Hz, to: 400 Hz}
"""
PAIRS = [("cell", "laser"), ("tip", "cell"), ("table", "tip")]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Samples in SI, and the folder of the results in every format."""
    folder = tmp_path_factory.mktemp("exports")
    rng = np.random.default_rng(4)
    table = 5.0 * rng.standard_normal(8192)
    b, a = scipy.signal.iirpeak(150.0, 10.0, fs=RATE)
    tip = table + 3.0 * scipy.signal.lfilter(b, a, table) + 0.1 * rng.standard_normal(8192)
    laser = 1e-5 * scipy.signal.lfilter(*scipy.signal.butter(2, 100.0, fs=RATE), table)
    cell = 0.4 * tip + 0.02 * rng.standard_normal(8192)
    rows = np.array([table, tip, laser, cell])
    channels = [Channel(n, u, n, u) for n, u in zip(NAMES, UNITS, strict=True)]
    write_tdms(folder / "run.tdms", recording_of_arrays("run", channels, rows, RATE))
    (folder / "log.yaml").write_text(LOG)
    out = ("--no-figures", "--export", "parquet,mat,uff,xlsx", "--out", folder / "out")
    assert run("process", folder / "run.tdms", "--log", folder / "log.yaml", *out) == 0
    return dict(zip(NAMES, rows, strict=True)), folder / "out"


def spectra(samples, x, y):
    """Frequency, H1 of y over x in shown units, and their coherence, by scipy."""
    how = {"fs": RATE, "window": np.hamming(SEGMENT), "nperseg": SEGMENT, "detrend": False}
    f, cross = scipy.signal.csd(samples[x], samples[y], **how)
    own = [scipy.signal.welch(samples[name], **how)[1] for name in (x, y)]
    factor = SHOWN[y][1] / SHOWN[x][1]
    return f, cross / own[0] * factor, np.abs(cross) ** 2 / (own[0] * own[1])


def density(samples, x):
    how = {"fs": RATE, "window": np.hamming(SEGMENT), "nperseg": SEGMENT, "detrend": False}
    return scipy.signal.welch(samples[x], **how)[1] * SHOWN[x][1] ** 2


def of_uff(folder):
    sets = pyuff.UFF(str(folder / "spectra.uff")).read_sets()
    return {one["id1"].strip(): one for one in sets}


@pytest.mark.parametrize(("x", "y"), PAIRS)
def test_every_format_holds_the_asked_functions_by_value(made, x, y):
    samples, folder = made
    f, h1, coherence = spectra(samples, x, y)
    asked = "controls" if x == "table" else x
    unit = "1" if (x, y) == ("table", "tip") else f"{SHOWN[y][0]}/{SHOWN[x][0]}"

    found = scipy.io.loadmat(folder / "spectra.mat", simplify_cells=True)
    functions = found["response_functions"]
    at = list(functions["names"]).index(f"{y} / {asked}")
    assert_allclose(found["frequency_hz"], f, rtol=1e-12)
    assert_allclose(functions["h1"][at], h1, rtol=1e-6)
    assert_allclose(functions["coherence"][at], coherence, rtol=1e-6)
    assert (functions["inputs"][at], functions["outputs"][at]) == (x, y)
    assert functions["units"][at] == unit

    one = of_uff(folder)[f"H1 {y} / {asked}"]
    assert_allclose(one["x"], f, rtol=1e-5)
    assert_allclose(one["data"], h1, rtol=1e-6)
    assert (one["rsp_node"], one["ref_node"]) == (NAMES.index(y) + 1, NAMES.index(x) + 1)
    directions = {"table": 3, "tip": -1, "laser": 0, "cell": 2}
    assert (one["rsp_dir"], one["ref_dir"]) == (directions[y], directions[x])
    kinds = {"table": 12, "tip": 12, "laser": 8, "cell": 13}
    assert (one["ordinate_spec_data_type"], one["orddenom_spec_data_type"]) == (
        kinds[y],
        kinds[x],
    )
    units = (one["ordinate_axis_units_lab"].strip(), one["orddenom_axis_units_lab"].strip())
    assert units == (SHOWN[y][0], SHOWN[x][0])
    assert (one["rsp_ent_name"].strip(), one["ref_ent_name"].strip()) == (y, x)

    for table in (
        pd.read_parquet(folder / "response_functions_curves.parquet"),
        pd.read_csv(folder / "response_functions_curves.csv"),
    ):
        name = f"{y}_over_{asked}"
        ending = "" if unit == "1" else "_" + unit.replace("/", "_per_")
        assert_allclose(table[f"h1_{name}_magnitude{ending}"], np.abs(h1), rtol=1e-6)
        turn = np.exp(1j * np.deg2rad(table[f"h1_{name}_phase_deg"].to_numpy()))
        assert_allclose(turn, h1 / np.abs(h1), atol=1e-6)


@pytest.mark.parametrize("y", ["tip", "laser", "cell"])
def test_every_format_holds_the_functions_against_the_controls_by_value(made, y):
    samples, folder = made
    _, h1, coherence = spectra(samples, "table", y)
    unit = {"tip": "1", "laser": f"{LENGTH}/g", "cell": "N/g"}[y]
    found = scipy.io.loadmat(folder / "spectra.mat", simplify_cells=True)
    at = list(found["channels"][found["responses"] - 1]).index(y)
    assert_allclose(found["h1"][at], h1, rtol=1e-6)
    assert_allclose(found["coherence"][at], coherence, rtol=1e-6)
    assert found["h1_units"][at] == unit
    assert_allclose(of_uff(folder)[f"H1 {y}"]["data"], h1, rtol=1e-6)
    assert_allclose(of_uff(folder)[f"coherence {y}"]["data"], coherence, rtol=1e-6)
    ending = "" if unit == "1" else "_" + unit.replace("/", "_per_")
    for table in (
        pd.read_parquet(folder / "spectra.parquet"),
        pd.read_csv(folder / "spectra.csv"),
    ):
        assert_allclose(table[f"h1_{y}_magnitude{ending}"], np.abs(h1), rtol=1e-6)


@pytest.mark.parametrize("x", NAMES)
def test_every_format_holds_the_densities_by_value(made, x):
    samples, folder = made
    expected = density(samples, x)
    found = scipy.io.loadmat(folder / "spectra.mat", simplify_cells=True)
    at = NAMES.index(x)
    order = list(found["channels"]).index(x)
    assert_allclose(found["psd"][order], expected, rtol=1e-6)
    assert found["psd_units"][order] == f"({SHOWN[x][0]})^2/Hz"
    one = of_uff(folder)[f"PSD {x}"]
    assert_allclose(one["data"], expected, rtol=1e-6)
    assert (one["rsp_node"], one["ordinate_axis_units_lab"].strip()) == (
        at + 1,
        f"{SHOWN[x][0]}^2/Hz",
    )


@pytest.mark.parametrize("name", ["spectra", "response_functions_curves", "octaves_curves"])
def test_every_table_of_parquet_is_the_csv_with_numbers(made, name):
    """pandas reads both; a column of numbers is one in either."""
    _, folder = made
    left = pd.read_parquet(folder / f"{name}.parquet")
    right = pd.read_csv(folder / f"{name}.csv")
    assert list(left.columns) == list(right.columns)
    pd.testing.assert_frame_equal(left, right, check_dtype=False, rtol=1e-12)
    kinds = {name: (left[name].dtype.kind, right[name].dtype.kind) for name in left}
    assert all(a == b for a, b in kinds.values()), kinds


def test_a_spreadsheet_holds_the_columns_of_spectra_csv(made):
    """pandas reads both; the sheets are those of the spectra and of each analysis."""
    _, out = made
    sheets = pd.read_excel(out / "spectra.xlsx", sheet_name=None)
    assert {"spectra", "octaves", "response_functions"} <= set(sheets)
    csv = pd.read_csv(out / "spectra.csv")
    pd.testing.assert_frame_equal(sheets["spectra"], csv, check_dtype=False, rtol=1e-12)


def test_modal_reads_the_functions_that_batch_exports(made):
    """H1 of the laser over the table, as scipy has it, in SI."""
    samples, out = made
    found = read_functions(out / "spectra.uff")
    _, h1, coherence = spectra(samples, "table", "laser")
    row = found.responses.index("laser")
    si = h1 / SHOWN["laser"][1] * SHOWN["table"][1]
    assert_allclose(found.values[row, 0], si, rtol=1e-6)  # noqa: PD011
    assert (found.inputs, found.input_units) == (("table",), ("m/s^2",))
    assert found.response_units[row] == "m"
    assert found.coherence is None or np.allclose(found.coherence[row, 0], coherence)
