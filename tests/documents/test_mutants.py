"""Logs, models and studies with one thing changed: read, or one line with its place."""

from tests.documents.mutants import campaign


def test_three_hundred_mutants_are_read_or_refused_at_their_place(tmp_path):
    found, wrong = campaign(300, tmp_path, seed=7)
    assert wrong == []
    assert found["blank", "refused"] == 50
