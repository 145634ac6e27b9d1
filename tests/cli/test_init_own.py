"""`shakerproc init FOLDER --recordings FOLDER`: a log and a model of one's own recordings."""

import pytest
from tests.in_process import run
from tests.small_campaign import CHANNELS, RATE, samples, write_recording

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.model_files import read_model
from shakerproc.recordings import write_tdms
from shakerproc.testlog import read_testlog
from shakerproc.workflows.draft import controls_of, measures, recordings_below


@pytest.fixture
def folder(tmp_path):
    for number in (2, 10, 1):
        path = tmp_path / "recordings" / f"Test_{number}" / "Acceleration.tdms"
        path.parent.mkdir(parents=True)
        write_recording(path, 250.0)
    return tmp_path


def test_every_recording_has_its_line_and_the_log_works(folder, capsys):
    assert run("init", folder, "--recordings", folder / "recordings") == 0
    log, model = read_testlog(folder / "testlog.yaml"), read_model(folder / "model.yaml")
    assert [str(test.id) for test in log.tests] == ["1", "2", "10"]
    assert all(test.require_recording().is_file() for test in log.tests)
    uses = {use.key: use for use in log.tests[0].channels}
    assert sum(use.role == "control" for use in uses.values()) == 2
    responses = [str(name) for name, use in uses.items() if use.role == "response"]
    assert list(model.sensors) == responses
    assert log.tests[0].processing.crop is not None
    shown = capsys.readouterr()
    assert "shakerproc batch" in shown.out
    assert "???" in shown.err
    options = ["--no-figures", "--workers", 1, "--out", folder / "results"]
    assert run("batch", folder / "testlog.yaml", *options) == 0
    assert "3 processed" in capsys.readouterr().out


def test_what_is_there_is_never_written_over(folder, capsys):
    (folder / "model.yaml").write_text("mine", encoding="utf-8")
    assert run("init", folder, "--recordings", folder / "recordings") == 1
    assert "there already" in capsys.readouterr().err
    assert (folder / "model.yaml").read_text(encoding="utf-8") == "mine"
    assert not (folder / "testlog.yaml").exists()


def test_recordings_elsewhere_and_empty_folders_are_refused(folder, tmp_path_factory, capsys):
    other = tmp_path_factory.mktemp("other")
    assert run("init", other / "new", "--recordings", folder / "recordings") == 1
    assert "not below" in capsys.readouterr().err
    assert run("init", other, "--recordings", other) == 1
    assert "no recording in it" in capsys.readouterr().err


def test_a_bad_recording_is_left_out_and_said(folder, capsys):
    (folder / "recordings" / "bad_3.tdms").write_bytes(b"TDSm nothing")
    assert run("init", folder, "--recordings", folder / "recordings") == 0
    assert "not usable yet: bad_3" in capsys.readouterr().err
    assert len(read_testlog(folder / "testlog.yaml").tests) == 3


def test_recordings_with_other_channels_have_them_in_their_own_line(folder, capsys):
    """A force instead of the second response, in another order, and a table of another name."""
    names = ["table", "control 2", "response 1", "force"]
    channels = [Channel(name, "?", name, "N" if name == "force" else "g") for name in names]
    odd = folder / "recordings" / "Test_10" / "Acceleration.tdms"
    write_tdms(odd, recording_of_arrays("odd", channels, samples(250.0), RATE))
    swapped = folder / "recordings" / "Test_2" / "Acceleration.tdms"
    rows = recording_of_arrays("swapped", CHANNELS[::-1], samples(250.0)[::-1], RATE)
    write_tdms(swapped, rows)
    assert run("init", folder, "--recordings", folder / "recordings") == 0
    told = capsys.readouterr().err
    assert "Test_10/Acceleration.tdms has other channels than Test_1/Acceleration.tdms" in told
    assert "Test_2/" not in told
    log = read_testlog(folder / "testlog.yaml")
    roles = {
        str(test.id): {str(use.key): use.role for use in test.channels} for test in log.tests
    }
    assert roles["1"] == roles["2"]
    assert roles["10"] == roles["1"] | {
        "control 1": "ignore", "response 2": "ignore", "table": "control", "force": "force"
    }  # fmt: skip
    options = ["--no-figures", "--workers", 1, "--out", folder / "results"]
    assert run("batch", folder / "testlog.yaml", *options) == 0
    assert "3 processed" in capsys.readouterr().out


