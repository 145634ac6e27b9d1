"""The whole of a diagnosis on arrays: faults, linear model, candidates, pairs, decision."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose import faults as guesses
from shakerproc.diagnose.arrays import Correction, no_correction, prepare
from shakerproc.diagnose.decide import error_of, kinds, noise_floor, rank
from shakerproc.diagnose.fit import Fit, Priors
from shakerproc.diagnose.free_pairs import friction_pairs
from shakerproc.diagnose.free_run import friction_fits, least_floor
from shakerproc.diagnose.problem import Hypothesis, Parameters
from shakerproc.diagnose.screen import Regression, Start
from shakerproc.diagnose.search import (
    DRY,
    FLOOR,
    JUMPING,
    Bench,
    Context,
    annealed,
    build_screen,
    context,
    deviance,
    equation_linear,
    fineness,
    make_bench,
    plausible,
    refit,
)
from shakerproc.diagnose.sheet import Sheet, make_sheet, pairs, singles
from shakerproc.diagnose.structure import Structure
from shakerproc.diagnosis.data import TestArrays

Progress = Callable[[str], None]
LOOSE = 0.3
"""Share of the response that the first screening takes as not explained [-]."""
CLEARLY_TWO = 0.6
"""Share of what the best candidate leaves in the screening, below which pairs are fitted at
once: on tuning draws single effects stayed above it, but for strong quadratic stiffness [-]."""
BESIDE_FRICTION = 4
"""Effects that are tried beside a dry friction."""
UNSURE = 1.5
"""How much of the noise a free run may leave: what noise of the controls does to a contact is
an estimate [-]."""
PROMISED = 0.005
"""Share of the linear regression's cost that a candidate must save to be fitted at all [-]."""
PERHAPS_TWO = 0.8
"""The same, below which they are fitted where no single effect explains all [-]."""
PAIRS_TRIED = 6
"""Pairs of effects that are fitted at most."""
MATTERS = 0.05
"""Share of the squared residual that an effect must explain to be named [-]."""


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """What the search found, before it is put into words.

    Attributes
    ----------
    at : Context
        Bench and corrections of the final fits.
    linear : Fit
        The linear model (with the effects the model has), fitted.
    fits : tuple of Fit
        Hypotheses with one more effect or fault, best first.
    correction : Correction
        What was corrected before the fits.
    faults : dict
        Faults that stand, by sensor: kind to (sensor, numbers).
    starts : tuple of Start
        The screening.
    """

    at: Context
    linear: Fit
    fits: tuple[Fit, ...]
    correction: Correction
    faults: tuple[tuple[str, int, float], ...]
    starts: tuple[Start, ...]


def _bench(
    structure: Structure, tests: tuple[TestArrays, ...], fix: Correction, fine: int
) -> tuple[Bench, list[dict[int, float]]]:
    prepared, levels = [], []
    for i, test in enumerate(tests):
        ready, clip = prepare(test, i, fix, fine)
        prepared.append(ready)
        levels.append(clip)
    return make_bench(structure, tuple(prepared), fine, Priors()), levels


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """The tests under one correction of the sensors, screened."""

    fix: Correction
    bench: Bench
    levels: list[dict[int, float]]
    p: Parameters
    at: Context
    sheet: Sheet
    starts: list[Start]

    @property
    def linear_cost(self) -> float:
        """Cost of the linear regression."""
        return self.sheet.regression.cost

    def cost(self, starts: Sequence[Start] = ()) -> float:
        """Return the cost of the best regression, of these starts or of all single ones."""
        found = starts or self.starts
        return self.linear_cost - (found[0].gain if found else 0.0)

    def remaining(self, starts: Sequence[Start]) -> float:
        """Return the share of the response that the best of these starts leaves [-]."""
        left = max(self.cost(starts), 1.0)
        return self.at.loose * float(np.sqrt(left / self.sheet.regression.left.size))


