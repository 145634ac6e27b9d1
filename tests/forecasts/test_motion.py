"""Motion and force of joints at points of a structure, against the chain that it is made of."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.models.test_structures import MASSES, RATE, chain, structure

from shakerproc.forecasts.motion import motion_of
from shakerproc.models import EFFECTS
from shakerproc.simulation import prepare

GAP = EFFECTS["gap"](stiffness=4e5, clearance=2e-6)
FOOT = ("base", "p3")


@pytest.mark.parametrize("effects", [(), (GAP,)])
def test_a_joint_at_a_point_moves_and_carries_as_that_of_the_chain(effects):
    masses = chain(*effects)
    drive = 5.0 * np.random.default_rng(4).standard_normal(2000)
    motions = [
        motion_of(model, prepare(drive, RATE), drive, (20.0, 1500.0), np.ones(4))
        for model in (masses, structure(masses))
    ]
    one, other = (motion.joints[FOOT] for motion in motions)
    for name in ("displacement", "velocity", "force"):
        expected = getattr(one, name)
        assert_allclose(getattr(other, name), expected, atol=1e-6 * np.abs(expected).max())


def test_a_structure_loads_the_shaker_with_its_mass():
    masses = chain()
    assert structure(masses).moved_mass == pytest.approx(MASSES.sum(), rel=1e-9)
    assert masses.moved_mass == pytest.approx(MASSES.sum(), rel=1e-12)
