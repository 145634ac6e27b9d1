"""Response curves against shooting, exact backbones and limits."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.closed_forms import oracles
from tests.harmonic_balance.oscillators import (
    DAMPING,
    duffing,
    flow,
    gap,
    gap_force,
    model,
    shoot,
)

from shakerproc.errors import ModelError
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import closed_forms, simulate
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.backbone import backbone
from shakerproc.simulation.harmonic_balance.branch import (
    monodromy,
    samples_of_branch,
    sharpened,
)
from shakerproc.simulation.harmonic_balance.curves import newton
from shakerproc.simulation.harmonic_balance.response import (
    balance_of_system,
    frequency_response,
)
from shakerproc.simulation.harmonic_balance.switching import branch_off, subharmonic_branches

NATURAL = np.sqrt(1000.0) / (2.0 * np.pi)


def state(balance, unknowns, omega):
    """Displacement and velocity at time 0."""
    motion = next(iter(balance.motions(unknowns, omega)))[1]
    return np.concatenate(motion.at(np.zeros(1)))


def at_frequency(response, frequency):
    """Every solution of the curve at a frequency, made exact at that frequency."""
    found = []
    for branch in response.branches:
        below = branch.frequency < frequency
        for i in np.flatnonzero(below[1:] != below[:-1]):
            nearest = (
                i
                if abs(branch.frequency[i] - frequency)
                < abs(branch.frequency[i + 1] - frequency)
                else i + 1
            )
            omega = 2.0 * np.pi * frequency / branch.balance.order
            found.append((branch, newton(branch.balance, branch.unknowns[nearest], omega)))
    return found


@pytest.fixture(scope="module")
def gap_response():
    return frequency_response(gap(5e-3), 5.0, from_hz=2.0, to_hz=6.0)


def duffing_force(x, v, _):
    return 1000.0 * x + 1e7 * x**3 + DAMPING * v


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [3.0, 4.9])
def test_gap_at_31_harmonics_agrees_with_shooting(gap_response, frequency):
    omega, walls, force = 2.0 * np.pi * frequency, (-5e-3, 5e-3), gap_force(5e-3)
    solutions = at_frequency(gap_response, frequency)
    assert len(solutions) == (3 if frequency == 4.9 else 1)
    for branch, unknowns in solutions:
        start = state(branch.balance, unknowns, omega)
        exact = shoot(force, 5.0, omega, start, walls)
        size = np.max(np.abs(branch.balance.coefficients(unknowns)))
        assert_allclose(start[0], exact[0], atol=2e-5 * size)
        assert_allclose(start[1], exact[1], atol=1e-4 * size * omega)


@pytest.mark.slow
def test_time_integration_stays_on_either_stable_branch(gap_response):
    """Started on the upper or the lower branch, the motion repeats itself for 60 periods."""
    omega, amplitudes = 2.0 * np.pi * 4.9, []
    for branch, unknowns in at_frequency(gap_response, 4.9):
        nearest = int(np.argmin(np.abs(branch.unknowns - unknowns).sum(axis=1)))
        if not branch.stable[nearest]:
            continue
        x, v = state(branch.balance, unknowns, omega)
        found = simulate(
            gap(5e-3),
            lambda t: 5.0 * np.cos(omega * t),
            64 * 4.9,
            duration=60 / 4.9,
            start={"mass": (float(x), float(v))},
            growth=False,
        )
        period = fourier.values(
            branch.balance.coefficients(unknowns), branch.balance.harmonics, 64
        )[0]
        amplitudes.append(np.max(np.abs(period)))
        assert_allclose(found.displacement[0, -65:-1], period, atol=1e-4 * amplitudes[-1])
    assert len(amplitudes) == 2
    assert max(amplitudes) > 5.0 * min(amplitudes)


@pytest.mark.slow
def test_duffing_at_15_harmonics_agrees_with_shooting():
    response = frequency_response(duffing(), 0.5, from_hz=3.0, to_hz=9.0, harmonics=15)
    omega = 2.0 * np.pi * 7.0
    solutions = at_frequency(response, 7.0)
    assert len(solutions) == 3
    for branch, unknowns in solutions:
        start = state(branch.balance, unknowns, omega)
        exact = shoot(duffing_force, 0.5, omega, start)
        scale = np.max(np.abs(branch.balance.coefficients(unknowns))) * np.array([1.0, omega])
        assert_allclose(start / scale, exact / scale, atol=1e-10)


def test_error_of_the_gap_falls_with_the_third_power_of_the_harmonics():
    """The force has a corner: its coefficients fall as 1/n², those of the motion as 1/n⁴."""
    omega, errors = 2.0 * np.pi * 4.0, []
    exact = frequency_response(gap(5e-3), 5.0, from_hz=3.9, to_hz=4.2, harmonics=255)
    reference = state(*_one(exact, 4.0), omega)[0]
    for harmonics in (3, 7, 15, 31, 63):
        found = frequency_response(gap(5e-3), 5.0, from_hz=3.9, to_hz=4.2, harmonics=harmonics)
        errors.append(abs(state(*_one(found, 4.0), omega)[0] / reference - 1.0))
    order = -np.polyfit(np.log([3, 7, 15, 31, 63]), np.log(errors), 1)[0]
    assert errors[3] < 2e-5
    assert 2.0 < order < 4.5


def _one(response, frequency):
    ((branch, unknowns),) = at_frequency(response, frequency)
    return branch.balance, unknowns


@pytest.mark.parametrize(
    "shaken",
    [
        gap(5e-3),
        duffing(),
        model(
            EFFECTS["gap"](stiffness=1000.0, clearance=5e-3),
            EFFECTS["power_law_damping"](
                damping=1.0, reference_displacement=5e-3, exponent=2.0
            ),
        ),
    ],
)
def test_volume_shrinks_as_the_damping_says(shaken):
    """det(monodromy) is the exponential of the divergence, whatever the motion."""
    response = frequency_response(shaken, 5.0, from_hz=3.0, to_hz=4.5, harmonics=15)
    branch = response.branches[0]
    for i in range(0, branch.frequency.size, 7):
        omega = 2.0 * np.pi * branch.frequency[i]
        found = np.linalg.det(monodromy(branch.balance, branch.unknowns[i], omega))
        coupling, motion = list(branch.balance.motions(branch.unknowns[i], omega))[-1]
        damping = branch.balance.system.damping[0, 0]
        displacement, slope = motion.sampled(4096)
        damping += np.mean(coupling.law.tangent(displacement, omega * slope)[1])
        expected = np.exp(-damping / branch.frequency[i])
        exact = 1e-13 if not coupling.law.varies or damping == DAMPING else 1e-6
        assert_allclose(found, expected, rtol=exact)


@pytest.mark.slow
def test_monodromy_of_contact_damping_is_that_of_the_flow():
    """The force jumps at the walls; differences of the flow know nothing of jump matrices."""
    clearance, contact = 5e-3, 2.0
    damped = model(
        EFFECTS["gap"](stiffness=1000.0, clearance=clearance),
        EFFECTS["contact_damping"](damping=contact, clearance=clearance),
        EFFECTS["damper"](damping=DAMPING),
    )
    response = frequency_response(damped, 5.0, from_hz=3.9, to_hz=4.1, harmonics=61)
    balance, unknowns = _one(response, 4.0)
    omega, walls = 8.0 * np.pi, (-clearance, clearance)
    undamped = gap_force(clearance)

    def force(x, v, stretch):
        return undamped(x, v, stretch) + (0.0 if stretch == 1 else contact * v)

    start = state(balance, unknowns, omega)
    columns = []
    for i, step in enumerate((1e-7, 1e-7 * omega)):
        change = step * np.eye(2)[i]
        ends = [flow(force, 5.0, omega, start + s * change, 0.25, walls) for s in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    found = monodromy(balance, unknowns, omega)
    assert_allclose(found, np.array(columns).T, rtol=2e-3)


def test_a_multiplier_is_one_at_every_fold():
    """The fold is found by harmonic balance, the multiplier by propagators: two ways."""
    for shaken, level, band in ((gap(5e-3), 5.0, (3.0, 6.0)), (duffing(), 0.5, (3.0, 9.0))):
        response = frequency_response(
            shaken, level, from_hz=band[0], to_hz=band[1], harmonics=61
        )
        (branch,) = response.branches
        assert len(branch.folds) == 2
        near = np.min(np.abs(branch.multipliers[list(branch.folds)] - 1.0), axis=1)
        assert_allclose(near, 0.0, atol=2e-4)


def test_between_the_folds_the_motion_is_unstable(gap_response):
    (branch,) = gap_response.branches
    first, second = branch.folds
    assert branch.frequency[first] > branch.frequency[second]
    assert not branch.stable[first + 1 : second - 1].any()
    assert branch.stable[second + 1 :].all()


def test_contact_is_lost_where_the_free_motion_just_touches(gap_response):
    """Beyond it, nothing but inertia and the damper bear the force."""
    (branch,) = gap_response.branches
    omega = 2.0 * np.pi * branch.frequency[-1]
    assert "contact lost at 5.032" in branch.ended
    assert_allclose(5e-3 * omega * np.hypot(omega, DAMPING), 5.0, rtol=1e-6)


def test_unequal_free_play_floats_at_the_mean_of_both():
    offset = model(
        EFFECTS["offset_gap"](
            stiffness=1000.0, clearance_positive=5e-3, clearance_negative=2e-3
        ),
        EFFECTS["damper"](damping=DAMPING),
    )
    response = frequency_response(offset, 5.0, from_hz=3.5, to_hz=10.0, harmonics=15)
    omega = 2.0 * np.pi * response.branches[0].frequency[-1]
    assert "contact lost" in response.branches[0].ended
    assert_allclose(3.5e-3 * omega * np.hypot(omega, DAMPING), 5.0, rtol=2e-3)


def test_a_level_that_never_closes_the_gap_is_refused():
    with pytest.raises(ModelError, match="contact lost: at 8 Hz and at 10 Hz the motion stays"):
        frequency_response(gap(5e-3), 5.0, from_hz=8.0, to_hz=10.0)


def test_drift_has_no_response():
    drifting = model(
        EFFECTS["spring"](stiffness=1000.0),
        EFFECTS["stiffness_drift"](rate=-0.01, reference=0.0),
    )
    with pytest.raises(ModelError, match="stiffness_drift between base and mass changes with"):
        frequency_response(drifting, 1.0, from_hz=1.0, to_hz=2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"level": 0.0}, "level must be above 0"),
        ({"from_hz": 0.0}, "from_hz must be above 0 Hz"),
        ({"to_hz": 1.0}, "to_hz must be above from_hz 2 Hz, not 1 Hz"),
        ({"harmonics": 0}, "harmonics must be at least 1, not 0"),
    ],
)
def test_wrong_arguments_are_named(change, message):
    arguments = {"level": 1.0, "from_hz": 2.0, "to_hz": 3.0, "harmonics": 3} | change
    with pytest.raises(ValueError, match=message):
        frequency_response(duffing(), arguments.pop("level"), **arguments)


def test_base_acceleration_is_a_force_on_every_mass():
    elements = (Element(EFFECTS["spring"](stiffness=500.0), ("base", "m")),)
    shaken = Model("base", {"m": 0.5}, elements, Excitation("base acceleration"))
    pushed = Model("force", {"m": 0.5}, elements, Excitation("force", "m"))
    found = frequency_response(shaken, 2.0, from_hz=1.0, to_hz=3.0, harmonics=1)
    same = frequency_response(pushed, 1.0, from_hz=1.0, to_hz=3.0, harmonics=1)
    assert_allclose(found.branches[0].unknowns[0], -same.branches[0].unknowns[0], rtol=1e-12)


def test_two_masses_with_a_gap_between_them_repeat_themselves():
    """One period of the full equations of motion returns to where harmonic balance began."""
    from scipy.integrate import solve_ivp

    elements = (
        Element(EFFECTS["spring"](stiffness=3000.0), ("base", "a")),
        Element(EFFECTS["damper"](damping=3.0), ("base", "a")),
        Element(EFFECTS["gap"](stiffness=2000.0, clearance=1e-3), ("a", "b")),
        Element(EFFECTS["damper"](damping=1.0), ("a", "b")),
        Element(EFFECTS["spring"](stiffness=200.0), ("base", "b")),
    )
    shaken = Model("two", {"a": 1.0, "b": 0.5}, elements, Excitation("base acceleration"))
    response = frequency_response(shaken, 3.0, from_hz=2.0, to_hz=15.0, harmonics=25)
    branch = max(response.branches, key=lambda found: np.ptp(found.frequency))
    assert_allclose(sorted(branch.frequency)[:: branch.frequency.size - 1], [2.0, 15.0])
    for i in range(5, branch.frequency.size, 40):
        omega = 2.0 * np.pi * branch.frequency[i]
        start = np.array([
            fourier.value(row, branch.balance.harmonics, 0.0)[:2]
            for row in branch.balance.coefficients(branch.unknowns[i])
        ])

        def motion(t, y, omega=omega):
            x, v = y[:2], y[2:]
            z, w = x[1] - x[0], v[1] - v[0]
            between = 2000.0 * np.sign(z) * max(abs(z) - 1e-3, 0.0) + w
            push = -3.0 * np.cos(omega * t)
            return [
                *v,
                push - 3000.0 * x[0] - 3.0 * v[0] + between,
                push - (between + 200.0 * x[1]) / 0.5,
            ]

        begin = np.concatenate([start[:, 0], omega * start[:, 1]])
        end = solve_ivp(
            motion, (0.0, 2.0 * np.pi / omega), begin, rtol=1e-9, atol=1e-12, method="DOP853"
        ).y[:, -1]
        scale = np.max(np.abs(begin[:2])) + np.max(np.abs(begin[2:])) / omega
        assert_allclose((end - begin) / scale, 0.0, atol=2e-3 * omega)


@pytest.mark.parametrize(("harmonics", "error"), [(15, 5e-4), (31, 1e-4), (61, 2e-5)])
def test_backbone_of_the_gap_is_the_exact_one(harmonics, error):
    found = backbone(gap(5e-3), (7e-3, 0.3), harmonics=harmonics)
    exact = NATURAL * oracles.gap_backbone(found.amplitude, 5e-3)
    assert_allclose(found.frequency, exact, rtol=error)
    assert found.amplitude[0] < 8e-3
    assert found.amplitude[-1] > 0.25


def test_backbone_of_the_duffing_oscillator_is_elliptic():
    found = backbone(duffing(), (1e-4, 0.3), harmonics=15)
    exact = closed_forms.duffing_free_frequency(found.amplitude, NATURAL, 1e7)
    assert_allclose(found.frequency, exact, rtol=1e-10)
    assert_allclose(found.damping_ratio, DAMPING / (4.0 * np.pi * found.frequency), rtol=1e-9)


def test_backbone_of_a_power_law_needs_no_spring():
    shaken = model(EFFECTS["power_law"](force=10.0, reference_displacement=1e-3, exponent=7.0))
    found = backbone(shaken, (1e-4, 3e-3))
    exact = closed_forms.power_law_frequency(found.amplitude, 1.0, 10.0, 1e-3, 7.0)
    assert_allclose(found.frequency, exact, rtol=1e-8)


def test_damping_ratio_of_dry_friction_is_eq_3_24():
    shaken = model(
        EFFECTS["spring"](stiffness=1000.0), EFFECTS["coulomb_friction"](sliding_force=1.0)
    )
    found = backbone(shaken, (0.02, 0.1), harmonics=15)
    expected = 2.0 / (np.pi * 1000.0 * found.amplitude)
    assert_allclose(found.damping_ratio, expected, rtol=2e-3)


def test_backbone_of_a_slider_softens_and_damps():
    """Stuck it is a spring; far beyond, its loop is a rectangle (a parallelogram)."""
    shaken = model(
        EFFECTS["spring"](stiffness=1000.0),
        EFFECTS["jenkins"](stiffness=1000.0, slip_force=1.0),
    )
    found = backbone(shaken, (1e-4, 0.1), harmonics=7)
    stuck = found.amplitude < 0.99e-3
    assert stuck.sum() > 3
    assert_allclose(found.frequency[stuck], NATURAL * np.sqrt(2.0), rtol=1e-6)
    assert_allclose(found.damping_ratio[stuck], 0.0, atol=1e-6)
    wide = found.amplitude > 0.05
    work = 4.0 * 1.0 * (found.amplitude - 1e-3)
    energy = 0.5 * 1000.0 * found.amplitude**2
    assert_allclose(found.damping_ratio[wide], (work / (4 * np.pi * energy))[wide], rtol=0.02)


def test_a_backbone_needs_amplitudes_and_a_mode():
    with pytest.raises(ValueError, match=r"amplitudes must rise, not 0\.1 m"):
        backbone(duffing(), (0.1, 0.05))
    with pytest.raises(ValueError, match="mode must be 1 to 1, not 2"):
        backbone(duffing(), (0.01, 0.05), mode=2)


@pytest.mark.slow
def test_the_branch_without_symmetry_solves_the_equation_of_motion(gap_response):
    branch = sharpened(gap_response.branches[0])
    mark = next(mark for mark in branch.marks if mark.kind == "branch point")
    assert_allclose(np.abs(branch.multipliers[mark.index, 0]), 1.0, atol=2e-3)
    other = branch_off(branch, mark, gap_response.band)
    assert other is not None
    omega = 2.0 * np.pi * other.frequency[-2]
    assert abs(other.coefficients[-2, 0, 0]) > 1e-4  # a mean, which odd harmonics cannot have
    start = state(other.balance, other.unknowns[-2], omega)
    end = flow(gap_force(5e-3), 5.0, omega, start, 2 * np.pi / omega, (-5e-3, 5e-3))
    scale = np.max(np.abs(other.coefficients[-2])) * np.array([1.0, omega])
    assert_allclose((end - start) / scale, 0.0, atol=2e-3)


@pytest.mark.slow
def test_a_third_subharmonic_closes_on_itself_and_repeats_after_three_periods():
    response = frequency_response(gap(5e-3), 5.0, from_hz=3.0, to_hz=20.0, harmonics=15)
    (found,) = subharmonic_branches(response, 3, harmonics=21)
    assert found.balance.order == 3
    assert "closed on itself" in found.ended
    assert found.stable.any()
    assert not found.stable.all()
    i = int(np.flatnonzero(found.stable)[3])
    omega = 2.0 * np.pi * found.frequency[i]
    start = state(found.balance, found.unknowns[i], omega / 3.0)
    walls, force = (-5e-3, 5e-3), gap_force(5e-3)
    exact = shoot(force, 5.0, omega, start, walls, periods=3)
    scale = np.max(np.abs(found.coefficients[i])) * np.array([1.0, omega])
    assert_allclose((exact - start) / scale, 0.0, atol=1e-3)
    once = flow(force, 5.0, omega, exact, 2.0 * np.pi / omega, walls)
    assert np.max(np.abs(once - exact) / scale) > 0.1


def test_no_subharmonic_where_there_is_none():
    response = frequency_response(duffing(1e5), 0.05, from_hz=3.0, to_hz=8.0, harmonics=5)
    assert subharmonic_branches(response, 2, harmonics=5) == ()
    with pytest.raises(ValueError, match="order must be at least 2, not 1"):
        subharmonic_branches(response, 1)


def test_superharmonic_spikes_are_not_stepped_over():
    """Near a third of the resonance the third harmonic peaks; the curve must show its top."""
    response = frequency_response(gap(5e-4), 5.0, from_hz=1.5, to_hz=2.0, harmonics=15)
    third = np.abs(response.branches[0].coefficients[:, 0, 1])
    top = int(np.argmax(third))
    assert 0 < top < third.size - 1
    assert third[top] > 8.0 * third[-1]
    fine = samples_of_branch(response.branches[0], 64)
    assert fine.shape == (third.size, 1, 64)
    assert balance_of_system(response.branches[0].balance.system, 3).n_unknowns == 4


@pytest.mark.parametrize(("low", "high"), [(1.3, 7.0), (1.3, 6.0), (1.3, 15.0), (1.3, 5.0)])
def test_every_motion_that_reaches_an_end_of_the_band_is_followed(low, high):
    """A fold beyond the band: the lower branch is inside it and must be there.

    One harmonic is the closed form of eq. 3.47, whose roots count the motions at a frequency.
    """
    elements = (
        Element(EFFECTS["spring"](stiffness=1000.0), ("base", "m")),
        Element(EFFECTS["cubic_stiffness"](coefficient=1e7), ("base", "m")),
        Element(EFFECTS["damper"](damping=2.0 * 0.01 * np.sqrt(1000.0)), ("base", "m")),
    )
    duffing = Model("duffing", {"m": 1.0}, elements, Excitation("force", "m"))
    found = frequency_response(duffing, 0.5, from_hz=low, to_hz=high, harmonics=1)
    for hertz in np.linspace(low, high, 23)[1:-1]:
        omega = 2.0 * np.pi * hertz
        damped = (2.0 * 0.01 * np.sqrt(1000.0) * omega) ** 2
        detuned = 1000.0 - omega**2
        roots = np.roots([(0.75e7) ** 2, 1.5e7 * detuned, detuned**2 + damped, -(0.5**2)])
        real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots)].real
        expected = np.sort(np.sqrt(real[real > 0.0]))
        crossed = []
        for branch in found.branches:
            amplitude = np.max(np.abs(samples_of_branch(branch, 256)[:, 0]), axis=-1)
            before, after = branch.frequency[:-1], branch.frequency[1:]
            for i in np.flatnonzero((before - hertz) * (after - hertz) < 0.0):
                share = (hertz - before[i]) / (after[i] - before[i])
                crossed.append(amplitude[i] + share * (amplitude[i + 1] - amplitude[i]))
        assert len(crossed) == expected.size
        assert_allclose(np.sort(crossed), expected, rtol=0.05)
    sentences = " ".join(found.not_followed)
    assert f"beyond {low:g} Hz and {high:g} Hz" in sentences
    assert "isolated branches" in sentences
    assert "even number" not in sentences


def test_an_even_number_of_motions_at_an_end_is_said_to_lack_one():
    elements = (
        Element(EFFECTS["spring"](stiffness=1000.0), ("base", "m")),
        Element(EFFECTS["cubic_stiffness"](coefficient=1e7), ("base", "m")),
        Element(EFFECTS["damper"](damping=2.0 * 0.01 * np.sqrt(1000.0)), ("base", "m")),
    )
    duffing = Model("duffing", {"m": 1.0}, elements, Excitation("force", "m"))
    found = frequency_response(duffing, 0.5, from_hz=1.3, to_hz=7.0, harmonics=1)
    assert len(found.branches) == 2
    one = replace(found, branches=found.branches[1:])
    assert "at 7 Hz 2 motions were found, an even number" in " ".join(one.not_followed)