def screened(
    structure: Structure, tests: tuple[TestArrays, ...], fix: Correction, start: Parameters
) -> Stage:
    """Return tests under a correction of the sensors, screened."""
    fine = max(fineness(structure, tests[0].sample_rate), 4)
    bench, levels = _bench(structure, tests, fix, fine)
    p = equation_linear(bench, start, LOOSE)
    at = context(bench, p, LOOSE)
    sheet = screen_sheet(at, p, judged_joints(structure))
    if sheet is None:
        raise FloatingPointError("the linear model is unstable")
    return Stage(fix, bench, levels, p, at, sheet, singles(sheet))


def screen_sheet(at: Context, p: Parameters, joints: tuple[int, ...]) -> Sheet | None:
    """Return the sheet of every candidate beside a linear model; None if it runs away."""
    screen = build_screen(at, p)
    return None if screen is None else make_sheet(screen, Regression(screen), joints)


def guess_faults(structure: Structure, tests: tuple[TestArrays, ...]) -> Correction | None:
    """Return a correction of gains, signs and delays that might be, or None.

    Only where one mass stands on the base can they be told without the physics being known.
    """
    if structure.masses.size != 1 or structure.forced >= 0:
        return None
    if any(s.order != 2 for s in structure.sensing):
        return None
    omega = float(np.sqrt(np.sum(structure.stiffness) / structure.masses[0]))
    used = [t for t in tests if not t.hold_out]
    gain, delay = np.ones(len(structure.sensing)), np.zeros(len(structure.sensing))
    doubtful = False
    for i in range(len(structure.sensing)):
        rate = used[0].sample_rate
        guess = guesses.sensor_guess(
            [np.mean(t.controls, axis=0) for t in used], [t.responses[i] for t in used],
            rate, omega, 0.01,
        )  # fmt: skip
        if guess is None:
            continue
        if guess.polarity < 0.0 or abs(np.log(guess.gain)) > 0.02 or abs(guess.delay) > 1.5e-5:
            doubtful = True
            gain[i] = guess.polarity * (guess.gain if abs(np.log(guess.gain)) > 0.02 else 1.0)
            delay[i] = guess.delay if abs(guess.delay) > 1e-5 else 0.0
    return Correction(gain, delay, {}) if doubtful else None


def investigate(
    structure: Structure, tests: tuple[TestArrays, ...], base: Hypothesis, start: Parameters,
    *, progress: Progress,
) -> Findings:  # fmt: skip
    """Return what the tests say of a structure.

    Where a sensor may have a wrong gain, sign or delay, physics is sought with and without that
    fault: a strong effect imitates one.
    """
    progress("linear model and screening")
    stages = [screened(structure, tests, no_correction(len(structure.sensing)), start)]
    guess = guess_faults(structure, tests)
    if guess is not None:
        other = _sharpened(screened(structure, tests, guess, start), structure, tests, start)
        stages.insert(0 if other.cost() < 0.35 * stages[0].cost() else 1, other)
    sides: list[Side] = []
    for stage in stages:
        side = _singles(stage, structure, tests, base, start, progress)
        sides.append(side)
        sound = bool(np.all(stage.fix.gain == 1.0) and np.all(stage.fix.delay == 0.0))
        rubbed = _rubbed(side, start, progress) if sound else None
        if rubbed is not None:
            return _finished(rubbed, structure, start, progress)
        if side.explained and (sound or not side.fits):
            break
    side = min(sides, key=lambda one: one.deviance)
    return _finished(side, structure, start, progress)


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """What one more effect explains under one correction of the sensors."""

    stage: Stage
    at: Context
    linear: Fit
    fits: list[Fit]
    faults: tuple[tuple[str, int, float], ...]

    @property
    def best(self) -> Fit:
        """The best of the fits, or the linear one."""
        return self.fits[0] if self.fits else self.linear

    @property
    def explained(self) -> bool:
        """Whether the best fit leaves little but noise."""
        return only_noise(self.at, self.best)

    @property
    def deviance(self) -> float:
        """Minus twice the logarithm of the likelihood of the samples as recorded."""
        gain = self.stage.fix.gain
        per_sensor = self.best.count / gain.size
        return deviance(self.best) + 2.0 * per_sensor * float(np.sum(np.log(np.abs(gain))))


