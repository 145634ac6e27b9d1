"""The simulator against closed forms, extended precision, and methods that share no code."""

import numpy as np
import pytest
from benchmarks.stated_errors import ratios_of
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk
from tests.simulation import long_double

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    PowerLaw,
    Spring,
    Stop,
)
from shakerproc.simulation import prepare, simulate
from shakerproc.simulation.comparison import general_solver, newmark
from shakerproc.simulation.excitations import harmonic, linear_sweep, rest

GROUND = ("base", "coupon")


def single(*effects, mass=1.0, by_force=True):
    excitation = Excitation("force", "coupon") if by_force else Excitation("base acceleration")
    elements = tuple(Element(effect, GROUND) for effect in effects)
    return Model("one mass", {"coupon": mass}, elements, excitation, {"a": Sensor("coupon")})


GAP = single(Gap(1000.0, 0.5e-3), Damper(damping_ratio=0.01))
DAMPING = 0.02 * np.sqrt(1000.0)


def worst(values, reference):
    return float(np.max(np.abs(values - reference)) / np.max(np.abs(reference)))


@pytest.mark.slow
def test_the_gap_oscillator_of_the_research_page_with_an_analytic_chirp():
    """Force 0 to 30 Hz over 30 s, 5 N, outputs at 500 Hz; its first 15 s, to be quick."""
    oscillator = long_double.Oscillator(1.0, DAMPING, 0.0, 1000.0, 0.5e-3)
    interval = long_double.EXTENDED(1) / 500
    reference = long_double.respond(
        oscillator,
        lambda j, start, share: long_double.chirp_series(
            5.0, 1.0, (j + start) * interval, share * interval, cosine=True
        ),
        7500,
        interval,
    )
    chirp = linear_sweep(0.0, 30.0, 30.0, 5.0, 0.5 * np.pi)  # MATLAB's chirp is a cosine
    found = simulate(GAP, chirp, 500.0, duration=15.0)
    assert found.solver == "exact propagators"
    assert found.switchings > 250
    error = worst(found.displacement[0], reference.astype(float))
    assert error < 1e-11
    assert error < found.error < 1e-8
    assert found.growth < 1e4
    assert not found.chaotic


def test_the_gap_oscillator_with_a_sampled_force():
    force = 5.0 * np.sin(np.pi * (np.arange(2501) / 500.0) ** 2)
    oscillator = long_double.Oscillator(1.0, DAMPING, 0.0, 1000.0, 0.5e-3)
    reference = long_double.respond(
        oscillator,
        lambda j, start, share: long_double.line_series(force[j], force[j + 1], start, share),
        2500,
        long_double.EXTENDED(1) / 500,
    )
    found = simulate(GAP, prepare(force, 500.0, hold="linear"))
    assert worst(found.displacement[0], reference.astype(float)) < 3e-12


@pytest.mark.parametrize("solver", ["taylor", "dop853"])
def test_duffing_in_extended_precision(solver):
    """Table 6.7 of the thesis with a = 0.1, kappa = 10: the cubic coefficient is 1e4."""
    model = single(CubicStiffness(1e4), Damper(damping=0.06324))
    oscillator = long_double.Oscillator(1.0, 0.06324, cubic=1e4)
    interval = long_double.EXTENDED(1) / 500
    reference = long_double.respond(
        oscillator,
        lambda j, start, share: long_double.chirp_series(
            5.0, 1.0, (j + start) * interval, share * interval
        ),
        2500,
        interval,
    )
    found = simulate(
        model, linear_sweep(0.0, 30.0, 30.0, 5.0), 500.0, duration=5.0, solver=solver,
        tolerance=1e-13,
    )  # fmt: skip
    limit = 1e-11 if solver == "taylor" else 1e-9
    assert worst(found.displacement[0], reference.astype(float)) < limit


