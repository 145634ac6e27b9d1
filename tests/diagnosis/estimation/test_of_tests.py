"""What each test has of its own: stiffness, and what drives it between controls."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.one_mass import NOISE, STIFFNESS, arrays_of, one_mass

from shakerproc.diagnosis import diagnose_arrays
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.data.controls import sways_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.of_tests import drift_of, weights_of
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.models import EFFECTS

LEVELS = (0.0025, -0.0025, 0.004)
CHANGE = 0.006
SECONDS = 3.0
WEIGHTS = (0.8, 0.2)


def drifting(*, hold_out=True):
    """Return tests, the last held out, whose spring has another stiffness in each.

    It gets stiffer while they run; the first half second is rest, which is not judged.
    """
    tests = []
    for seed, level in enumerate(LEVELS):
        change = EFFECTS["stiffness_drift"](CHANGE / SECONDS, 0.5 + 0.5 * SECONDS, STIFFNESS)
        truth = one_mass(STIFFNESS * (1.0 + level), effect=change)
        (test,) = arrays_of(truth, levels=(4.0,), seconds=SECONDS, seed=seed)
        tests.append(replace(test, name=f"test {seed + 1}"))
    tests[-1] = replace(tests[-1], hold_out=hold_out)
    return tests


def rocking(apart=0.06):
    """Return tests whose controls differ by the velocity of the table, and noise.

    What drives the mass stands between them.
    """
    rng, tests = np.random.default_rng(8), []
    for test in arrays_of(one_mass(), levels=(2.0, 4.0)):
        drive = test.controls[0]
        late = np.cumsum(drive)
        late *= apart * np.std(drive) / np.std(late)
        first, second = drive + WEIGHTS[1] * late, drive - WEIGHTS[0] * late
        noise = NOISE * np.std(drive) * rng.standard_normal((2, drive.size))
        tests.append(replace(test, controls=np.array([first, second]) + noise))
    return tests


def fitted(data):
    none = hypothesis_of(one_mass())
    return fit(data, none, np.zeros(none.size), whole_tests(data, held_out=False), rounds=20)


def test_the_stiffness_of_each_test_is_told_and_its_change_while_it_runs():
    data = DataSet(one_mass(), prepared(drifting(hold_out=False))).as_differing()
    level, change = drift_of(data, fitted(data).of_tests)
    # only differences are told: the model has the mean of all
    assert_allclose(level - level.mean(), np.subtract(LEVELS, np.mean(LEVELS)), atol=2e-4)
    assert_allclose(change, CHANGE, atol=6e-4)


def test_a_test_that_was_held_out_is_predicted_with_a_stiffness_of_its_own():
    data = DataSet(one_mass(), prepared(drifting()))
    alike, own = fitted(data), fitted(data.as_differing())
    kept = whole_tests(data, held_out=True)
    assert error_of(data, alike, kept) > 0.03
    # noise of 0.5 % on input and response, of which a lightly damped mass makes more
    assert error_of(own.data, own, kept) < 0.012
    assert own.data.plain.differing is False


def test_what_drives_a_mass_between_two_controls_is_told():
    data = DataSet(one_mass(), prepared(rocking())).as_differing()
    found = fitted(data)
    assert_allclose(weights_of(data, found.of_tests), WEIGHTS, atol=0.03)
    mean = fitted(data.plain)
    whole = whole_tests(data, held_out=False)
    assert error_of(data, found, whole) < 0.7 * error_of(data.plain, mean, whole)


def test_controls_that_differ_by_noise_are_taken_as_one():
    tests = prepared(rocking(apart=0.0))
    assert sways_of(tests).spread.size == 0
    assert weights_of(DataSet(one_mass(), tests).as_differing(), np.zeros((2, 2))).tolist() == [
        1.0
    ]


@pytest.mark.slow
def test_springs_that_drift_are_no_finding(few_effects):
    found = diagnose_arrays(one_mass(), drifting())
    assert found.verdict == "nothing missing"
    assert found.errors.held_out.after < 1.5 * found.errors.noise_floor
    (note,) = [note for note in found.notes if "equally stiff" in note]
    assert "`compare`" in note