def _singles(
    stage: Stage, structure: Structure, tests: tuple[TestArrays, ...], base: Hypothesis,
    start: Parameters, progress: Progress,
) -> Side:  # fmt: skip
    joints, fix = judged_joints(structure), stage.fix
    freed = tuple(("sensor_gain", i) for i, g in enumerate(fix.gain) if abs(g) != 1.0)
    freed += tuple(("sensor_delay", i) for i, d in enumerate(fix.delay) if d != 0.0)
    base = replace(base, faults=freed)
    progress("mains hum")
    hum = find_hum(stage.bench, stage.at, stage.p)
    if hum:
        stage = screened(structure, tests, replace(fix, hum=hum), start)
    found = [("mains_hum", sensor, lines[0][0]) for (_, sensor), lines in hum.items()]
    for level in stage.levels:
        found += [("clipping", sensor, value) for sensor, value in level.items()]
    progress("the linear model")
    at, p, cost = stage.at, stage.p, stage.linear_cost
    count = stage.sheet.regression.left.size
    final, linear = fit_base(stage.bench, at, p, base, cost, count)
    fits: list[Fit] = []
    promised = cost - stage.cost() > PROMISED * cost
    if promised and _worth(final, linear, joints):
        progress("the candidates")
        keep, both = plausible(stage.starts, cost), pairs(stage.sheet)
        best, more = keep[:1], []
        if both and stage.cost(both) < CLEARLY_TWO * stage.cost():
            keep, more = keep[:4], plausible(both, cost, 3, PAIRS_TRIED)
            best = more[:1]
        none = at.fit(base, p, stage.bench.short, 0)
        if keep and none is not None:
            others = (start, linear.parameters)
            final, fits = annealed(at, none, keep, stage.remaining(best), others, more=more)
    return Side(stage, final, linear, fits, tuple(found))


def _rubbed(side: Side, start: Parameters, progress: Progress) -> Side | None:
    """Return the same with dry friction found by free runs, if that explains all; or None."""
    if side.explained and not DRY.intersection(kinds(side.best)):
        return None
    progress("dry friction")
    searches = [friction_fits]
    if any(DRY.intersection(kinds(fit)) for fit in side.fits[:3]):
        searches.append(friction_pairs)
    perhaps = None
    for search in searches:
        found = search(side.stage.bench, start, side.linear, side.fits)
        if found is None or not DRY.intersection(kinds(found[1][0])):
            continue
        rubbed = replace(side, at=found[0], fits=found[1])
        left = _left(rubbed.at, rubbed.best, rubbed.at.bench)
        if left < UNSURE * least_floor(side.stage.bench, rubbed.best):
            return rubbed
        perhaps = perhaps or (rubbed if rubbed.explained else None)
    return perhaps


def _finished(
    side: Side, structure: Structure, start: Parameters, progress: Progress
) -> Findings:
    """Return the same after pairs were sought, fitted to the whole tests."""
    stage, final, fits, linear = side.stage, side.at, side.fits, side.linear
    if fits:
        progress("pairs")
        both = pair_search(final, fits[0], stage, linear, start)
        progress("the best candidates on whole tests")
        near = [f for f in fits if deviance(f) < deviance(fits[0]) + 0.1 * f.count][:4]
        if both is not None:
            final, near = both[0], [both[1], fits[0]]
        fits = refit(final, near, final.bench.fitted(), 2, sensors=True)
        # the short stretches may have shown little of what the whole tests show
        fits = [*refit(final, fits[:1], final.bench.fitted(), 6, sensors=True), *fits[1:]]
    whole = final.fit(
        linear.hypothesis, linear.parameters, final.bench.fitted(), 3, sensors=True
    )
    return Findings(
        final, whole or linear, tuple(fits), stage.fix, side.faults, tuple(stage.starts)
    )


