"""Without the extras `xlsx` and `cluster`, what needs them is one line with the command that
installs them; nothing is written. The extra `parquet` is tried in `test_without_parquet`."""

import sys

import openpyxl
import pytest
from tests.small_campaign import write_campaign
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import ShakerprocError

FAR = ("--recordings", "memory://far", "--no-figures")
CASES = {
    "a recording in XLSX": ("openpyxl", "xlsx", ["inspect", "run.xlsx"]),
    "a calibration sheet in XLSX": (
        "openpyxl",
        "xlsx",
        ["batch", "sheet.yaml", "--no-figures"],
    ),
    "a cluster": (
        "distributed",
        "cluster",
        ["batch", "testlog.yaml", "--scheduler", "tcp://h:1"],
    ),
    "recordings behind a URL": ("fsspec", "cluster", ["batch", "testlog.yaml", *FAR]),
}


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """A folder with a campaign, a workbook, and a log that needs one."""
    write_campaign(tmp_path)
    book = openpyxl.Workbook()
    book.active.append(["time [s]", "a [g]"])
    book.save(tmp_path / "run.xlsx")
    book.save(tmp_path / "sensors.xlsx")
    text = (tmp_path / "testlog.yaml").read_text()
    (tmp_path / "sheet.yaml").write_text(f"calibration: sensors.xlsx\n{text}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("package", "extra", "words"), CASES.values(), ids=CASES)
def test_what_needs_an_extra_says_in_one_line_how_to_install_it(
    campaign, monkeypatch, package, extra, words
):
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    done = CliRunner().invoke(build_app(), words)
    assert done.exit_code != 0
    assert isinstance(done.exception, ShakerprocError | SystemExit)
    told = f"{done.output} {done.exception}"
    assert f"shakerproc[{extra}]" in told
    assert "pip install" in told
