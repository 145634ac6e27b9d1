"""Packages that bring effects and readers, sound and broken."""

import json
import textwrap
from pathlib import Path

import numpy as np
import pytest
from tests.in_process import run

from shakerproc.cli.commands.doctor import plug_ins
from shakerproc.errors import RecordingError
from shakerproc.models import EFFECTS
from shakerproc.recordings import READERS, open_recording

READER = """
    import numpy as np
    from shakerproc.data import ArraySource
    from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup


    def read(path, run):
        volts = np.loadtxt(path)
        channel = RawChannel("a", 0, volts.size, volts.size, "g", 100.0)
        return RawFile((RawGroup("", (channel,)),), ArraySource(volts[np.newaxis]))


    def raising(path, run):
        raise KeyError("header")


    def returning_an_array(path, run):
        return np.zeros(3)


    no_function = 3
"""
ENTRIES = """
    [shakerproc.readers]
    rows = bringer:read
    csv = bringer:read
    rows2 = bringer:raising
    rows3 = bringer:returning_an_array
    rows4 = bringer:no_function
    rows5 = nothing_there:read

    [shakerproc.effects]
    mine = bringer_of_none
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package on the path, with readers and an effect, most of them broken."""
    (tmp_path / "bringer.py").write_text(textwrap.dedent(READER), encoding="utf-8")
    told = tmp_path / "bringer-1.0.dist-info"
    told.mkdir()
    (told / "METADATA").write_text("Name: bringer\nVersion: 1.0\n", encoding="utf-8")
    (told / "entry_points.txt").write_text(textwrap.dedent(ENTRIES), encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(READERS, "_installed", None)
    monkeypatch.setattr(EFFECTS, "_installed", None)
    return tmp_path


def test_a_recording_is_opened_by_the_reader_of_a_package(package):
    path = package / "one.rows"
    path.write_text("1.0\n-2.0\n", encoding="utf-8")
    with open_recording(path) as recording:
        np.testing.assert_allclose(recording.samples(), [[9.80665, -19.6133]])
    assert ".rows" in READERS
    assert READERS[".csv"] is READERS.known[".csv"]


@pytest.mark.parametrize(
    ("ending", "message"),
    [
        (
            "rows2",
            r"x\.rows2: entry point rows2 \(bringer:raising\) failed: Key.*header",
        ),
        ("rows3", r"x\.rows3: entry point rows3 .*: returned ndarray, not a RawFile"),
        ("rows4", r"entry point rows4 .*: is no function"),
        ("rows5", r"entry point rows5 .*: ModuleNotFoundError"),
    ],
)
def test_a_broken_reader_is_one_line_that_says_where(package, ending, message):
    path = package / f"x.{ending}"
    path.write_text("1.0\n", encoding="utf-8")
    with pytest.raises(RecordingError, match=message) as told:
        open_recording(path)
    assert "\n" not in str(told.value)


def test_doctor_lists_what_packages_bring_and_what_is_wrong(package, capsys):
    assert run("doctor", "--json", "-") == 0
    document = json.loads(capsys.readouterr().out)
    found = {one["name"]: one for one in document["plug_ins"]}
    assert found["rows"]["brings"] == [".rows"]
    assert found["rows"]["package"] == "bringer 1.0"
    assert found["csv"]["problem"] == ".csv is read by shakerproc itself"
    assert "ModuleNotFoundError" in found["mine"]["problem"]
    assert run("doctor") == 0
    shown = capsys.readouterr()
    assert "plug-in rows (bringer:read) of bringer 1.0: readers .rows" in shown.out
    assert (
        "warning: plug-in rows5 (nothing_there:read) of bringer 1.0: entry point" in shown.err
    )


def test_an_effect_with_the_name_of_a_built_in_one_is_refused(package):
    entries = "[shakerproc.effects]\nspring = taker\n"
    (package / "bringer-1.0.dist-info" / "entry_points.txt").write_text(
        entries, encoding="utf-8"
    )
    example = Path(__file__).parents[2] / "examples" / "my_effects.py"
    own = example.read_text(encoding="utf-8")
    taken = own.replace('= "detent"', '= "spring"')
    (package / "taker.py").write_text(taken, encoding="utf-8")
    (found,) = plug_ins()
    assert "kind 'spring' exists already" in found.problem


def test_a_broken_effect_is_the_same_line_each_time_it_matters(package, capsys):
    for _ in range(2):
        assert run("effects") == 1
        assert capsys.readouterr().err.startswith(
            "error: entry point mine (bringer_of_none): ModuleNotFoundError"
        )