@pytest.mark.parametrize(
    ("stiffness", "cubic"), [(1.0, 1.0), (4.0, 1e3), (0.0, 7.0), (9.0, -5.0)]
)
def test_free_duffing_motion_is_an_elliptic_cosine(stiffness, cubic):
    amplitude = 0.7
    omega = np.sqrt(stiffness + cubic * amplitude**2)
    parameter = cubic * amplitude**2 / (2.0 * omega**2)
    effects = [CubicStiffness(cubic)] + ([Spring(stiffness)] if stiffness else [])
    found = simulate(
        single(*effects), rest(), 200.0 * omega, duration=40.0 / omega,
        start={"coupon": (amplitude, 0.0)},
    )  # fmt: skip
    if parameter >= 0.0:
        expected = amplitude * ellipj(omega * found.time, parameter)[1]
    else:  # cn(u | -m) = cd(u sqrt(1 + m) | m / (1 + m))
        stretched = omega * found.time * np.sqrt(1.0 - parameter)
        _, cn, dn, _ = ellipj(stretched, -parameter / (1.0 - parameter))
        expected = amplitude * cn / dn
    assert worst(found.displacement[0], expected) < 1e-11
    assert ellipk(max(parameter, 0.0)) > 1.5


@pytest.mark.parametrize("ratio", [1.05, 2.0, 10.0])
def test_free_vibration_in_a_gap_has_the_period_of_its_backbone(ratio):
    """Half a period crosses the gap at constant speed, half a sine follows at each wall."""
    stiffness, clearance = 1000.0, 1e-3
    omega = np.sqrt(stiffness)
    depth = (ratio - 1.0) * clearance
    period = 2.0 * np.pi / omega + 4.0 * clearance / (depth * omega)
    found = simulate(
        single(Gap(stiffness, clearance)), rest(), 1000.0 / period, duration=20.0 * period,
        start={"coupon": (ratio * clearance, 0.0)},
    )  # fmt: skip
    assert_allclose(found.displacement[0, ::1000], ratio * clearance, rtol=1e-11)
    assert_allclose(found.displacement[0, 500::1000], -ratio * clearance, rtol=1e-11)
    energy = (
        0.5 * found.velocity[0] ** 2
        + 0.5 * stiffness * np.maximum(np.abs(found.displacement[0]) - clearance, 0.0) ** 2
    )
    assert_allclose(energy, energy[0], rtol=1e-10)


def test_free_sliding_loses_the_same_amount_every_half_cycle_and_then_sticks():
    """Each swing ends 2 Fc / k nearer, until the spring no longer overcomes the friction."""
    stiffness, friction, start = 100.0, 3.0, 0.5
    omega = 10.0
    found = simulate(
        single(Spring(stiffness), CoulombFriction(friction)), rest(), 1000.0 * omega / np.pi,
        duration=20.0 * np.pi / omega, start={"coupon": (start, 0.0)},
    )  # fmt: skip
    swing = np.arange(9)
    expected = (start - 2.0 * swing * friction / stiffness) * (-1.0) ** swing
    assert_allclose(found.displacement[0, : 9 * 1000 : 1000], expected, atol=1e-13)
    stuck = found.displacement[0, 9000:]
    assert_allclose(stuck, stuck[0], rtol=0.0, atol=1e-16)
    assert np.all(np.abs(found.velocity[0, 9000:]) < 1e-18)
    assert abs(stuck[0]) * stiffness <= friction


