"""``process --unit``: fills in what the file leaves open, and never contradicts in silence."""

import re
from dataclasses import replace

import pytest
from tests.in_process import run

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import LogError
from shakerproc.runs import UnitOption, open_path
from shakerproc.testlog import Test


@pytest.fixture
def write(tmp_path):
    def write(*headers):
        path = tmp_path / "run.csv"
        rows = (",".join([str(i / 1000), *("1" for _ in headers)]) for i in range(500))
        path.write_text("\n".join([",".join(["time [s]", *headers]), *rows]), encoding="utf-8")
        return path

    return write


def opened(path, said, test=Test("t")):  # noqa: B008 - frozen
    """Return the first sample of each channel, in SI."""
    with open_path(path, test, unit=said) as recording:
        return {
            c.name: v
            for c, v in zip(recording.channels, recording.samples(0, 1)[:, 0], strict=True)
        }


def refused(path, said, match, test=Test("t")):  # noqa: B008 - frozen
    with pytest.raises(LogError, match=match), open_path(path, test, unit=said):
        pass


def test_channels_without_a_unit_get_it_and_the_others_keep_theirs(write):
    found = opened(write("a", "b [m/s2]", "c", "F [N]"), UnitOption("m/s^2"))
    assert found == {"a": 1.0, "b": 1.0, "c": 1.0, "F": 1.0}
    found = opened(write("a", "b [EU]", "c [g]"), UnitOption("g"))
    assert set(found.values()) == {STANDARD_GRAVITY}


def test_a_unit_that_the_file_contradicts_is_refused_until_it_overrides(write):
    path = write("a [g]", "b [g]", "c")
    told = "--unit says m/s^2, the file says 'a' in 'g', 'b' in 'g'. Take --unit out or"
    refused(path, UnitOption("m/s^2"), re.escape(told))
    assert set(opened(path, UnitOption("m/s^2", override=True)).values()) == {1.0}
    volts = write("a [V]", "b [V]", "c [V]")
    refused(volts, UnitOption("g"), "the file says 'a' in 'V'")
    found = opened(volts, UnitOption("g", override=True))
    assert set(found.values()) == {STANDARD_GRAVITY}


def test_a_unit_that_the_log_contradicts_is_refused(write):
    path = write("a", "b [g]")
    uses = (ChannelUse("a", "control", unit="mg"), ChannelUse("b", "response"))
    test = replace(Test("t"), channels=uses)
    refused(path, UnitOption("g"), "the log says unit: mg for channel a, --unit says g", test)
    assert opened(path, UnitOption("mg", override=True), test)["b"] == pytest.approx(9.80665e-3)


def test_what_is_no_unit_of_a_channel_is_wrong_usage(write, capsys):
    path = write("a [g]", "b [g]")
    for options, words in (
        (("--unit", "furlong"), "such as g, m/s^2 or N, got 'furlong'"),
        (("--unit", "kg"), "got 'kg'"),
        (("--override-unit",), "goes with --unit"),
    ):
        assert run("process", path, *options) == 2
        assert words in " ".join(capsys.readouterr().err.replace("│", " ").split())
