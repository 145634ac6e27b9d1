"""What a verdict says of whole tests, on errors that are written down here."""

import pytest

from shakerproc.diagnosis.result import BeforeAfter, Errors
from shakerproc.diagnosis.selection.tried import holds_in_whole_tests


def told(before, after, without, noise=0.01):
    """Return errors as `compare` tells them, beside those of candidates."""
    own = Errors(BeforeAfter(0.07, 0.04), BeforeAfter(0.07, 0.04), 0.045)
    return Errors(
        BeforeAfter(before, after),
        BeforeAfter(before, after),
        noise,
        without=without,
        of_candidates=own,
    )


@pytest.mark.parametrize(
    ("before", "after", "without", "holds"),
    [
        (1.13, 1.00, 0.87, False),  # the effect makes whole tests worse than none
        (1.80, 0.02, 0.70, True),
        (0.90, 0.30, None, True),
        (0.90, 0.60, None, False),
    ],
)
def test_an_effect_holds_where_half_of_the_error_is_gone(before, after, without, holds):
    assert holds_in_whole_tests(told(before, after, without), effects=True) == holds


def test_noise_that_parts_the_motion_is_no_fault_of_the_effect():
    assert holds_in_whole_tests(told(1.9, 0.63, 1.2, noise=0.6), effects=True)


def test_errors_that_candidates_tell_need_no_second_judgement():
    assert holds_in_whole_tests(
        Errors(BeforeAfter(1.0, 0.9), BeforeAfter(1.0, 0.9), 0.01), effects=True
    )


@pytest.mark.parametrize(
    ("after", "noise", "holds"),
    [
        (0.71, 0.005, False),  # blows that no window holds: half of 1.40, but no noise
        (0.012, 0.010, True),
        (0.009, 0.001, True),  # what sensors are calibrated to
        (0.300, float("nan"), True),  # the noise is said to be unknown elsewhere
    ],
)
def test_nothing_is_missing_only_where_whole_tests_hold_no_more_than_noise(after, noise, holds):
    assert holds_in_whole_tests(told(1.40, after, None, noise), effects=False) == holds
