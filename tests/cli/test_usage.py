"""Wrong usage is one line: what is wrong, the name that may be meant, and where help stands."""

import pytest
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.cli.commands import COMMANDS

PATHS = {
    "inspect": 1, "process": 1, "batch": 1, "watch": 1, "check": 1, "compare": 2, "diagnose": 2,
    "simulate": 2, "response": 1, "study": 1, "plan": 1, "forecast": 2, "modal": 1,
    "stiffness": 1, "coupon": 1, "convert": 2,
}  # fmt: skip
"""Commands whose arguments are files or folders that exist, and how many they are."""


def refused(*arguments):
    """Return the one line that refuses a command, without its beginning."""
    done = CliRunner().invoke(build_app(), [str(argument) for argument in arguments])
    assert done.exit_code == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: ")
    return line.removeprefix("error: ")


@pytest.mark.parametrize("name", COMMANDS)
def test_an_unknown_option_is_one_line(name):
    told = refused(name, "--no-such-option")
    assert told.startswith("No such option: --no-such-option")
    assert told.endswith(f"See `root {name} -h`.")


@pytest.mark.parametrize(("name", "count"), PATHS.items())
def test_a_path_that_does_not_exist_is_one_line(name, count, tmp_path):
    told = refused(name, *[tmp_path / "absent.yaml"] * count)
    assert f"'{tmp_path / 'absent.yaml'}' does not exist." in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ("process", "RECORDING", "--log", "FILE"),
        ("batch", "LOG", "--model", "FILE"),
        ("modal", "LOG", "--against", "FILE"),
        ("nastran", "write", "LOG", "--log", "FILE"),
    ],
)
def test_a_path_of_an_option_that_does_not_exist_is_one_line(words, tmp_path):
    (tmp_path / "there.yaml").touch()
    places = {
        "RECORDING": tmp_path / "there.yaml",
        "LOG": tmp_path / "there.yaml",
        "FILE": tmp_path / "absent.yaml",
    }
    told = refused(*[places.get(word, word) for word in words])
    assert f"'{tmp_path / 'absent.yaml'}' does not exist." in told
    assert [path.name for path in tmp_path.iterdir()] == ["there.yaml"]


def test_the_nearest_name_of_the_folder_is_offered(tmp_path):
    (tmp_path / "testlog.yaml").touch()
    told = refused("batch", tmp_path / "testlgo.yaml")
    assert f"Did you mean '{tmp_path / 'testlog.yaml'}'? See" in told


def test_a_folder_that_does_not_exist_is_told(tmp_path):
    told = refused("inspect", tmp_path / "runs" / "test_1.tdms")
    assert f"does not exist: there is no folder '{tmp_path / 'runs'}'." in told


def test_a_number_that_is_none_is_told_with_what_was_given(tmp_path):
    told = refused("process", tmp_path, "--segment", "many")
    assert "--segment" in told
    assert "'many'" in told


def test_arguments_that_are_missing_or_too_many_are_one_line(tmp_path):
    assert refused("process").startswith("Missing argument 'RECORDING'.")
    assert "unexpected extra argument" in refused("inspect", tmp_path, "b")


def test_a_command_of_a_command_is_one_line():
    assert "Did you mean 'write'?" in refused("nastran", "wirte")


def test_nothing_asked_shows_the_help():
    done = CliRunner().invoke(build_app(), [])
    assert "Usage:" in done.stdout + done.stderr
    assert "error:" not in done.stdout + done.stderr
