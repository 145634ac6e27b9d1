"""Brief campaigns: their motion against scipy, and what they hand over."""

import numpy as np
import pytest
from blind.ranges import springs
from blind.ranges.scale import Scale
from blind.structures import Joint, Structure
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from blind import brief, classes, folder
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog


def test_a_pendulum_swings_as_the_sine_of_its_angle_makes_it():
    mass, omega, release, rate = 0.3, 2.0 * np.pi * 0.8, 0.25, 60.0
    k = mass * omega**2
    structure = Structure((mass,), (Joint(-1, 0, k, 0.02),), measures="displacement")
    law = springs.pendulum(np.random.default_rng(3), Scale(mass, k, omega, 0.1, 0.1, 0.1))
    length = np.sqrt(-k / (6.0 * law.parameters["coefficient"]))
    still = np.zeros(2 * brief.SUBSTEPS * 600 + 1)
    bench = brief.Bench(structure, rate, (still,), release, (0.1, 20.0), (("pendulum", law),))
    moved, _ = bench.move(still, np.inf)
    t = np.arange(600) / rate
    other = solve_ivp(
        lambda _, y: [y[1], -(0.02 * y[1] + k * length * np.sin(y[0] / length)) / mass],
        (0.0, t[-1]), [release, 0.0], t_eval=t, rtol=1e-10, atol=1e-12,
    ).y[0]  # fmt: skip
    assert_allclose(moved.displacement[:, 0], other, atol=1e-6 * release)


@pytest.mark.parametrize("kind", ["decay:coulomb_friction", "short:gap", "quake:bouc_wen"])
def test_a_campaign_is_the_same_again_and_its_files_are_read(kind, tmp_path):
    one, again = brief.draw(7, kind), brief.draw(7, kind)
    assert_allclose(one.tests[-1].response, again.tests[-1].response, rtol=0.0)
    log, model = folder.write(one, tmp_path)
    assert len(read_testlog(log).tests) == len(one.tests)
    assert list(read_model(model).masses) == [
        one.structure.name(i) for i in range(len(one.structure.masses))
    ]


def test_friction_lets_a_decay_turn_some_times_before_it_rests():
    for seed in range(4):
        seen = brief.draw(seed, "decay:coulomb_friction").tests[0].clean[0]
        large = np.abs(seen) > brief.LIVES * np.max(np.abs(seen))
        turns = np.diff(np.sign(seen[: np.flatnonzero(large)[-1]])) != 0.0
        assert (
            np.sum(turns) >= brief.CROSSINGS - 2
        )  # some samples after the release are skipped


def test_every_class_of_them_has_a_name_that_is_understood():
    for group in ("decays", "shorts", "quakes"):
        for kind in classes.GROUPS[group]:
            assert classes.parse(kind).form in classes.BRIEF
