"""A pendulum before a camera: what is named of its softening, and of what slows it."""

import numpy as np
import pytest
from tests.diagnosis.pendulums import LENGTH, MASS, SOFTER, diagnosed


@pytest.mark.slow
def test_its_softening_is_named_and_judged_over_many_periods(tmp_path):
    found = diagnosed(tmp_path, 1.0, lambda v: 0.06 * v)
    assert [one.kind for one in found.effects] == ["cubic_stiffness"]
    assert found.effects[0].parameters["coefficient"].value == pytest.approx(SOFTER, rel=0.08)
    assert found.errors.held_out.after < 0.03 * found.errors.held_out.before
    assert min(found.errors.among.horizon_s.values()) > 10.0


@pytest.mark.slow
@pytest.mark.long
def test_dry_friction_beside_the_softening_is_found_with_it(tmp_path):
    friction = 0.15 / LENGTH  # N of each kg, over the length: of the angle [rad/s^2]
    found = diagnosed(
        tmp_path, 0.5, lambda v: 0.03 * v + friction * np.tanh(v / 0.01), rate=100.0, noise=1e-4
    )
    kinds = {one.kind: one.parameters for one in found.effects}
    assert set(kinds) == {"coulomb_friction", "cubic_stiffness"}
    assert kinds["coulomb_friction"]["sliding_force"].value == pytest.approx(0.03, rel=0.05)
    assert kinds["cubic_stiffness"]["coefficient"].value == pytest.approx(SOFTER, rel=0.1)
    assert found.errors.held_out.after < 0.01 * found.errors.held_out.before


@pytest.mark.slow
@pytest.mark.long
def test_softening_that_many_periods_alone_tell_is_named_by_the_law_of_fewest_numbers(tmp_path):
    """A swing of 0.1 rad: its sine changes the period by 0.06 %; eight laws explain as much."""
    found = diagnosed(tmp_path, 0.1, lambda v: 0.06 * v, rate=60.0, noise=2e-4, seconds=30.0)
    assert [one.kind for one in found.effects] == ["cubic_stiffness"]
    assert found.errors.held_out.after < 1.2 * found.errors.noise_floor
    assert min(found.errors.among.horizon_s.values()) > 10.0


@pytest.mark.slow
@pytest.mark.long
def test_weak_drag_of_air_is_judged_beyond_what_noise_alone_explains(tmp_path):
    found = diagnosed(
        tmp_path, 0.15, lambda v: 0.01 * v + 0.3 * abs(v) * v, rate=60.0, noise=2e-4,
        seconds=60.0,
    )  # fmt: skip
    drag = found.effects[[one.kind for one in found.effects].index("quadratic_damping")]
    assert drag.parameters["coefficient"].value == pytest.approx(0.3 * MASS / LENGTH, rel=0.1)


@pytest.mark.slow
@pytest.mark.long
def test_dry_friction_of_a_pivot_is_no_slipping_spring(tmp_path):
    """A law of two numbers leaves noise alone, too: a pair of one number each is tried."""
    found = diagnosed(
        tmp_path, 0.15, lambda v: 0.01 * v + 0.05 * np.tanh(v / 0.003), rate=240.0,
        noise=1e-4, seconds=15.0, held=1.0,
    )  # fmt: skip
    kinds = {one.kind: one.parameters for one in found.effects}
    assert set(kinds) == {"coulomb_friction", "cubic_stiffness"}
    sliding = kinds["coulomb_friction"]["sliding_force"].value
    assert sliding == pytest.approx(0.05 * MASS * LENGTH, rel=0.05)
    assert kinds["cubic_stiffness"]["coefficient"].value == pytest.approx(SOFTER, rel=0.1)
    assert found.confidence < 0.9
    assert "jenkins" in found.sentence