def _sharpened(
    stage: Stage, structure: Structure, tests: tuple[TestArrays, ...], start: Parameters
) -> Stage:
    """Return a stage after its delays have been found to a microsecond or so."""
    late = np.flatnonzero(stage.fix.delay)
    if late.size == 0:
        return stage
    free = Hypothesis((), tuple(("sensor_delay", int(i)) for i in late))
    fix, bench, p = stage.fix, stage.bench, stage.p
    fine = bench.whole[0].fine
    for _ in range(4):
        fit = context(bench, p, 0.02).fit(free, p, bench.short, 3)
        if fit is None:
            break
        fix = replace(
            fix, delay=fix.delay + np.where(fix.delay != 0.0, fit.parameters.delay, 0.0)
        )
        bench, _ = _bench(structure, tests, fix, fine)
        p = replace(fit.parameters, delay=np.zeros_like(fix.delay), gain=np.ones_like(fix.gain))
        if np.max(np.abs(fit.parameters.delay)) < 1e-6:
            break
    return screened(structure, tests, fix, start)


def only_noise(at: Context, fit: Fit) -> bool:
    """Return whether a fit leaves little but noise.

    Either what it leaves is no larger than the noise of the sensors, or it leaves what was
    expected of it where the model is allowed to miss far less than that noise. Beside the jumps
    of dry friction samples miss by far, so there it suffices that the model may miss little.
    """
    if at.bench.free:
        return _left(at, fit, at.bench) < UNSURE * noise_floor(at.bench.short, at.bench)
    if DRY.intersection(kinds(fit)) and at.loose <= JUMPING:
        return True
    floor = noise_floor(at.bench.short, at.bench)
    strict = at.loose <= max(2.0 * FLOOR, 0.3 * floor) and fit.cost < 1.3 * fit.count
    return strict or _left(at, fit, at.bench) < 1.25 * floor


def pair_search(
    at: Context, best: Fit, stage: Stage, linear: Fit, start: Parameters
) -> tuple[Context, Fit] | None:
    """Return the best pair of effects, where one effect leaves more than the noise."""
    if only_noise(at, best) or len(best.hypothesis.terms) > len(linear.hypothesis.terms) + 1:
        return None
    both = pairs(stage.sheet)
    starts = _beside_friction(both, best)
    if not starts and both and stage.cost(both) < PERHAPS_TWO * stage.cost():
        starts = plausible(both, stage.linear_cost, 3, PAIRS_TRIED)
    none = stage.at.fit(linear.hypothesis, stage.p, stage.bench.short, 0)
    if not starts or none is None:
        return None
    others = (start, linear.parameters, replace(best.parameters, values=()))
    final, fits = annealed(stage.at, none, starts, stage.remaining(starts), others, 2)
    if not fits:
        return None
    chosen = rank(fits)[0]
    if _left(final, chosen, final.bench) > 0.75 * _left(at, best, at.bench):
        return None
    gained = deviance(best) - deviance(chosen)
    return (final, chosen) if gained > max(100.0, 0.1 * best.count) else None


def _beside_friction(both: list[Start], best: Fit) -> list[Start]:
    """Return pairs with the dry friction that explains most by itself, with its force; or none.

    Friction hides what moves beside it from the screening: of the pairs without it little is
    to be expected.
    """
    term = best.hypothesis.terms[-1]
    if term.candidate.kind not in DRY:
        return []
    force = (best.parameters.values[-1][0],)
    starts = [
        s for s in both
        if s.last.candidate.kind == "coulomb_friction" and s.last.joint == term.joint
    ][:BESIDE_FRICTION]  # fmt: skip
    return [
        replace(s, parts=(*s.parts[:-1], replace(s.last, values=force, guesses=())))
        for s in starts
    ]


def _left(at: Context, fit: Fit, bench: Bench) -> float:
    """Return the rms of the innovations over that of the response, over the short stretches."""
    return error_of(at, fit.hypothesis, fit.parameters, bench.short, robust=bench.free)


