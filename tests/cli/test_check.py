"""`shakerproc check`: a table against a reference."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from tests.small_campaign import write_campaign
from typer.testing import CliRunner

from shakerproc.campaign.agreement import agreement, read_table, read_tolerance
from shakerproc.cli import build_app
from shakerproc.errors import TableError

ROOT = Path(__file__).parents[2]
RECIPE = ROOT / "examples" / "ci"

HEAD = "test,peak_frequency_hz\n"


def run(*words):
    done = CliRunner().invoke(build_app(), list(map(str, words)))
    assert done.exception is None or isinstance(done.exception, SystemExit | TableError)
    return done


def table(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    log = write_campaign(folder, 2)
    options = ["--out", folder / "results", "--no-figures", "--workers", 1]
    done = run("batch", log, *options)
    assert done.exit_code == 0, done.output
    return folder / "results"


def changed(results, folder, change):
    """A copy of the table of peaks with its rows changed."""
    path = folder / "peaks.csv"
    with (results / "peaks.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    kept = [row for row in (change(dict(row)) for row in rows) if row is not None]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(kept)
    return path


def test_every_table_of_a_batch_agrees_with_itself(results):
    for name in ("peaks.csv", "peaks.parquet"):
        done = run("check", results / name, "--against", results, "--tolerance", "0 %")
        assert done.exit_code == 0, done.output
        assert "all hold" in done.stdout
    trends = sorted((results / "trends").glob("*.csv"))
    for one in trends:
        assert run("check", results, "--against", one).exit_code == 0
        assert run("check", one, "--against", one).exit_code == 0
    options = ["--columns", "measured_level, sample_rate_hz=1 Hz"]
    runs = results / "runs.csv"
    assert run("check", runs, "--against", runs, *options).exit_code == 0
    statistics = results / "statistics.csv"
    assert run("check", statistics, "--against", statistics, "--columns", "rms").exit_code == 0


def test_a_frequency_that_moved_is_named_with_what_was_wanted(results, tmp_path):
    def higher(row):
        if row["test"] == "2" and row["quantity"] == "psd" and row["role"] == "response":
            row["frequency_hz"] = repr(1.03 * float(row["frequency_hz"]))
        return row

    moved = changed(results, tmp_path, higher)
    done = run("check", moved, "--against", results, "--tolerance", "2 %", "--json", "-")
    assert done.exit_code == 1
    document = json.loads(done.stdout)
    assert not document["holds"]
    assert {one["test"] for one in document["deviations"]} == {"2"}
    for one in document["deviations"]:
        assert one["found"] == pytest.approx(1.03 * one["wanted"])
        assert one["allowed"] == pytest.approx(0.02 * one["wanted"])
    shown = run("check", moved, "--against", results)
    lines = shown.stdout.splitlines()
    assert len(lines) == 1 + len(document["deviations"])
    for words in ("test 2, ", "peak_frequency: found ", "wanted ", "+- 2 %, off by +3.00 %"):
        assert words in lines[0]
    assert run("check", moved, "--against", results, "--tolerance", "4 %").exit_code == 0


@pytest.mark.parametrize("factor", [1.020001, 0.97999, 1.0200000003, 1e300])
@pytest.mark.parametrize("tolerance", ["2 %", "6 Hz"])
def test_a_value_just_outside_is_not_printed_inside(tmp_path, factor, tolerance):
    kept, moved = tmp_path / "kept.csv", tmp_path / "moved.csv"
    kept.write_text("test,peak_frequency_hz\n1,300.0\n")
    moved.write_text(f"test,peak_frequency_hz\n1,{300.0 * factor!r}\n")
    done = run("check", moved, "--against", kept, "--tolerance", tolerance)
    assert done.exit_code == 1
    off = float(re.search(r"off by (\S+) ", done.stdout).group(1))
    assert abs(off) > float(tolerance.split()[0])
    assert "within" not in done.stdout


def test_a_value_without_end_is_off(tmp_path):
    kept, moved = tmp_path / "kept.csv", tmp_path / "moved.csv"
    kept.write_text("test,peak_frequency_hz\n1,300.0\n")
    moved.write_text("test,peak_frequency_hz\n1,inf\n")
    done = run("check", moved, "--against", kept)
    assert done.exit_code == 1
    assert "found inf Hz, wanted 300 Hz" in done.stdout


def test_a_missing_run_is_named_and_a_further_one_is_told(results, tmp_path):
    fewer = changed(results, tmp_path, lambda row: row if row["test"] != "2" else None)
    done = run("check", fewer, "--against", results)
    assert done.exit_code == 1
    assert done.stdout.splitlines()[0].startswith("test 2: missing from ")
    assert "1 run is missing" in done.stdout
    other_way = run("check", results, "--against", fewer)
    assert other_way.exit_code == 0
    assert "test 2 is not in" in other_way.stderr


def test_why_a_run_is_missing_stands_in_the_table_of_runs(results, tmp_path):
    fewer = changed(results, tmp_path, lambda row: row if row["test"] != "2" else None)
    table(tmp_path, "runs.csv", "test,status,error\n1,done,\n2,failed,the file is empty\n")
    done = run("check", fewer, "--against", results)
    assert "(failed: the file is empty)" in done.stdout


def test_a_reference_may_be_written_by_hand(results, tmp_path):
    channel = read_table(results / "peaks.csv").rows[-1]["channel"]
    row = next(
        r
        for r in read_table(results / "peaks.csv").rows
        if (r["test"], r["channel"], r["quantity"], r["rank"]) == ("1", channel, "psd", "1")
    )
    frequency = float(row["frequency_hz"])
    text = f"test,channel,peak_frequency_hz\n1,{channel},{frequency + 0.4}\n"
    wanted = table(tmp_path, "wanted.csv", text)
    assert run("check", results, "--against", wanted, "--tolerance", "0.5 Hz").exit_code == 0
    assert run("check", results, "--against", wanted, "--tolerance", "0.3 Hz").exit_code == 1
    assert run("check", results, "--against", wanted, "--tolerance", "3e-4 kHz").exit_code == 1


@pytest.mark.parametrize(
    ("found", "wanted", "words"),
    [
        (HEAD + "1,abc\n", HEAD + "1,2\n", 'f.csv:2: peak_frequency_hz: .*"abc"'),
        (HEAD + "1,2\n1,3\n", HEAD + "1,2\n", "f.csv:3: a second"),
        (HEAD + "1\n", HEAD + "1,2\n", "f.csv:2: 1 cells"),
        (HEAD.replace("test", "run") + "1,2\n", HEAD + "1,2\n", "no column test"),
        ("test,q\n1,2\n", HEAD + "1,2\n", "no peak frequency"),
        (HEAD + "1,2\n", HEAD + "1,\n", "nothing to compare with"),
        ("", HEAD + "1,2\n", "no column test; it has none"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_used_is_said_with_its_line(tmp_path, found, wanted, words):
    paths = table(tmp_path, "f.csv", found), table(tmp_path, "w.csv", wanted)
    with pytest.raises(TableError, match=words):
        agreement(*map(read_table, paths), {"peak_frequency": read_tolerance("2 %")})


def test_a_column_that_is_not_there_is_guessed(results):
    done = run("check", results, "--against", results, "--columns", "qualty")
    assert "did you mean quality" in str(done.exception)


def test_an_empty_folder_and_other_files_are_refused(tmp_path, results):
    assert "no peaks.csv" in str(run("check", tmp_path, "--against", results).exception)
    report = results / "report.json"
    assert "expected a table" in str(run("check", report, "--against", results).exception)


@pytest.mark.parametrize(
    "text", ["2", "", "%", "-1 %", "two %", "nan %", "inf Hz", "1 s", "1 furlong"]
)
def test_a_tolerance_that_makes_no_sense_is_wrong_usage(results, text):
    done = run("check", results, "--against", results, "--tolerance", text)
    assert done.exit_code == 2
    assert "--tolerance" in done.stderr


@given(st.floats(1.0, 1e4), st.floats(-0.5, 0.5), st.floats(0.0, 50.0))
def test_the_limit_itself_is_within(wanted, off, percent):
    """Oracle: the definition of a relative tolerance."""
    tolerance = read_tolerance(f"{percent!r} %")
    difference = abs(wanted * (1.0 + off) - wanted)
    assert tolerance.around(wanted, "Hz") == pytest.approx(percent / 100.0 * wanted)
    if abs(difference / wanted - percent / 100.0) > 1e-9:
        assert (difference <= tolerance.around(wanted, "Hz")) == (abs(off) <= percent / 100.0)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("sh") is None, reason="no shell to run the recipe with")
def test_the_recipe_for_ci_passes_and_fails_as_it_should(tmp_path):
    """The script that both jobs call; that its reference holds, its page shows."""
    log = write_campaign(tmp_path, 1)
    here = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def recipe(*words):
        return subprocess.run(
            ["sh", RECIPE / "check.sh", log, *words],
            capture_output=True,
            text=True,
            encoding="utf-8",
            cwd=tmp_path,
            env={**os.environ, "PATH": here},
            check=False,
        )

    made = "test,channel,peak_frequency_hz\n1,ch3,360\n"
    done = recipe(table(tmp_path, "right.csv", made))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "all hold: 1 value of peak_frequency within 2 %" in done.stdout
    done = recipe(table(tmp_path, "wrong.csv", made.replace("360", "380")))
    assert done.returncode == 1
    assert re.search(r"test 1, ch3: peak_frequency: found 3\S+ Hz, wanted 380 Hz", done.stdout)
    document = json.loads((tmp_path / "results" / "check.json").read_text(encoding="utf-8"))
    assert [one["test"] for one in document["deviations"]] == ["1"]


@pytest.mark.parametrize("name", ["github-actions.yml", "gitlab-ci.yml"])
def test_the_jobs_call_the_script_with_files_that_exist(name):
    text = (RECIPE / name).read_text(encoding="utf-8")
    assert yaml.safe_load(text)
    (call,) = re.findall(r"sh (\S+) (\S+) (\S+) \"2 %\"", text)
    for path in call:
        assert (ROOT / path).is_file()


def test_a_former_name_is_taken_with_a_note(tmp_path):
    kept, found = tmp_path / "kept.csv", tmp_path / "found.csv"
    kept.write_text("test,omega_e_hz\n1,300.0\n")
    found.write_text("test,peak_frequency_hz\n1,301.0\n")
    words = ["check", str(found), "--against", str(kept), "--columns", "omega_e, omega_e_hz"]
    done = CliRunner().invoke(build_app(), words)
    assert done.exit_code == 0
    assert "1 value of peak_frequency" in done.stdout
    assert f"{kept}: omega_e_hz is called peak_frequency_hz now" in done.stderr
    assert "--columns: omega_e is called peak_frequency now" in done.stderr