@pytest.mark.parametrize(("share", "ratio"), [(0.3, 0.7), (0.5, 1.3), (0.6, 1.6), (0.2, 2.5)])
def test_steady_sliding_is_den_hartogs(share, ratio):
    """Den Hartog (1931), no viscous damping and no stops: the exact amplitude of displacement.

    X k / F = sqrt(V^2 - (U s)^2), V = 1 / (1 - r^2), U = sin(pi/r) / (r (1 + cos(pi/r))).
    """
    stiffness, force = 400.0, 8.0
    omega = ratio * np.sqrt(stiffness)
    v = 1.0 / (1.0 - ratio**2)
    u = np.sin(np.pi / ratio) / (ratio * (1.0 + np.cos(np.pi / ratio)))
    amplitude = force / stiffness * np.sqrt(v**2 - (u * share) ** 2)
    model = single(Spring(stiffness), CoulombFriction(share * force))
    frequency, rate = omega / 2.0 / np.pi, 200.0 * omega / 2.0 / np.pi
    found = simulate(
        model, harmonic(frequency, force), rate, duration=400.0 / frequency, growth=False
    )
    turns = np.diff(np.sign(found.velocity[0])) != 0.0
    before = np.flatnonzero(turns)[-2]
    begin = (found.displacement[0, before], found.velocity[0, before])
    phase = 2.0 * np.pi * (before / 200.0)
    closer = simulate(
        model, harmonic(frequency, force, phase), 3000.0 * rate, duration=1.0 / rate,
        start={"coupon": begin}, growth=False,
    )  # fmt: skip
    assert_allclose(np.max(np.abs(closer.displacement)), amplitude, rtol=1e-10)


def test_sticking_joints_stick_exactly_and_break_at_the_right_force():
    """A ramp of force on a mass that friction holds: it starts to move when they are equal."""
    force = np.linspace(0.0, 2.0, 201)
    found = simulate(single(CoulombFriction(1.0055)), prepare(force, 100.0, hold="linear"))
    still = np.arange(201) / 100.0 <= 1.0055
    assert np.all(found.displacement[0, still] == 0.0)
    after = np.arange(201)[~still] / 100.0 - 1.0055
    assert_allclose(found.displacement[0, ~still], after**3 / 6.0, rtol=1e-11)
    assert found.switchings == 1


def test_a_linear_model_of_two_masses_is_the_superposition_of_its_modes():
    """Free vibration against the eigenvectors, and absolute acceleration by its definition."""
    model = Model(
        "two",
        {"a": 2.0, "b": 1.0},
        (
            Element(Spring(300.0), ("base", "a")),
            Element(Spring(100.0), ("a", "b")),
            Element(Spring(50.0), ("b", "base")),
        ),
        Excitation("base acceleration"),
        {"x": Sensor("b")},
    )
    stiffness = np.array([[400.0, -100.0], [-100.0, 150.0]])
    values, vectors = np.linalg.eig(np.linalg.inv(np.diag([2.0, 1.0])) @ stiffness)
    start = np.array([0.1, -0.2])
    found = simulate(
        model, rest(), 50.0, duration=20.0, start={"a": (0.1, 0.0), "b": (-0.2, 0.0)}
    )
    modal = np.linalg.solve(vectors, start)
    expected = vectors @ (modal[:, None] * np.cos(np.sqrt(values)[:, None] * found.time))
    assert_allclose(found.displacement, expected, atol=1e-12)
    assert_allclose(found.outputs["x"], -(stiffness @ expected)[1], atol=1e-9)


def test_two_masses_with_stops_between_them_against_a_general_solver():
    model = Model(
        "two",
        {"a": 2.0, "b": 1.0},
        (
            Element(Spring(300.0), ("base", "a")),
            Element(Damper(damping=0.8), ("base", "a")),
            Element(Spring(40.0), ("a", "b")),
            Element(Stop(2000.0, 0.01, "positive"), ("a", "b")),
            Element(Gap(900.0, 0.02), ("b", "base")),
            Element(PowerLaw(3.0, 0.02, 3.0), ("a", "base")),
        ),
        Excitation("base acceleration"),
    )
    signal = harmonic(2.0, 4.0)
    found = simulate(model, signal, 200.0, duration=1.2)
    reference = general_solver(
        model, lambda t: float(signal(np.array(t))), found.time, method="DOP853",
        relative_tolerance=1e-11,
    )  # fmt: skip
    assert found.switchings > 4
    assert_allclose(found.displacement, reference.displacement, atol=1e-6 * 0.02)
    relative = found.acceleration - found.excitation
    assert_allclose(relative, reference.acceleration, atol=1e-4)


