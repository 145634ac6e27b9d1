"""A further mode of the specimen that a strong effect hides, against an independent truth."""

import pytest
from blind.ranges import Hidden
from tests.comparison.small_campaigns import JOINT, MASS, campaign, drive
from tests.diagnosis.estimation.test_linear import (
    SECOND,
    WITH_MODE,
    ZETA,
    arrays_of,
    model,
)

from blind import laws
from shakerproc.diagnosis.adding import add_to_arrays
from shakerproc.diagnosis.estimation.linear import fit_linear
from shakerproc.diagnosis.wanted import Wanted

STIFFNESS, CLEARANCE = 3.0 * JOINT.stiffness, 3e-5
GAP = Hidden({}, ((laws.GAP, (STIFFNESS, CLEARANCE, CLEARANCE), (-CLEARANCE, CLEARANCE)),))
DRIVES = (drive(level=12.0), drive(level=20.0, number=2))


@pytest.mark.slow
@pytest.mark.long
def test_a_mode_that_a_gap_hides_is_found_beside_it():
    tests = arrays_of(campaign(WITH_MODE, hidden=((0, GAP),), drives=DRIVES, seconds=2.5))
    assert fit_linear(model(), tests).model.modes == ()
    found = add_to_arrays(Wanted("gap"), model(), [test.arrays for test in tests])
    (mode,) = found.modes
    assert mode.frequency == pytest.approx(600.0, rel=5e-3)
    assert mode.damping_ratio == pytest.approx(ZETA, rel=0.2)
    assert mode.mass == pytest.approx(SECOND, rel=0.1)
    assert mode.participation == {"coupon": 1.0}
    assert found.notes == (f"Fitted as linear: a further mode at {mode.frequency:.4g} Hz.",)
    assert found.parameters["clearance"].value == pytest.approx(CLEARANCE, rel=0.01)
    assert found.parameters["stiffness"].value == pytest.approx(STIFFNESS, rel=0.02)
    assert sum(found.model.masses.values()) == pytest.approx(MASS)
