"""``shakerproc compare`` on real files."""

import csv
import json

import pytest
from tests.comparison.small_campaigns import ONE_MASS, campaign, drive, off, written
from typer.testing import CliRunner

from shakerproc.cli import build_app


@pytest.mark.slow
def test_the_command_says_where_the_model_fails(tmp_path):
    drives = (drive("sine sweep", 2.0), drive("sine sweep", 6.0, number=2))
    made = campaign(drives=drives, seconds=3.0)
    log, model = written(made, tmp_path, off(ONE_MASS, stiffness=1.1))
    words = ["compare", str(model), str(log), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(
        build_app(), [*words, "--fit", "--json", str(tmp_path / "c.json")]
    )
    assert done.exit_code == 0, done.stderr
    assert "explains every test with its numbers fitted" in done.stdout
    assert "95 % intervals" in done.stdout
    document = json.loads((tmp_path / "c.json").read_text())
    assert len(document["log_sha256"]) == 64
    assert document["refit"]["parameters"][0]["before"] == pytest.approx(
        1.1 * ONE_MASS.joints[0].stiffness
    )
    figures = {path.name for path in (tmp_path / "out").glob("*.png")}
    assert figures == {
        "response_ch3.png", "error_map_ch3.png", "restoring_force_base_coupon.png",
        "error_in_time.png", "harmonics.png",
    }  # fmt: skip
    with (tmp_path / "out" / "errors.csv").open() as file:
        assert [row["test"] for row in csv.DictReader(file)] == ["1", "2"]
    plain = CliRunner().invoke(build_app(), [*words, "--no-figures", "--json", "-"])
    assert plain.exit_code == 0, plain.stderr
    assert "the response peaks at" in json.loads(plain.stdout)["sentence"]
    paper = CliRunner().invoke(
        build_app(),
        [*words, "--before", str(model), "--no-figures", "--pdf"],
        env={"SHAKERPROC_BROWSER": "netscape"},
    )
    assert "no PDF: SHAKERPROC_BROWSER names 'netscape'" in str(paper.exception)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for told in ("old model", "Restoring force", document["log_sha256"], "Masri"):
        assert told in page
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert set(report["compare"]) == {"old model", "new model"}