def test_friction_between_two_masses_holds_them_together():
    """Two masses that never slip are one mass of the sum; momentum is kept when they meet."""
    pieces = {"a": 1.0, "b": 3.0}
    elements = (
        Element(Spring(100.0), ("base", "a")),
        Element(CoulombFriction(50.0), ("a", "b")),
    )
    model = Model("held", pieces, elements, Excitation("base acceleration"))
    held = simulate(model, harmonic(0.5, 3.0), 100.0, duration=10.0)
    one = simulate(
        single(Spring(100.0), mass=4.0, by_force=False),
        harmonic(0.5, 3.0),
        100.0,
        duration=10.0,
    )
    assert_allclose(held.displacement[0], one.displacement[0], atol=1e-12)
    assert_allclose(held.displacement[1], one.displacement[0], atol=1e-12)
    slid = simulate(model, rest(), 1e5, duration=0.02, start={"a": (0.0, 0.0), "b": (0.0, 1.0)})
    momentum = slid.velocity.T @ [1.0, 3.0]
    push = -100.0 * slid.displacement[0]
    assert_allclose(np.diff(momentum) * 1e5, 0.5 * (push[1:] + push[:-1]), atol=1e-6)
    assert abs(slid.velocity[1, -1] - slid.velocity[0, -1]) < 1e-12


def test_a_chain_of_joints_that_stick_and_slide_keeps_its_energy_balance():
    """Three masses, two frictions, one on the base: work put in less what slid away."""
    model = Model(
        "chain",
        {"a": 1.0, "b": 1.0, "c": 1.0},
        (
            Element(Spring(100.0), ("base", "a")),
            Element(Spring(80.0), ("a", "b")),
            Element(CoulombFriction(0.5), ("a", "b")),
            Element(Spring(60.0), ("b", "c")),
            Element(CoulombFriction(0.3), ("b", "c")),
            Element(CoulombFriction(0.2), ("base", "c")),
        ),
        Excitation("force", "a"),
    )
    force = harmonic(1.1, 3.0)
    found = simulate(model, force, 2000.0, duration=10.0)
    u, v = found.displacement, found.velocity
    kinetic = 0.5 * np.sum(v**2, axis=0)
    stretch = np.stack((u[0], u[1] - u[0], u[2] - u[1]))
    stored = 0.5 * np.array([100.0, 80.0, 60.0]) @ stretch**2
    lost = np.array([0.5, 0.3, 0.2]) @ np.abs(np.stack((v[1] - v[0], v[2] - v[1], v[2])))
    power = found.excitation * v[0] - lost
    work = np.concatenate(([0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) / 2000.0)))
    assert found.switchings > 40
    assert_allclose(kinetic + stored, work, atol=2e-4 * np.max(kinetic))


def test_newmark_has_order_two_and_the_general_solver_agrees():
    model = single(Spring(1000.0), CubicStiffness(1e5), Damper(damping=2.0))
    signal = harmonic(3.0, 20.0)
    exact = simulate(model, signal, 400.0, duration=1.0).displacement[0]
    errors = []
    for factor in (1, 2, 4):
        rate = 400.0 * factor
        force = signal(np.arange(round(rate) + 1) / rate)
        found = newmark(model, force, rate).displacement[0]
        errors.append(worst(found[::factor], exact))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert_allclose(orders, 2.0, atol=0.1)
    coarse = general_solver(
        model, lambda t: float(signal(np.array(t))), np.arange(401) / 400.0
    ).displacement[0]
    fine = general_solver(
        model, lambda t: float(signal(np.array(t))), np.arange(401) / 400.0,
        relative_tolerance=1e-9,
    ).displacement[0]  # fmt: skip
    assert 1e-5 < worst(coarse, exact) < 1e-1
    assert worst(fine, exact) < 1e-6


