import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from tests.cli.terminal import shown_on_terminal
from tests.in_process import completed
from tests.small_campaign import CHANNELS, RATE, samples, write_campaign, write_recording
from typer.testing import CliRunner

from shakerproc import __version__, files
from shakerproc.campaign.result_folder import locked
from shakerproc.cli import build_app
from shakerproc.cli.commands import COMMANDS, GROUPS
from shakerproc.data import recording_of_arrays
from shakerproc.recordings import write_tdms

ROOT = Path(__file__).parents[2]
HEAVY = {"numpy", "pandas", "scipy", "matplotlib", "numba", "pyarrow", "rich", "pint", "nptdms"}
WRITES_NOTHING = {"doctor", "inspect", "effects", "check"}
TAKES_ITS_FOLDER = {"demo"}  # as argument
SAYS_NOTHING = {"init", "convert", "nastran"}


def test_the_version_is_shown():
    done = subprocess.run(
        [sys.executable, "-m", "shakerproc", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"shakerproc {__version__}\n"


def test_help_is_quick_and_loads_nothing_heavy():
    code = (
        "import sys, time; t = time.process_time()\n"
        "import shakerproc.cli as cli\n"
        "sys.argv = ['shakerproc', '--help']\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "print(time.process_time() - t, *sys.modules, file=sys.stderr)"
    )
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(3)
    ]
    seconds = min(float(run.stderr.split()[0]) for run in runs)
    assert seconds < 0.4
    loaded = {name.split(".")[0] for name in runs[0].stderr.split()[1:]}
    assert not loaded & HEAVY
    assert "Exit status" in runs[0].stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_and_the_shared_options(name):
    done = CliRunner().invoke(build_app(), [name, "--help"])
    assert done.exit_code == 0
    summary = done.stdout.split("\n\n")[1].strip()
    assert summary.endswith(".")
    if name not in SAYS_NOTHING:
        assert "--json" in done.stdout
    if name not in WRITES_NOTHING | SAYS_NOTHING | TAKES_ITS_FOLDER:
        assert "--out" in done.stdout


def test_every_command_stands_in_one_group_of_the_help():
    shown = CliRunner().invoke(build_app(), ["--help"], env={"COLUMNS": "96"}).stdout
    listed = re.findall(r"^  ([a-z]+) {2,}[A-Z]", shown, re.MULTILINE)
    assert sorted(listed) == sorted(COMMANDS)


def test_the_line_of_every_command_is_whole_on_a_terminal_of_80_columns():
    shown = CliRunner().invoke(build_app(), ["--help"], env={"COLUMNS": "80"}).stdout
    lines = re.findall(r"^  ([a-z]+) {2,}([A-Z].*)$", shown, re.MULTILINE)
    assert len(lines) == len(COMMANDS)
    assert [name for name, line in lines if line.endswith("...")] == []


def test_options_stand_below_the_title_of_their_group():
    shown = CliRunner().invoke(build_app(), ["process", "--help"], env={"COLUMNS": "96"}).stdout
    title_of = {}
    for line in shown.splitlines():
        if line.endswith(":") and not line.startswith(" "):
            title = line[:-1]
        elif line.startswith("  --"):
            title_of[line.split()[0]] = title
    assert title_of["--excitation"] == "The test"
    assert title_of["--no-crop"] == "The part that is used"
    assert title_of["--time-unit"] == "Reading the recording"
    assert title_of["--segment"] == "Spectra"
    assert title_of["--json"] == "Results"


def test_wrong_usage_is_status_2_with_a_guess():
    done = completed("bacth")
    assert done.returncode == 2
    assert "Did you mean 'batch'" in done.stderr
    assert done.stdout == ""
    assert completed("process", "no such file.tdms").returncode == 2
    assert completed("process").returncode == 2


def test_unusable_input_is_status_1_and_one_line(tmp_path):
    bad = tmp_path / "bad.tdms"
    bad.write_bytes(b"TDSmnothing")
    done = completed("process", bad, "--out", tmp_path / "o")
    assert done.returncode == 1
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stderr.startswith("error: ")


def test_a_locked_folder_is_status_75(tmp_path):
    log = write_campaign(tmp_path, 1)
    with locked(tmp_path / "o"):
        done = completed("batch", log, "--out", tmp_path / "o")
    assert done.returncode == 75
    assert "another shakerproc works in this folder" in done.stderr


def test_json_on_stdout_is_json_and_nothing_else(tmp_path):
    recording = write_recording(tmp_path / "r.tdms", 250.0)
    done = completed(
        "process", recording, "--crop-threshold", "0.2 g", "--no-figures",
        "--out", tmp_path / "o", "--json", "-",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert [c["name"] for c in document["channels"]][:2] == ["control 1", "control 2"]
    assert "results in" in done.stderr


def test_options_that_do_not_fit_are_wrong_usage(tmp_path):
    recording = write_recording(tmp_path / "r.tdms", 250.0)
    for options, words in (
        (["--export", "xls"], "no format 'xls'"),
        (["--segment", "64", "--overlap", "64"], "64 samples do not fit a segment of 64"),
        (["--excitation", "noise"], "'noise' is not one of sine sweep"),
        (["--crop-threshold", "0,45 g"], "0.45 g"),
        (["--level", "much"], "--level"),
    ):
        command = ["process", str(recording), "--out", str(tmp_path / "o"), *options]
        done = CliRunner().invoke(build_app(), command)
        assert done.exit_code == 2, done.stderr
        assert words in " ".join(done.stderr.split())


def test_the_terminal_gets_no_control_characters(tmp_path):
    channels = [
        replace(channel, name=f"{channel.name} \x1b[31m\x07\u202e", source_name=channel.name)
        for channel in CHANNELS
    ]
    path = tmp_path / "r.tdms"
    write_tdms(path, recording_of_arrays("r", channels, samples(250.0), RATE))
    done = completed(
        "process", path, "--crop-threshold", "0.2 g", "--no-figures", "--out", tmp_path / "o"
    )
    assert "r.tdms" in done.stdout + done.stderr
    for stream in (done.stdout, done.stderr):
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", stream)


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
@pytest.mark.parametrize("no_color", [True, False])
def test_colour_is_for_terminals_that_want_it(no_color):
    wanted = {"NO_COLOR": "1"} if no_color else {}
    recording = ROOT / "sample_data" / "recordings" / "Test_1" / "Acceleration.tdms"
    command = [sys.executable, "-m", "shakerproc", "inspect", recording]
    shown = shown_on_terminal(command, **wanted)
    assert "─" in shown
    assert bool(re.search(r"\x1b\[[0-9;]*3[0-9]", shown)) <= (not no_color)


def test_doctor_says_what_is_there_and_what_is_missing():
    done = completed("doctor", "--json", "-")
    assert done.returncode == 0
    document = json.loads(done.stdout)
    assert document["missing"] == []
    assert set(document["missing_extras"]) == {
        "cluster", "parquet", "xlsx", "recorders", "docs", "dev",
    }  # fmt: skip
    assert document["speed"]["fft_samples_per_s"] > 1e5
    assert document["packages"]["numpy"]


@pytest.mark.slow
def test_the_page_of_commands_is_what_help_says():
    done = subprocess.run(
        [sys.executable, ROOT / "docs" / "make_cli_page.py", "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


PAGES = sorted([ROOT / "README.md", *ROOT.glob("docs/**/*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_every_command_and_option_that_a_page_names_exists(page):
    text = page.read_text(encoding="utf-8")
    for line in re.findall(r"(?:^|`)(?:\$ )?shakerproc ([a-z]+[^\n`]*)", text, re.MULTILINE):
        name, *words = line.split()
        assert name in COMMANDS, f"{page.name}: shakerproc {line}"
        inner = words[:1] if isinstance(COMMANDS[name], typer.Typer) else []
        shown = CliRunner().invoke(build_app(), [name, *inner, "--help"]).stdout
        for word in words:
            if word.startswith("--"):
                assert word.split("=")[0] in shown, f"{page.name}: shakerproc {line}"


@pytest.mark.parametrize(
    "text",
    ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "=cmd|' /C calc'!A0", "\r=1"],
)
def test_a_spreadsheet_runs_no_text(text):
    cell = files.csv_text({"h": [text]}).splitlines()[1]
    assert not cell.strip('"').startswith(("=", "+", "-", "@", "\t", "\r"))
    header = files.csv_text({text: [1]}).splitlines()[0]
    assert not header.strip('"').startswith(("=", "+", "-", "@", "\t", "\r"))


def test_numbers_stay_numbers_to_the_last_digit():
    values = [-1.5, 0.1 + 0.2, 1e-300, -7]
    lines = files.csv_text({"x": values}).splitlines()[1:]
    assert [float(line) for line in lines] == values


def test_compiling_is_said_once_and_only_when_there_is_something_to_compile():
    """In a process of its own: another test may have had it said in this one."""
    script = """
import sys
from numba import njit
from shakerproc.cli import messages
messages.announce()
messages.announce()
print("before", file=sys.stderr)
for function in (njit(lambda x: x + 1.0), njit(lambda x: x + 2.0)):
    function(1.0)
print("after", file=sys.stderr)
function(2.0)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    before, said, after = done.stderr.splitlines()
    assert (done.stdout, before, after) == ("", "before", "after")
    assert said.startswith("compiling what this command needs, once")


def test_a_former_name_of_a_command_works_and_says_the_name_of_today(tmp_path):
    coupon = Path(__file__).parents[2] / "configs" / "coupons" / "pom_c_radial.yaml"
    words = [str(coupon), "--json", "-", "--count", "1", "--no-static", "--no-figures"]
    words += ["--out", str(tmp_path / "out")]
    done = {n: CliRunner().invoke(build_app(), [n, *words]) for n in ("modes", "coupon")}
    assert [one.exit_code for one in done.values()] == [0, 0]
    assert done["modes"].stdout == done["coupon"].stdout
    assert "called `shakerproc coupon` now" in done["modes"].stderr
    assert "called" not in done["coupon"].stderr
    assert "modes" not in GROUPS["Coupons and other programs"]
