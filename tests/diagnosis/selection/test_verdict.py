"""What a verdict says beside itself."""

from types import SimpleNamespace

import pytest

from shakerproc.diagnosis.result import Errors, Pair
from shakerproc.diagnosis.selection.verdict import unlike_held_out


@pytest.mark.parametrize(
    ("explained", "left", "said"),
    [(True, 0.45, 1), (True, 0.05, 0), (False, 0.45, 0)],
)
def test_what_is_left_of_the_fitted_tests_alone_is_said(explained, left, said):
    found = SimpleNamespace(is_explained_by=lambda _: explained)
    errors = Errors(Pair(2.0, left), Pair(2.0, 0.004), 0.003)
    notes = unlike_held_out(found, None, errors)
    assert len(notes) == said
    assert all("leaves 0.45 of the response" in note for note in notes)
