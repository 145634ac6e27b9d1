"""What a command says while it works, where no bar can be drawn."""

import pytest

from shakerproc import files
from shakerproc.cli import output


def test_a_line_comes_after_five_seconds_and_no_sooner(monkeypatch, capsys):
    now = [100.0]
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    monkeypatch.setenv("TERM", "dumb")
    with output.progress("compare", 3) as advance:
        for seconds, text in ((1.0, "test 1"), (5.5, "test 2"), (1.0, "test 3")):
            now[0] += seconds
            advance(text)
    assert capsys.readouterr().err.splitlines() == ["compare: test 2"]


def _interrupted(folder):
    with output.results(folder, "compare"):
        files.write_json(folder / "compare.json", {})
        raise KeyboardInterrupt


def test_nothing_stays_of_results_whose_writing_is_interrupted(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        _interrupted(tmp_path / "out")
    assert not list((tmp_path / "out").iterdir())
