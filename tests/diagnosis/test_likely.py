"""Which effects are fitted first, by what they leave in the screening."""

from dataclasses import replace

from shakerproc.diagnosis.hypotheses.joints import identifications
from shakerproc.diagnosis.screening import Start
from shakerproc.diagnosis.screening.start import in_likely_joints, likely, widening
from shakerproc.models.identification import JointScales

JOINT = ("base", "coupon")
AT = JointScales(
    displacement=1e-4, velocity=0.1, force=10.0, stiffness=1e5, mass=0.1, duration=10.0,
    band=2000.0,
)  # fmt: skip
NOTHING = 10_000.0  # left without any effect


def start(kind, left, *, told=True):
    share = 1.0 - left / NOTHING
    return Start(kind, JOINT, {}, (0.0,), (0.0,), share, share, 10.0, left, told=told)


def likely_of(**left):
    starts = [start(kind, value) for kind, value in left.items()]
    starts.append(start("constant_force", NOTHING, told=False))
    return {one.kind for one in likely(starts, {JOINT: identifications(AT)})}


def test_what_leaves_less_than_the_geometric_mean_is_likely():
    # the mean of 1 and 10,000 is 100; of a constant force a regression tells nothing
    assert likely_of(quadratic_damping=1.0, attached_mode=99.0, jenkins=101.0) == {
        "quadratic_damping", "attached_mode", "constant_force",
    }  # fmt: skip


def test_what_a_likely_effect_contains_is_likely():
    found = likely_of(offset_gap=1.0, gap=9_000.0, jenkins=9_000.0)
    assert found == {"offset_gap", "gap", "constant_force"}


def test_where_nothing_explains_much_all_that_is_as_good_is_likely():
    found = likely_of(gap=9_990.0, jenkins=9_992.0, iwan=9_999.0)
    assert found == {"gap", "jenkins", "constant_force"}


def test_without_starts_nothing_is_likely():
    assert likely((), {}) == ()


def test_simple_effects_follow_the_likely_ones_before_all_that_contain_another():
    kinds = {"cubic_stiffness": 50.0, "coulomb_friction": 5000.0, "lugre_friction": 5000.0}
    starts = [start(kind, left) for kind, left in kinds.items()]
    circles = list(widening(starts, {JOINT: identifications(AT)}))
    assert [{one.kind for one in circle} for circle in circles] == [
        {"cubic_stiffness"},
        {"cubic_stiffness", "coulomb_friction"},
    ]


def test_of_many_joints_as_many_effects_are_fitted_as_one_may_have():
    joints = [("base", "m1"), *((f"m{i}", f"m{i + 1}") for i in range(1, 6))]
    known = {joint: identifications(AT) for joint in joints}
    kinds = [kind for kind, one in known[joints[0]].items() if not one.contains]
    starts = [
        replace(start(kind, (1.0 + i) * (1.0 + 0.01 * j)), between=joint)
        for i, joint in enumerate(joints)
        for j, kind in enumerate(kinds)
    ]
    starts += [
        replace(start("constant_force", NOTHING, told=False), between=joint) for joint in joints
    ]
    chosen = in_likely_joints(starts, known)
    told = {(one.kind, one.between) for one in chosen if one.told}
    assert {(kind, joints[0]) for kind in kinds} <= told
    assert len(told) <= len(known[joints[0]])
    untold = [one.between for one in chosen if not one.told]
    assert untold[0] == joints[0]
    assert len(untold) < len(joints)


def test_the_last_circle_of_all_is_not_told():
    starts = [start("cubic_stiffness", 50.0), start("gap", 5000.0)]
    (circle,) = widening(starts, {JOINT: identifications(AT)})
    assert {one.kind for one in circle} == {"cubic_stiffness"}
