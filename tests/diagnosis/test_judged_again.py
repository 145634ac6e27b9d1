"""What was found, judged by another estimate of the noise."""

from dataclasses import replace

import pytest
from tests.diagnosis.one_mass import arrays_of, one_mass
from tests.few_effects import seek_few

from shakerproc.diagnosis.api import judged_again
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.search import search
from shakerproc.models import EFFECTS


@pytest.fixture(scope="module")
def found():
    """Return a cubic spring that a search found, and its tests."""
    truth = one_mass(effect=EFFECTS["cubic_stiffness"](coefficient=3e11))
    tests = prepared(arrays_of(truth))
    with pytest.MonkeyPatch.context() as patch:
        seek_few(patch)
        return search(one_mass(), tests, lambda _: None), tests


def with_noise(tests, factor):
    return [replace(test, noise=factor * test.noise) for test in tests]


def test_where_the_next_noise_explains_as_well_nothing_is_sought_again(found):
    before, tests = found
    stages = []
    less = with_noise(tests, 0.9)
    again = judged_again(one_mass(), before, less, stages.append)
    assert stages == ["at the horizon"]
    assert again.best.fit.hypothesis.kinds == ("cubic_stiffness",)
    assert [test.noise for test in again.data.tests] == [test.noise for test in less]
    assert again.recorded == tuple(less)


def test_what_leaves_more_than_the_next_noise_is_to_be_sought_again(found):
    before, tests = found
    assert judged_again(one_mass(), before, with_noise(tests, 1e-3), lambda _: None) is None