def test_the_band_limited_hold_has_order_six_and_the_linear_one_two():
    """A periodic sine that fits the samples, so that only the hold errs."""
    model = single(Spring(1000.0), Damper(damping=5.0))
    signal = harmonic(2.0, 20.0)
    exact = simulate(model, signal, 256.0, duration=8.0).displacement[0]
    for hold, order in (("linear", 2.0), ("band-limited", 6.0)):
        errors = []
        for factor in (1, 2):
            rate = 16.0 * factor
            found = simulate(
                model,
                prepare(signal(np.arange(8 * round(rate) + 1) / rate), rate, hold=hold),
            )
            middle = slice(round(3 * rate), round(5 * rate))
            reference = exact[:: round(256 / rate)][middle]
            errors.append(worst(found.displacement[0][middle], reference))
        assert np.log2(errors[0] / errors[1]) > order - 0.4


def test_upsampling_brings_the_linear_hold_to_the_band_limited_one():
    generator = np.random.default_rng(7)
    spectrum = np.zeros(513, complex)
    spectrum[5:60] = generator.standard_normal((55, 2)) @ [1.0, 1.0j]
    force = np.fft.irfft(spectrum, 1024) * np.hanning(1024)
    model = single(Spring(1000.0), Damper(damping=5.0))
    truth = simulate(model, prepare(force, 256.0, upsample=4)).displacement[0]
    errors = [
        worst(
            simulate(model, prepare(force, 256.0, upsample=k, hold="linear")).displacement[0],
            truth,
        )
        for k in (1, 2, 4, 8)
    ]
    assert np.all(np.diff(errors) < 0.0)
    assert errors[-1] < 5e-4
    assert worst(simulate(model, force, 256.0).displacement[0], truth) < 1e-5


def test_order_of_the_taylor_steps_against_their_tolerance():
    model = single(CubicStiffness(1e4), Spring(10.0), Damper(damping=0.1))
    signal = harmonic(3.0, 5.0)
    best = simulate(model, signal, 20.0, duration=5.0, tolerance=1e-15)
    for tolerance in (1e-6, 1e-9, 1e-12):
        found = simulate(model, signal, 20.0, duration=5.0, tolerance=tolerance)
        error = worst(found.displacement[0], best.displacement[0])
        assert error < 1e3 * tolerance * max(1.0, found.growth)
        assert error < found.error


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_a_chirp_may_be_missed_by_no_more_than_the_tolerance_and_the_error_says_so(tolerance):
    chirp = linear_sweep(0.0, 30.0, 10.0, 5.0)
    exact = prepare(chirp, 500.0, duration=10.0)
    given = prepare(chirp, 500.0, duration=10.0, tolerance=tolerance)
    assert given.pieces.shape[1] < exact.pieces.shape[1]
    assert worst(given.samples, chirp(np.arange(5001) / 500.0)) < tolerance
    best = simulate(GAP, exact, growth=False)
    found = simulate(GAP, chirp, 500.0, duration=10.0, tolerance=tolerance, growth=False)
    assert worst(found.displacement, best.displacement) < found.error < 100.0 * tolerance


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_a_loose_tolerance_finds_the_same_switchings(tolerance):
    """They are found on the series that carries the motion, not on a shorter one."""
    model = single(
        Gap(1000.0, 0.5e-3),
        CubicStiffness(1e6),
        CoulombFriction(1.0),
        Damper(damping_ratio=0.01),
    )
    chirp = linear_sweep(0.0, 30.0, 10.0, 5.0)
    best = simulate(model, chirp, 500.0, duration=10.0, growth=False)
    found = simulate(model, chirp, 500.0, duration=10.0, tolerance=tolerance, growth=False)
    assert found.solver == "Taylor series"
    assert abs(found.switchings - best.switchings) <= 0.01 * best.switchings


