"""Restoring forces from recordings: against a structure whose joint forces are known."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from numpy.testing import assert_allclose

from shakerproc.comparison import compare_tests, measure
from shakerproc.comparison.equilibrium import joints_of
from shakerproc.comparison.hidden_joints import DRAWS, hidden_joints
from shakerproc.comparison.joints import joint_motions
from shakerproc.models import EFFECTS, Element, Excitation, Mode, Model, Sensor
from shakerproc.testlog import read_testlog

RATE, SUBSTEPS = 2048, 4
MASS = {"bracket": 0.25, "coupon": 0.12}
K1, C1, K2, C2, CONTACT, CLEARANCE = 8e5, 12.0, 1e5, 4.0, 1.5e5, 2e-5
CHAIN = (("base", "bracket"), ("bracket", "coupon"))


def elements(pairs, factor=1.0):
    return tuple(Element(EFFECTS["spring"](factor * 1e5), pair) for pair in pairs)


def model(pairs=CHAIN, names=("bracket", "coupon"), sensed=None, factor=1.0, **changed):
    masses = {name: MASS.get(name, 0.1) for name in names}
    sensors = {name: Sensor(name) for name in (masses if sensed is None else sensed)}
    excitation = Excitation("base acceleration")
    made = Model("chain", masses, elements(pairs, factor), excitation, sensors)
    return replace(made, **changed)


def integrated(base):
    """Motion and joint forces of two masses, by the classical Runge-Kutta rule of order four.

    `base` is the acceleration at half steps; the motion is against the base.
    """
    h, n = 1.0 / (RATE * SUBSTEPS), (base.size - 1) // 2

    def forces(x1, v1, x2, v2):
        z = x2 - x1
        push = CONTACT * (z - CLEARANCE if z > CLEARANCE else min(z + CLEARANCE, 0.0))
        return K1 * x1 + C1 * v1, K2 * z + C2 * (v2 - v1) + push

    def rates(y, a):
        first, second = forces(*y)
        return (
            y[1], (second - first) / MASS["bracket"] - a, y[3], -second / MASS["coupon"] - a
        )  # fmt: skip

    y, rows = (0.0, 0.0, 0.0, 0.0), []
    for i in range(n):
        a, b, c = base[2 * i], base[2 * i + 1], base[2 * i + 2]
        k1 = rates(y, a)
        rows.append((y[0], y[2], k1[1] + a, k1[3] + a, *forces(*y)))
        k2 = rates([p + 0.5 * h * q for p, q in zip(y, k1, strict=True)], b)
        k3 = rates([p + 0.5 * h * q for p, q in zip(y, k2, strict=True)], b)
        k4 = rates([p + h * q for p, q in zip(y, k3, strict=True)], c)
        y = [
            p + h / 6.0 * (q + 2.0 * r + 2.0 * s + t)
            for p, q, r, s, t in zip(y, k1, k2, k3, k4, strict=True)
        ]
    return np.array(rows).T


@pytest.fixture(scope="module")
def truth():
    """Base acceleration and what the two masses do under it, below half the sample rate."""
    seconds, fine = 4.0, 2 * RATE * SUBSTEPS
    t = np.arange(int(seconds * fine) + 1) / fine
    rng = np.random.default_rng(3)
    lines = np.arange(20.0, 500.0, 1.0 / 3.0)
    spectrum = np.zeros(t.size // 2 + 1, complex)
    spectrum[np.rint(lines * t.size / fine).astype(int)] = np.exp(
        2j * np.pi * rng.random(lines.size)
    )
    ramp = np.clip((t - 0.5) / 0.1, 0.0, 1.0) * np.clip((seconds - 0.3 - t) / 0.1, 0.0, 1.0)
    base = np.fft.irfft(spectrum, t.size) * ramp
    base *= 25.0 / base.std()
    rows = np.vstack([base[:-1:2], integrated(base)])
    recorded, *moved = scipy.signal.resample(rows, rows.shape[1] // SUBSTEPS, axis=1)
    return recorded, moved


def recorded(folder, columns, units, log, noise=1e-4):
    """Measure test 1 of a log of these channels, with white noise of a share of each rms."""
    rng = np.random.default_rng(7)
    rows = [x + noise * np.std(x) * rng.standard_normal(x.size) for x in columns.values()]
    head = ",".join(f"{n} [{u}]" for n, u in zip(columns, units, strict=True))
    table = np.column_stack([np.arange(rows[0].size) / RATE, *rows])
    np.savetxt(folder / "r.csv", table, "%.12g", ",", header=f"time [s],{head}", comments="")
    path = folder / "log.yaml"
    path.write_text(
        f"testlog: 1\nrecordings: .\nprocessing: {{crop: none}}\n{log}", encoding="utf-8"
    )
    log = read_testlog(path)
    return lambda m: measure(log, log.tests[0], m)


RANDOM = "tests: [{id: 1, recording: r.csv, excitation: random, from: 20 Hz, to: 500 Hz}]\n"
SHAKEN = (
    "channels: {table: {role: control}, bracket: {role: response}, coupon: {role: response}}\n"
)


def shaken(folder, truth, noise=1e-4):
    base, (_, _, a1, a2, _, _) = truth
    columns = {"table": base, "bracket": a1, "coupon": a2}
    return recorded(folder, columns, ["m/s^2"] * 3, SHAKEN + RANDOM, noise)


def rms(x):
    return float(np.sqrt(np.mean(x**2)))


def judged(joint, measured, whole):
    """The samples of the truth that a joint holds, by the number of them."""
    spare = whole.size - joint.force.size
    first = spare // 2 if measured.start == 0 else measured.start
    return whole[first : first + joint.force.size]


def test_force_and_displacement_are_those_of_the_structure(tmp_path, truth):
    """Forces to 1 % and displacements to 3 % of their rms, with noise of 0.01 %."""
    measured = shaken(tmp_path, truth)(model())
    told, not_told = joint_motions(model(), measured)
    assert not_told == ()
    x1, x2, _, _, q1, q2 = truth[1]
    for joint, z, q in zip(told, (x1, x2 - x1), (q1, q2), strict=True):
        for found, expected, bound in ((joint.force, q, 0.01), (joint.displacement, z, 0.03)):
            known = judged(joint, measured, expected)
            assert rms(found - known) < bound * rms(known)
        assert joint.unsure < 0.02 * rms(joint.displacement)


def test_the_model_changes_nothing_that_is_called_measured(tmp_path, truth):
    """Neither its stiffness nor the order of masses, joints and sensors."""
    read = shaken(tmp_path, truth)
    one = model()
    other = model(CHAIN[::-1], ("coupon", "bracket"), ("coupon", "bracket"), factor=50.0)
    first = {j.between: j for j in joint_motions(one, read(one))[0]}
    second = {j.between: j for j in joint_motions(other, read(other))[0]}
    assert set(first) == set(second) == set(CHAIN)
    for pair, joint in first.items():
        assert joint.band == second[pair].band
        for name in ("displacement", "velocity", "force"):
            known = getattr(joint, name)
            assert_allclose(getattr(second[pair], name), known, rtol=0, atol=1e-9 * rms(known))
        assert rms(second[pair].force_model) > 10.0 * rms(joint.force_model)


def test_the_true_law_over_the_measured_motion_leaves_next_to_nothing(tmp_path, truth):
    pair = ("coupon", "bracket")  # written the other way round
    made = model()
    true = (
        Element(EFFECTS["spring"](K1), CHAIN[0]),
        Element(EFFECTS["damper"](C1), CHAIN[0]),
        Element(EFFECTS["spring"](K2), pair),
        Element(EFFECTS["damper"](C2), pair),
        Element(EFFECTS["gap"](CONTACT, CLEARANCE), pair),
    )
    made = replace(made, elements=true)
    told, _ = joint_motions(made, shaken(tmp_path, truth)(made))
    assert told[1].between == pair
    for joint in told:
        assert rms(joint.force - joint.force_model) < 0.04 * rms(joint.force)


def test_motion_that_drowns_in_noise_is_not_told(tmp_path, truth):
    measured = shaken(tmp_path, truth)(model())
    loud = replace(measured.noise, responses=1e10 * measured.noise.responses)
    told, not_told = joint_motions(model(), replace(measured, noise=loud))
    assert told == ()
    assert all(joint.why.startswith("band too narrow") for joint in not_told)
    assert all(joint.force_rms > 0.0 for joint in not_told)


def test_a_displacement_sensor_tells_the_motion_of_its_mass(tmp_path, truth):
    base, (x1, x2, _, _, _, q2) = truth
    channels = (
        "channels: {table: {role: control}, b: {role: displacement}, c: {role: displacement}}\n"
    )
    columns = {"table": base, "b": x1, "c": x2}
    read = recorded(tmp_path, columns, ("m/s^2", "m", "m"), channels + RANDOM, 1e-6)
    kind = "relative displacement"
    made = replace(model(), sensors={"b": Sensor("bracket", kind), "c": Sensor("coupon", kind)})
    measured = read(made)
    joint = joint_motions(made, measured)[0][1]
    z, q = (judged(joint, measured, x) for x in (x2 - x1, q2))
    assert rms(joint.displacement - z) < 0.02 * rms(z)
    assert rms(joint.force - q) < 0.02 * rms(q)


def test_in_a_component_test_the_inertia_of_the_mass_is_no_joint_force(tmp_path):
    t, mass, stiffness, damping = np.arange(4 * RATE) / RATE, 2.0, 3e4, 20.0
    omega = 2.0 * np.pi * 20.0
    z, v = 1e-3 * np.sin(omega * t), 1e-3 * omega * np.cos(omega * t)
    force = stiffness * z + damping * v - mass * omega**2 * z
    log = (
        "channels: {stroke: {role: displacement, at: rod}, force: {role: force, at: rod}}\n"
        "tests: [{id: 1, recording: r.csv, excitation: sine, frequency: 20 Hz}]\n"
    )
    columns = {"stroke": z, "force": force}
    made = Model(
        "rod", {"rod": mass}, elements((("base", "rod"),)),
        Excitation("imposed displacement", "rod"), {"force": Sensor("rod", "force")},
    )  # fmt: skip
    (joint,), _ = joint_motions(made, recorded(tmp_path, columns, ("m", "N"), log, 1e-6)(made))
    middle = slice(RATE, -RATE)
    assert_allclose(joint.displacement[middle], z[middle], atol=1e-7)
    expected = (stiffness * z + damping * v)[middle]
    assert rms(joint.force[middle] - expected) < 0.01 * rms(expected)


LOOP = (*CHAIN, ("base", "coupon"))


def told(made, sensed):
    return {joint.between: joint for joint in joints_of(made, sensed)}


def test_a_chain_is_told_from_its_free_end():
    found = told(model(), {"bracket", "coupon"})
    assert found["bracket", "coupon"].weights == pytest.approx({"coupon": -1.0})
    assert found["base", "bracket"].weights == pytest.approx({"bracket": -1.0, "coupon": -1.0})


def test_a_joint_written_the_other_way_round_has_the_other_sign():
    found = told(model((("bracket", "base"), CHAIN[1])), {"bracket", "coupon"})
    assert found["bracket", "base"].weights == pytest.approx({"bracket": 1.0, "coupon": 1.0})


@pytest.mark.parametrize(
    ("made", "sensed", "pair", "why"),
    [
        (model(), {"bracket"}, CHAIN[0], "no sensor on coupon"),
        (model(), {"bracket"}, CHAIN[1], "no sensor on coupon"),
        (model(LOOP), {"bracket", "coupon"}, LOOP[2], "base - bracket and bracket - coupon"),
        (
            model(modes=(Mode(400.0, 0.01, 0.02, {"coupon": 1.0}),)),
            {"bracket", "coupon"}, CHAIN[1], "the mode of 400 Hz",
        ),
        (
            model(elements=(
                *elements(CHAIN),
                Element(EFFECTS["attached_mode"](0.01, 300.0, 0.01), ("coupon",)),
            )),
            {"bracket", "coupon"}, CHAIN[1], "the attached mode on coupon",
        ),
    ],
)  # fmt: skip
def test_a_force_that_equilibrium_leaves_open_says_why(made, sensed, pair, why):
    joint = told(made, sensed)[pair]
    assert joint.weights is None
    assert why in joint.why


def test_beyond_a_mass_without_a_sensor_the_free_end_is_still_told():
    names = ("bracket", "coupon", "tip")
    found = told(model((*CHAIN, ("coupon", "tip")), names), {"bracket", "tip"})
    assert found["coupon", "tip"].weights == pytest.approx({"tip": -1.0})
    assert found["bracket", "coupon"].weights is None
    assert found["base", "bracket"].weights is None


def true_laws(contact=CONTACT):
    laws = (
        ("spring", CHAIN[0], K1), ("damper", CHAIN[0], C1),
        ("spring", CHAIN[1], K2), ("damper", CHAIN[1], C2),
    )  # fmt: skip
    known = tuple(Element(EFFECTS[kind](value), pair) for kind, pair, value in laws)
    return (*known, Element(EFFECTS["gap"](contact, CLEARANCE), CHAIN[1]))


def test_a_joint_without_sensor_moves_as_the_masses_do_within_its_band(tmp_path, truth):
    """No sensor on the coupon; a contact 0.3 % off, and draws that know it to as much."""
    made = replace(model(sensed=["bracket"]), elements=true_laws(1.003 * CONTACT))
    measured = shaken(tmp_path, truth)(made)
    (test,) = compare_tests(made, [measured]).tests
    drawn = [
        replace(made, elements=true_laws(share * 1.003 * CONTACT))
        for share in 1.0 + 0.003 * np.random.default_rng(2).standard_normal(DRAWS)
    ]
    x1, x2, *_, q1, q2 = truth[1]
    found = hidden_joints(made, drawn, test)
    assert [joint.between for joint in found] == list(CHAIN)
    for joint, z, q in zip(found, (x1, x2 - x1), (q1, q2), strict=True):
        part = np.rint(np.array(joint.time) * RATE).astype(int)
        for band, known in ((joint.displacement, z[part]), (joint.force, q[part])):
            low, value, high = (np.array(one) for one in (band.low, band.value, band.high))
            assert rms(value - known) < 0.1 * rms(known)
            assert np.mean((low <= known) & (known <= high)) > 0.85
            assert rms(high - low) < 0.3 * rms(known)


def test_nothing_is_hidden_where_every_place_has_a_sensor(tmp_path, truth):
    made = replace(model(), elements=true_laws())
    (test,) = compare_tests(made, [shaken(tmp_path, truth)(made)]).tests
    assert hidden_joints(made, [made], test) == ()
