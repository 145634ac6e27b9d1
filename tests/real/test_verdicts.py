"""The whole loop on real and published sets, compared with what is known of them otherwise.

The numbers come from the authors of the sets, from free runs fitted by least squares without
any code of the diagnosis (docs/real_data.md), or from how a set was made.
"""

import pytest
from benchmarks.real.loop import judge
from configs.benchmarks import convert

LIMIT_S = 300
"""Processor seconds of a diagnosis before it is stopped; what is asked of it is scored [s]."""


@pytest.fixture
def turns(shared, tmp_path):
    """Return the turns of the loop on a set."""

    def of(name, rounds=1):
        folder = convert.folder_of(name, tmp_path, shared / "data")
        return judge(folder, rounds=rounds, limit=LIMIT_S)

    return of


def named(turn):
    """Return the effects that were named, by kind."""
    assert turn.failure == ""
    assert turn.verdict == "effect found", turn.diagnosis.get("sentence")
    return {effect["kind"]: effect for effect in turn.effects}


def falls(turn):
    """The error that a user sees falls with the effect."""
    assert turn.error_after < turn.error_before


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_silverbox_is_a_cubic_spring_and_then_some(turns):
    first, *later = turns("silverbox", rounds=2)
    (cubic,) = named(first).values()
    assert cubic["kind"] == "cubic_stiffness"
    stiffness = first.diagnosis["linear"]["stiffness base-box"]["value"]
    coefficient = cubic["parameters"]["coefficient"]
    assert 3.7 < coefficient["value"] / stiffness < 4.3
    assert coefficient["low"] < 3.95 * stiffness < coefficient["high"]
    goals = {"arrow": 0.41e-3, "arrow without extrapolation": 0.34e-3, "multisine": 0.34e-3}
    assert all(first.published[test] <= most for test, most in goals.items())
    goals = {"arrow": 0.34e-3, "arrow without extrapolation": 0.30e-3, "multisine": 0.29e-3}
    assert all(later[-1].published[test] <= most for test, most in goals.items())


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_bouc_wen_benchmark_is_named_from_its_training_part(turns):
    (turn,) = turns("bouc_wen")
    assert set(named(turn)) == {"general_bouc_wen"}
    assert turn.published["multisine"] <= 5e-7
    assert turn.published["sweep"] <= 5e-6


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_positioning_system_has_dry_friction(turns):
    first, *later = turns("emps", rounds=2)
    friction = named(first)
    (kind,) = friction.keys() & {"coulomb_friction", "stribeck_friction"}
    assert 18.0 < friction[kind]["parameters"]["sliding_force"]["value"] < 23.0
    assert first.published["pulses"] <= 6.5e-3
    assert later[-1].published["pulses"] <= 5e-3


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_shaking_table_has_a_delay_and_nothing_else(turns):
    (turn,) = turns("shaking_table")
    assert turn.verdict == "measurement fault"
    (delay,) = turn.effects
    assert delay["kind"] == "sensor_delay"
    assert delay["parameters"]["delay"]["value"] == pytest.approx(0.0195, abs=0.001)


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_friction_damper_has_play_in_series_with_friction(turns):
    (turn,) = turns("friction_damper")
    assert set(named(turn)) == {"series"}
    falls(turn)


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_magnetorheological_damper_has_friction_or_hysteresis(turns):
    """A force regression along the stroke leaves 28 % without friction and 16 % with it."""
    (turn,) = turns("mr_damper")
    kinds = {"coulomb_friction", "stribeck_friction", "lugre_friction", "jenkins", "iwan",
             "power_iwan", "bouc_wen", "general_bouc_wen"}  # fmt: skip
    assert set(named(turn)) & kinds
    falls(turn)


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_ring_down_has_a_joint_that_slips(turns):
    """A uniform Iwan element leaves 9 % where the linear model leaves 37 %."""
    (turn,) = turns("ringdown")
    assert set(named(turn)) & {"iwan", "power_iwan", "jenkins", "bouc_wen", "general_bouc_wen"}
    assert turn.error_after < 0.5 * turn.error_before


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize(("name", "joint"), [("coupon", "coupon"), ("three_masses", "m3")])
def test_a_gap_by_construction_is_found_in_its_joint(tmp_path, name, joint):
    """What the recordings of these two are made with is known."""
    folder = convert.folder_of(name, tmp_path)
    (turn,) = judge(folder, rounds=1, limit=LIMIT_S)
    (gap,) = named(turn).values()
    assert (gap["kind"], gap["between"][1]) == ("gap", joint)
    falls(turn)
