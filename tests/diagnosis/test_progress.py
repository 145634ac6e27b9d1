"""What a search has time for."""

from time import monotonic

import pytest

from shakerproc.diagnosis import progress
from shakerproc.diagnosis.progress import Progress, progress_of


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands until it is set [s]."""
    time = [monotonic()]
    monkeypatch.setattr(progress, "monotonic", lambda: time[0])
    return time


def test_a_part_is_left_out_and_noted_where_less_than_half_of_the_time_is_left(clock):
    told = []
    search = Progress(told.append, 100.0)
    search("the race")
    clock[0] += 49.0
    assert search.has_time_for("a second effect beside gap")
    assert not search.notes
    clock[0] += 2.0
    assert not search.has_time_for("a further mode")
    assert told == ["the race", "a second effect beside gap"]
    (note,) = search.notes
    assert "100 s" in note
    assert "a further mode" in note
    assert "second effect" not in note


def test_without_a_limit_there_is_time_for_everything(clock):
    search = progress_of(None)
    clock[0] += 1e9
    assert search.has_time_for("a second effect")
    assert progress_of(search) is search
    assert not search.notes