def fit_base(
    bench: Bench, at: Context, p: Parameters, base: Hypothesis, cost: float, count: int
) -> tuple[Context, Fit]:
    """Return the linear model fitted as tightly as its likelihood allows."""
    loose = max(FLOOR, LOOSE * float(np.sqrt(cost / count)))
    at = context(bench, p, loose)
    fit = at.fit(base, p, bench.short, 4)
    if fit is None:
        raise FloatingPointError("the linear model is unstable")
    for _ in range(6):
        if at.loose <= FLOOR:
            break
        new = at.loose * float(np.sqrt(fit.cost / fit.count))
        new = max(FLOOR, new if new < 0.5 * at.loose else 0.3 * at.loose)
        tighter = context(bench, p, new)
        tried = tighter.fit(base, fit.parameters, bench.short, 4)
        if tried is None or deviance(tried) > deviance(fit):
            break
        at, fit = tighter, tried
    return at, fit


def _worth(at: Context, linear: Fit, joints: tuple[int, ...]) -> bool:
    """Return whether any candidate could explain enough beside the linear fit."""
    if at.loose > max(FLOOR, noise_floor(at.bench.short, at.bench)):
        return True
    sheet = screen_sheet(at, linear.parameters, joints)
    if sheet is None:
        return True
    starts = singles(sheet)
    return bool(starts) and starts[0].gain > 0.5 * MATTERS * sheet.regression.cost


def judged_joints(structure: Structure) -> tuple[int, ...]:
    """Return the joints whose sides all carry sensors (or are the base)."""
    seen = {s.mass for s in structure.sensing} | {-1}
    out = [i for i, j in enumerate(structure.joints) if j.a in seen and j.b in seen]
    return tuple(out or range(len(structure.joints)))


def find_hum(
    bench: Bench, at: Context, p: Parameters
) -> dict[tuple[int, int], tuple[tuple[float, float, float], ...]]:
    """Return mains lines in the responses, by test and sensor."""
    from shakerproc.diagnose.problem import law_table, run
    from shakerproc.diagnose.structure import hold, matrices

    linear = bench.structure.with_linear(p.stiffness, p.damping)
    table = law_table(linear, Hypothesis(), p, linear.masses.size)
    votes: dict[int, dict[float, int]] = {}
    residuals: dict[tuple[int, int], FloatArray] = {}
    for segment in bench.whole:
        seen = run(linear, table, segment, at.tunings[segment.gain_key], p)
        if seen is None:
            return {}
        for sensor, row in enumerate(seen.innovations):
            residuals[segment.test, sensor] = row
            found = guesses.hum_lines(row, segment.sample_rate)
            if found is not None:
                own = votes.setdefault(sensor, {})
                own[found[0]] = own.get(found[0], 0) + 1
    out = {}
    system = matrices(linear)
    for sensor, own in votes.items():
        mains, count = max(own.items(), key=lambda item: item[1])
        if count < max(2, len(bench.whole) // 2) and len(bench.whole) > 1:
            continue
        for segment in bench.whole:
            tuned = at.tunings[segment.gain_key]
            phi, _, _ = hold(system.state, system.input[:, None], 1.0 / segment.sample_rate)
            closed = phi @ (np.eye(phi.shape[0]) - tuned.gain @ system.out)
            row = residuals[segment.test, sensor] * tuned.sigma[sensor]
            lines = []
            n = row.size
            t = np.arange(n) / segment.sample_rate
            window = np.hanning(n)
            for harmonic in range(1, 11):
                f = mains * harmonic
                if f > 0.45 * segment.sample_rate:
                    break
                z = np.exp(2j * np.pi * f / segment.sample_rate)
                inner = np.linalg.solve(
                    z * np.eye(phi.shape[0]) - closed, phi @ tuned.gain[:, [sensor]]
                )
                transfer = 1.0 - (system.out[sensor] @ inner)[0]
                turning = np.exp(-2j * np.pi * f * t)
                value = 2.0 * np.sum(row * window * turning) / np.sum(window)
                side = [
                    abs(
                        2.0
                        * np.sum(row * window * np.exp(-2j * np.pi * (f + d) * t))
                        / np.sum(window)
                    )
                    ** 2
                    for d in (-3.1, -1.7, -0.9, 0.9, 1.7, 3.1)
                ]
                if abs(value) ** 2 > 15.0 * np.mean(side):
                    own_line = value / transfer
                    lines.append((f, float(own_line.real), float(-own_line.imag)))
            if lines:
                out[segment.test, sensor] = tuple(lines)
    return out