def test_channels_of_one_name_are_told_apart_by_number(tmp_path):
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i / 100},{i % 7},{i % 5},{i % 3}\n" for i in range(3000))
    table = f"time [s],table [g],ai [g],ai [g]\n{rows}"
    (tmp_path / "r" / "run_1.csv").write_text(table, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    uses = read_testlog(tmp_path / "testlog.yaml").tests[0].channels
    assert [(use.key, use.name) for use in uses] == [
        ("table", None), (2, "ai 2"), (3, "ai 3")
    ]  # fmt: skip
    assert list(read_model(tmp_path / "model.yaml").sensors) == ["ai 2", "ai 3"]
    assert run("batch", tmp_path / "testlog.yaml", "--no-figures", "--workers", 1) == 0


def test_a_missing_unit_is_marked_and_not_guessed(tmp_path):
    (tmp_path / "r").mkdir()
    table = "time [s],a #1,b [V],c [degC]\n" + "".join(f"{i / 100},1,2,3\n" for i in range(200))
    (tmp_path / "r" / "b.csv").write_text(table, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    text = (tmp_path / "testlog.yaml").read_text(encoding="utf-8")
    assert "no unit in the file" in text
    assert "volts: add sensitivity" in text
    uses = {use.key: use for use in read_testlog(tmp_path / "testlog.yaml").tests[0].channels}
    assert {str(name): use.role for name, use in uses.items()} == {
        "a #1": "control",
        "b": "response",
        "c": "ignore",
    }


def test_accelerations_come_before_volts_and_units_are_read_as_in_a_file(tmp_path):
    """A drive in volts, two accelerations in g's, a light barrier without a unit."""
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i / 100},{i % 5},1,{i % 7},{i % 3}\n" for i in range(3000))
    head = "time,Output To Table,LED Light,Table accel,Block accel\nseconds,Volts,,g's,g's\n"
    (tmp_path / "r" / "b.csv").write_text(head + rows, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    test = read_testlog(tmp_path / "testlog.yaml").tests[0]
    assert {str(use.key): use.role for use in test.channels} == {
        "Output To Table": "ignore",
        "LED Light": "ignore",
        "Table accel": "control",
        "Block accel": "response",
    }
    assert test.processing.crop is not None
    assert list(read_model(tmp_path / "model.yaml").sensors) == ["Block accel"]
    assert run("batch", tmp_path / "testlog.yaml", "--no-figures", "--workers", 1) == 0


def test_a_force_without_a_table_drives_the_test(tmp_path):
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i / 100},{i % 5},{i % 7}\n" for i in range(3000))
    (tmp_path / "r" / "b.csv").write_text("t,ai0 [N],ai1 [g]\n" + rows, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    test = read_testlog(tmp_path / "testlog.yaml").tests[0]
    assert [(use.key, use.role) for use in test.channels] == [
        ("ai0", "force"), ("ai1", "response")
    ]  # fmt: skip
    assert test.processing.crop is None
    model = read_model(tmp_path / "model.yaml")
    assert list(model.sensors) == ["ai1"]
    assert "force on: coupon" in (tmp_path / "model.yaml").read_text()
    assert run("batch", tmp_path / "testlog.yaml", "--no-figures", "--workers", 1) == 0


def test_names_say_what_is_measured_where_no_unit_does_and_a_column_of_the_rate_is_none(
    tmp_path,
):
    """As the F-16 benchmark has it: the rate stands once in a column of its own."""
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i % 5},1,{i % 7},{i % 3},,\n" for i in range(1, 3000))
    head = '"Force","Voltage","Acceleration1","Acceleration2","Fs",\n0,1,0,0,400,\n'
    (tmp_path / "r" / "b.csv").write_text(head + rows, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    test = read_testlog(tmp_path / "testlog.yaml").tests[0]
    assert {str(use.key): use.role for use in test.channels} == {
        "Force": "force", "Voltage": "ignore", "Acceleration1": "response",
        "Acceleration2": "response",
    }  # fmt: skip
    text = (tmp_path / "testlog.yaml").read_text(encoding="utf-8")
    assert (
        "Force: {role: force, at: coupon}   # (guess) ??? no unit in the file: add unit: N"
        in text
    )


def test_controls_are_found_by_name_else_the_first_is_taken():
    assert controls_of(["ch1", "Control 1", "base z"]) == ["Control 1", "base z"]
    assert controls_of(["ai0", "ai1"]) == ["ai0"]


def test_recordings_come_in_the_order_of_their_numbers(folder):
    names = [path.parent.name for path in recordings_below(folder / "recordings")]
    assert names == ["Test_1", "Test_2", "Test_10"]


def test_a_log_is_begun_for_recordings_that_cannot_be_used_yet(tmp_path, capsys):
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "run_1.csv").write_text("a [g],b [g]\n1,2\n3,4\n" * 1, encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    assert "sample rate" in capsys.readouterr().err
    assert [str(test.id) for test in read_testlog(tmp_path / "testlog.yaml").tests] == ["1"]


def test_a_sample_rate_that_the_files_do_not_say_goes_into_the_log(tmp_path, capsys):
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i % 7},{i % 5}\n" for i in range(500))
    (tmp_path / "r" / "run_1.csv").write_text("a [g],b [g]\n" + rows, encoding="utf-8")
    options = ["--recordings", tmp_path / "r", "--sample-rate-hz", 100]
    assert run("init", tmp_path, *options) == 0
    assert "not usable" not in capsys.readouterr().err
    assert read_testlog(tmp_path / "testlog.yaml").tests[0].processing.sample_rate == 100.0
    assert run("init", tmp_path / "new", "--sample-rate-hz", 100) == 2


def test_a_shaken_test_is_the_template_and_a_hammer_in_volts_a_force(tmp_path):
    """By name the hammer test comes first."""
    (tmp_path / "r").mkdir()
    rows = "".join(f"{i / 100},{i % 5},{i % 7}\n" for i in range(3000))
    for name, head in (("a_hammer", "hammer [V],tip [V]"), ("run_1", "table [V],tip [V]")):
        (tmp_path / "r" / f"{name}.csv").write_text(f"t,{head}\n{rows}", encoding="utf-8")
    assert run("init", tmp_path, "--recordings", tmp_path / "r") == 0
    text = (tmp_path / "testlog.yaml").read_text(encoding="utf-8")
    assert "\n  table: {role: control}" in text
    assert "channels: {hammer: {role: force" in text
    assert list(read_model(tmp_path / "model.yaml").sensors) == ["tip"]


@pytest.mark.parametrize(
    ("name", "unit", "wanted"),
    [
        ("Kraft 1", "", "N"), ("impact hammer", "V", "N"), ("laser", "", "m"),
        ("Weg", "", "m"), ("beschleunigung x", "", "m/s^2"), ("laser", "V", "V"),
        ("Kraft 1", "g", "m/s^2"), ("tip", "", ""),
    ],
)  # fmt: skip
def test_a_name_says_the_same_quantity_to_a_draft_as_to_a_reader(name, unit, wanted):
    """Words of other languages, too; a unit counts more, but for volts of a force sensor."""
    assert measures(name, unit) == wanted