@pytest.mark.parametrize("exponent", [1.5, 2.2])
def test_a_power_that_is_not_whole_goes_to_dop853(exponent):
    model = single(PowerLaw(5.0, 0.01, exponent), Damper(damping=1.0))
    found = simulate(model, harmonic(2.0, 4.0), 200.0, duration=3.0, tolerance=1e-11)
    assert found.solver == "DOP853"
    reference = solve_ivp(
        lambda t, y: [
            y[1],
            4.0 * np.sin(4.0 * np.pi * t) - y[1]
            - 5.0 * np.abs(y[0] / 0.01) ** exponent * np.sign(y[0]),
        ],
        (0.0, 3.0), [0.0, 0.0], t_eval=found.time, rtol=1e-11, atol=1e-14, method="DOP853",
    ).y[0]  # fmt: skip
    assert worst(found.displacement[0], reference) < 1e-7
    with pytest.raises(ValueError, match="no Taylor series at 0"):
        simulate(model, harmonic(2.0, 4.0), 200.0, duration=3.0, solver="taylor")
    quick = simulate(
        model, harmonic(2.0, 4.0), 200.0, duration=3.0, tolerance=1e-9, solver="quick"
    )
    assert quick.solver == "Taylor series and DOP853"
    assert quick.error is None
    assert worst(quick.displacement[0], reference) < 1e-6


def test_an_input_is_prepared_once_for_many():
    given = prepare(np.sin(np.arange(1001) / 50.0), 100.0, upsample=2)
    assert given.samples.size == 1001
    assert_allclose(given.samples, np.sin(np.arange(1001) / 50.0), atol=1e-9)
    one = simulate(GAP, given)
    two = simulate(GAP, prepare(np.sin(np.arange(1001) / 50.0), 100.0, upsample=2))
    assert_allclose(one.displacement, two.displacement, rtol=0.0, atol=0.0)


@pytest.mark.parametrize(
    ("effects", "oscillator"),
    [
        (
            (Spring(1000.0), CoulombFriction(1.0)),
            long_double.Oscillator(1.0, DAMPING, 1000.0, friction=1.0),
        ),
        (
            (Gap(1000.0, 0.5e-3), CubicStiffness(1e6), CoulombFriction(1.0)),
            long_double.Oscillator(
                1.0, DAMPING, contact=1000.0, clearance=0.5e-3, cubic=1e6, friction=1.0
            ),
        ),
    ],
    ids=["Coulomb", "mixed"],
)
def test_friction_in_extended_precision(effects, oscillator):
    """A chirp of force: it slides, stops and sticks, alone and with play and a cubic spring."""
    interval = long_double.EXTENDED(1) / 500
    reference = long_double.respond(
        oscillator,
        lambda j, start, share: long_double.chirp_series(
            5.0, 1.0, (j + start) * interval, share * interval, cosine=True
        ),
        4000,
        interval,
    )
    chirp = linear_sweep(0.0, 30.0, 30.0, 5.0, 0.5 * np.pi)
    found = simulate(
        single(*effects, Damper(damping=float(DAMPING))), chirp, 500.0, duration=8.0
    )
    assert found.switchings > 20
    assert worst(found.displacement[0], reference.astype(float)) < 1e-12


def test_the_error_of_a_duffing_oscillator_is_at_least_the_true_one_and_not_ten_times():
    """DOP853 of scipy at 1e-13; stiffness, level, start and frequency at random."""
    generator, tolerances = np.random.default_rng(3), (1e-3, 1e-5, 1e-7, 1e-9)
    ratios = [ratios_of(generator, tolerances) for _ in range(6)]
    assert np.mean(np.array(ratios) >= 1.0) >= 0.95
    assert np.median(ratios) < 10.0
