"""Long tests and large models: only as much is looked at as is needed, and that is said."""

import numpy as np
import pytest
from tests.comparison.small_campaigns import campaign, drive, written

from shakerproc.comparison import compare_tests, measure
from shakerproc.comparison.joints import joint_motions
from shakerproc.comparison.measured import longest
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.testlog import read_testlog

MOST = 8192


def part_of(tmp_path, kind):
    """A test of 5 s of which little may be used, and what the true model leaves of it."""
    written(campaign(drives=(drive(kind),), seconds=5.0), tmp_path)
    log, model = read_testlog(tmp_path / "testlog.yaml"), read_model(tmp_path / "model.yaml")
    measured = measure(log, log.tests[0], model, most=MOST)
    return measured, compare_tests(model, [measured])


def test_of_a_long_random_test_the_beginning_is_used_and_said(tmp_path):
    measured, found = part_of(tmp_path, "random")
    assert measured.stop - measured.start == MOST
    (note,) = measured.notes
    assert "used 1.44 s of " in note
    assert found.error < 0.02


def test_of_a_long_sweep_the_loudest_part_is_used_and_the_model_runs_in(tmp_path):
    measured, found = part_of(tmp_path, "sine sweep")
    assert measured.stop - measured.start == MOST
    assert measured.responses.shape[1] < 1.2 * MOST
    assert found.error < 0.02
    assert abs(found.tests[0].errors[0].peak_hz - 120.0) < 6.0


def test_more_tests_and_more_masses_leave_less_for_each():
    assert longest(1, 1) == 2**20
    assert longest(100, 1) == 2**17
    assert longest(1, 200) * 200 <= 2**23
    assert longest(10, 200) * 10 * 200**2 <= 2**34


def test_the_far_side_of_each_joint_of_a_long_chain_is_found_in_no_time(tmp_path):
    measured, _ = part_of(tmp_path, "random")
    names = [f"m{i}" for i in range(60)]
    pairs = list(zip(["base", *names], names, strict=False))
    elements = [Element(EFFECTS["spring"](1e7), pair) for pair in pairs]
    elements += [Element(EFFECTS["damper"](5.0), pair) for pair in pairs]
    sensors = {"ch3": Sensor(names[-1], "acceleration")}
    chain = Model(
        "chain", dict.fromkeys(names, 0.01), tuple(elements), Excitation("base acceleration"),
        sensors,
    )  # fmt: skip
    found = compare_tests(chain, [measured]).tests[0]
    assert found.prediction.simulation.displacement.shape[0] == 1  # the sensed
    told, not_told = joint_motions(chain, measured)
    assert told == ()
    assert len(not_told) == 60
    last = next(one for one in not_told if one.between == ("m58", "m59"))
    assert last.why == "no sensor on m58, so its motion is not measured"
    acceleration = measured.responses[0, measured.start : measured.stop]
    assert last.force_rms == pytest.approx(0.01 * np.std(acceleration), rel=0.2)  # ends cut
    assert next(one for one in not_told if one is not last).force_rms is None
    assert np.isfinite(found.error)
