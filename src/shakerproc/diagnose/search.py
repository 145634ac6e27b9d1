"""The search: linear fit, screening of every candidate, likelihood of the best, pairs."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose.candidates import library
from shakerproc.diagnose.fit import Fit, Priors, levenberg
from shakerproc.diagnose.prepare import Prepared
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    Term,
    Tuning,
    assemble,
    cut,
    full_segment,
    reduced_mass,
    tuning,
)
from shakerproc.diagnose.screen import (
    Regression,
    Screen,
    Start,
    motion_scales,
    prepare_screen,
    try_attached,
    try_candidate,
)
from shakerproc.diagnose.structure import Structure

SEGMENT_SECONDS = 3.5
FLOOR = 5e-4
"""Share of the response that no model is expected to explain [-]."""


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """A structure with its tests, whole and in short, and the noise of every test."""

    structure: Structure
    prepared: tuple[Prepared, ...]
    whole: tuple[Segment, ...]
    short: tuple[Segment, ...]
    rms: FloatArray
    priors: Priors

    def fitted(self) -> tuple[Segment, ...]:
        """Return the whole tests that may be fitted to."""
        return tuple(s for s in self.whole if not s.hold_out)

    def kept(self) -> tuple[Segment, ...]:
        """Return the whole tests that are only scored."""
        return tuple(s for s in self.whole if s.hold_out)

    def tunings(self, structure: Structure, loose: float = FLOOR) -> tuple[Tuning, ...]:
        """Return the correction of every test for a linear structure.

        `loose` is the acceleration that the model is expected to miss, as a share of the rms
        of the response: the larger, the more the observer follows the measurement.
        """
        return tuple(
            tuning(
                structure, p.sample_rate, p.noise, p.input_noise, float(loose * rms), float(rms)
            )
            for p, rms in zip(self.prepared, self.rms, strict=True)
        )


def fineness(structure: Structure, sample_rate: float) -> int:
    """Return fine steps per sample such that the fastest mode turns 0.12 rad in one."""
    from shakerproc.diagnose.structure import matrices

    fastest = float(np.max(np.abs(np.linalg.eigvals(matrices(structure).state))))
    return int(np.clip(np.ceil(fastest / sample_rate / 0.12), 1, 6))


def windows(prepared: Prepared, seconds: float) -> list[tuple[int, int]]:
    """Return the stretches of a test that stand for it: one where it is loud, or three."""
    rate, n = prepared.sample_rate, prepared.measured.shape[1]
    size = int(seconds * rate)
    if n <= size:
        return [(0, n)]
    block = int(0.5 * rate)
    count = n // block
    level = (
        np.sum(prepared.measured[:, : count * block] ** 2, axis=0).reshape(count, block).sum(1)
    )
    if np.median(level) > 0.35 * np.mean(level):
        third = size // 3
        first = int(0.08 * n)
        starts = np.linspace(first, n - third - int(0.04 * n), 3).astype(int)
        return [(int(s), int(s) + third) for s in starts]
    width = size // block
    sums = np.convolve(level, np.ones(width), "valid")
    start = int(np.argmax(sums)) * block
    return [(start, min(start + size, n))]


def short_segments(
    whole: tuple[Segment, ...], prepared: tuple[Prepared, ...]
) -> tuple[Segment, ...]:
    """Return the short stretches of the tests that may be fitted to."""
    out = []
    for segment in whole:
        if segment.hold_out:
            continue
        for start, stop in windows(prepared[segment.test], SEGMENT_SECONDS):
            out.append(cut(segment, start, stop, int(0.15 * segment.sample_rate)))
    return tuple(out)


def blend_frequency(prepared: Prepared, structure: Structure, omega: float) -> float:
    """Return from where on integrated accelerations are known to 1 % of the motion [Hz]."""
    noise2 = (np.mean(prepared.noise**2) + prepared.input_noise**2) / (
        prepared.sample_rate / 2.0
    )
    rms = float(np.sqrt(np.mean(prepared.measured**2))) / omega**2
    cube = noise2 / (3.0 * (2.0 * np.pi) ** 4 * (0.01 * rms) ** 2)
    own = omega / (2.0 * np.pi)
    return float(np.clip(np.cbrt(cube), 0.1 * own, 0.7 * own))


def linear_start(bench: Bench) -> Parameters:
    """Return the nominal parameters."""
    s = bench.structure
    n = len(s.sensing)
    return Parameters(s.stiffness.copy(), s.damping.copy(), np.ones(n), np.zeros(n))


def equation_linear(
    bench: Bench, p: Parameters, loose: float = 0.3, rounds: int = 3
) -> Parameters:
    """Return stiffness and damping by regression, with an observer that follows closely."""
    for _ in range(rounds):
        at = context(bench, p, loose)
        screen = build_screen(at, p, tuple(range(len(bench.structure.joints))))
        if screen is None:
            return p
        weights = Regression(screen).weights
        n = p.stiffness.size
        pairs = weights[: 2 * n].reshape(n, 2)
        p = replace(
            p,
            stiffness=p.stiffness * np.clip(1.0 + pairs[:, 0], 0.2, 5.0),
            damping=p.damping * np.clip(1.0 + pairs[:, 1], 0.1, 10.0),
        )
    return p


@dataclass(frozen=True, slots=True, eq=False)
class Context:
    """Bench with the corrections that every hypothesis is judged with."""

    bench: Bench
    reference: Structure
    tunings: tuple[Tuning, ...]
    loose: float
    filtered: bool = False

    def tuned(self, hypothesis: Hypothesis, p: Parameters) -> tuple[Tuning, ...]:
        """Return corrections for a hypothesis: with an attached mode they know of it."""
        if all(term.candidate.kind != "attached_mode" for term in hypothesis.terms):
            return self.tunings
        at = replace(p, stiffness=self.reference.stiffness, damping=self.reference.damping)
        return self.bench.tunings(assemble(self.bench.structure, hypothesis, at), self.loose)

    def fit(self, hypothesis: Hypothesis, start: Parameters, segments: tuple[Segment, ...],
            iterations: int, *, sensors: bool = False) -> Fit | None:  # fmt: skip
        """Return a hypothesis fitted."""
        return levenberg(
            self.bench.structure, hypothesis, start, segments, self.tuned(hypothesis, start),
            priors=self.bench.priors, iterations=iterations, sensors=sensors,
            filtered=self.filtered,
        )  # fmt: skip


def context(
    bench: Bench, linear: Parameters, loose: float = FLOOR, *, filtered: bool = False
) -> Context:
    """Return the context around a linear fit."""
    reference = bench.structure.with_linear(linear.stiffness, linear.damping)
    return Context(bench, reference, bench.tunings(reference, loose), loose, filtered)


def build_screen(at: Context, p: Parameters, joints: tuple[int, ...]) -> Screen | None:
    """Return the screening of a linear fit."""
    omega = _strongest(at)
    blend = max(
        blend_frequency(prepared, at.reference, omega)
        for prepared in at.bench.prepared
        if not prepared.hold_out
    )
    return prepare_screen(
        at.bench.structure, p, at.bench.whole, at.bench.short, at.tunings, blend, joints
    )


def _strongest(at: Context) -> float:
    from shakerproc.diagnose.structure import matrices

    return float(np.min(np.abs(np.linalg.eigvals(matrices(at.reference).state))))


def screen_all(screen: Screen, regression: Regression, joints: tuple[int, ...],
               extra: int = 1) -> list[Start]:  # fmt: skip
    """Return the best starts of every candidate in every joint, best first."""
    jobs = []
    for joint in joints:
        motion = motion_scales(screen, joint, screen.segments[0].sample_rate)
        for candidate in library(motion):
            jobs.append((candidate, joint, motion))

    def work(job):  # type: ignore[no-untyped-def]
        candidate, joint, motion = job
        if candidate.kind == "attached_mode":
            mass = screen.structure.joints[joint].b
            at = next(
                (
                    i
                    for i, s in enumerate(screen.structure.sensing)
                    if s.mass == mass and s.order == 2
                ),
                None,
            )
            if at is None:
                return []
            return try_attached(screen, regression, candidate, joint, motion, at)[:extra]
        return try_candidate(screen, regression, candidate, joint, motion)[:extra]

    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(work, jobs))
    return sorted((start for found in results for start in found), key=lambda s: -s.gain)


def parameters_of(
    start: Start, base: Parameters, values: tuple[tuple[float, ...], ...] = ()
) -> Parameters:
    """Return parameters to start a fit from."""
    return Parameters(
        np.array(start.stiffness), np.array(start.damping), base.gain.copy(), base.delay.copy(),
        (*values, start.values),
    )  # fmt: skip


def term_in(structure: Structure, start: Start) -> Term:
    """Return the term of a start."""
    mass = reduced_mass(structure, structure.joints[start.joint])
    return Term(start.candidate, start.joint, mass)


def fit_starts(at: Context, base: Fit, starts: list[Start], segments: tuple[Segment, ...],
               iterations: int, others: tuple[Parameters, ...] = ()) -> list[Fit]:  # fmt: skip
    """Return the fits of starts beside the terms that a base has already, best first.

    Each begins where the likelihood is best: at the screening's numbers, or at the further
    guesses of its candidate beside the linear numbers of `others`.
    """

    def work(start: Start) -> Fit | None:
        hypothesis = Hypothesis(
            (*base.hypothesis.terms, term_in(at.bench.structure, start)), base.hypothesis.faults
        )
        firsts = [parameters_of(start, base.parameters, base.parameters.values)]
        for other in others:
            firsts.append(replace(other, values=(*base.parameters.values, start.values)))
            firsts += [
                replace(other, values=(*base.parameters.values, guess))
                for guess in start.guesses
            ]
        first = firsts[0]
        if len(firsts) > 1:
            tried = [at.fit(hypothesis, one, segments, 0) for one in firsts]
            scored = [(deviance(f), i) for i, f in enumerate(tried) if f is not None]
            if not scored:
                return None
            first = firsts[min(scored)[1]]
        return at.fit(hypothesis, first, segments, iterations)

    with ThreadPoolExecutor(2) as pool:
        fits = [fit for fit in pool.map(work, starts) if fit is not None]
    return sorted(fits, key=deviance)


def plausible(starts: list[Start], cost: float, least: int = 4, most: int = 8) -> list[Start]:
    """Return the starts worth a fit: those that come near the best of them."""
    best = max(cost - starts[0].gain, 1e-12 * cost)
    keep = [s for i, s in enumerate(starts) if i < least or cost - s.gain < 8.0 * best][:most]
    friction = [s for s in starts if s.guesses and s not in keep]
    return keep + (friction if best > 0.3 * cost else [])


def annealed(at: Context, base: Fit, starts: list[Start], cost: float, count: int,
             others: tuple[Parameters, ...] = ()) -> tuple[Context, list[Fit]]:  # fmt: skip
    """Return the fits of starts, the observer held ever less to the measurement.

    A far start cannot predict long motions; so the correction begins as loose as the best
    regression was wrong, and tightens as long as the likelihood of the best fit grows.
    """
    bench = at.bench
    loose = at.loose * float(np.sqrt(max(cost - starts[0].gain, 1.0) / count))
    at = context(bench, base.parameters, min(max(FLOOR, loose), 0.1))
    fits = fit_starts(at, base, starts, bench.short, 3, others)
    fits = [f for f in fits if f.cost < 6.0 * fits[0].cost][:6]
    for _ in range(8):
        if not fits:
            break
        best = fits[0]
        if not at.filtered:
            with_filter = replace(at, filtered=True)
            again = with_filter.fit(best.hypothesis, best.parameters, bench.short, 2)
            if again is not None and deviance(again) < deviance(best) - 20.0:
                at = with_filter
                fits = refit(at, fits, bench.short, 3)
                continue
        if at.loose <= FLOOR:
            break
        new = at.loose * float(np.sqrt(best.cost / best.count))
        new = max(FLOOR, new if new < 0.5 * at.loose else 0.3 * at.loose)
        tighter = context(bench, base.parameters, new, filtered=at.filtered)
        near = [f for f in fits if f.cost < 4.0 * best.cost][:5]
        tried = refit(tighter, near, bench.short, 4)
        if not tried or deviance(tried[0]) > deviance(best):
            break
        at, fits = tighter, tried
    return at, fits


def deviance(fit: Fit) -> float:
    """Return minus twice the logarithm of the likelihood."""
    return fit.cost + fit.logs


def refit(at: Context, fits: list[Fit], segments: tuple[Segment, ...], iterations: int,
          *, sensors: bool = False) -> list[Fit]:  # fmt: skip
    """Return fits carried on, best first."""

    def work(fit: Fit) -> Fit | None:
        return at.fit(fit.hypothesis, fit.parameters, segments, iterations, sensors=sensors)

    with ThreadPoolExecutor(2) as pool:
        new = [fit for fit in pool.map(work, fits) if fit is not None]
    return sorted(new, key=deviance)


def make_bench(
    structure: Structure, prepared: tuple[Prepared, ...], fine: int, priors: Priors
) -> Bench:
    """Return a bench."""
    whole = tuple(full_segment(p, i, fine) for i, p in enumerate(prepared))
    short = short_segments(whole, prepared)
    rms = np.array([float(np.sqrt(np.mean(p.measured**2))) for p in prepared])
    return Bench(structure, prepared, whole, short, rms, priors)
