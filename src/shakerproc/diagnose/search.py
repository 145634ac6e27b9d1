"""The search: linear fit, screening of every candidate, likelihood of the best, pairs."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose.fit import (
    Fit,
    Lens,
    Priors,
    compass,
    levenberg,
    settled,
    unaided,
    whitened,
)
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
    unaided_tuning,
)
from shakerproc.diagnose.screen import (
    Part,
    Regression,
    Screen,
    Start,
    prepare_screen,
)
from shakerproc.diagnose.structure import Structure, angular_frequencies

SEGMENT_SECONDS = 3.5
FLOOR = 5e-4
"""Share of the response that no model is expected to explain [-]."""


JUMPING = 2e-3
"""Share of the response that a model with dry friction may miss and be taken as whole [-]."""
DRY = frozenset({"coulomb_friction", "stribeck_friction"})
"""Effects under which a contact sticks."""


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """A structure with its tests, whole and in short, and the noise of every test.

    Where it is `free`, the motion is foretold from the start of the tests on, and the
    measurement does not correct it.
    """

    structure: Structure
    prepared: tuple[Prepared, ...]
    whole: tuple[Segment, ...]
    short: tuple[Segment, ...]
    rms: FloatArray
    priors: Priors
    free: bool = False

    def fitted(self) -> tuple[Segment, ...]:
        """Return what may be fitted to: whole tests, or two of three blocks if none is kept."""
        if self.marked:
            return tuple(s for s in self.whole if not s.hold_out)
        if self.free:
            return tuple(masked(s, kept=False) for s in self.whole)
        return tuple(piece for s in self.whole for piece in blocks(s, kept=False))

    def kept(self) -> tuple[Segment, ...]:
        """Return what is only scored: the tests held out, or every third block of all."""
        if self.marked:
            return tuple(s for s in self.whole if s.hold_out)
        if self.free:
            return tuple(masked(s, kept=True) for s in self.whole)
        return tuple(piece for s in self.whole for piece in blocks(s, kept=True))

    @property
    def marked(self) -> bool:
        """Whether a test is held out."""
        return any(s.hold_out for s in self.whole)

    def quieter(self, factor: FloatArray) -> "Bench":
        """Return the same with the noise of the sensors of every test times a factor."""
        prepared = tuple(
            replace(p, noise=p.noise * f) for p, f in zip(self.prepared, factor, strict=True)
        )
        return replace(self, prepared=prepared)

    def tunings(self, structure: Structure, loose: float = FLOOR) -> tuple[Tuning, ...]:
        """Return the correction of every test for a linear structure.

        `loose` is the acceleration that the model is expected to miss, as a share of the rms
        of the response: the larger, the more the observer follows the measurement.
        """
        if self.free:
            return tuple(unaided_tuning(structure, p.noise) for p in self.prepared)
        return tuple(
            tuning(
                structure, p.sample_rate, p.noise, p.input_noise, float(loose * rms), float(rms)
            )
            for p, rms in zip(self.prepared, self.rms, strict=True)
        )


def fineness(structure: Structure, sample_rate: float) -> int:
    """Return fine steps per sample such that the fastest mode turns 0.12 rad in one."""
    fastest = float(angular_frequencies(structure)[-1])
    return int(np.clip(np.ceil(fastest / sample_rate / 0.12), 1, 6))


def blocks(segment: Segment, *, kept: bool) -> list[Segment]:
    """Return every third block of a test, or the pairs of blocks between them.

    The observer runs in before it counts.
    """
    n, rate = segment.measured.shape[1], segment.sample_rate
    size = block_size(n, rate)
    edges = range(0, n, 3 * size)
    ends = [(i + 2 * size, i + 3 * size) if kept else (i, i + 2 * size) for i in edges]
    run_in = round(0.15 * rate)
    out = []
    for start, stop in ends:
        first = max(start - run_in, 0) if kept else start
        if min(stop, n) - first > 2 * run_in:
            skip = max(run_in, segment.skip - first)
            out.append(cut(segment, first, min(stop, n), skip))
    return [piece for piece in out if piece.skip < piece.measured.shape[1] - run_in]


def block_size(n: int, sample_rate: float) -> int:
    """Return how many samples a block has: a second, or a ninth of a shorter test."""
    return max(min(round(sample_rate), n // 9), round(0.3 * sample_rate))


def masked(segment: Segment, *, kept: bool) -> Segment:
    """Return a whole test of which only the blocks count that are kept aside, or the others."""
    n = segment.measured.shape[1]
    aside = np.arange(n) // block_size(n, segment.sample_rate) % 3 == 2
    return replace(segment, weight=segment.weight * (aside if kept else ~aside))


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
    marked = any(segment.hold_out for segment in whole)
    for segment in whole:
        if segment.hold_out:
            continue
        run_in = int(0.15 * segment.sample_rate)
        for start, stop in windows(prepared[segment.test], SEGMENT_SECONDS):
            if marked:
                out.append(cut(segment, start, stop, run_in))
                continue
            for piece in blocks(segment, kept=False):
                first = max(start, piece.start)
                last = min(stop, piece.start + piece.measured.shape[1])
                if last - first > 2 * run_in:
                    out.append(cut(segment, first, last, run_in))
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


def equation_linear(
    bench: Bench, p: Parameters, loose: float = 0.3, rounds: int = 3
) -> Parameters:
    """Return stiffness and damping by regression, with an observer that follows closely."""
    for _ in range(rounds):
        at = context(bench, p, loose)
        screen = build_screen(at, p)
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
    lens: Lens | None = None

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
            filtered=self.filtered, lens=self.lens,
        )  # fmt: skip

    def judged(
        self, hypothesis: Hypothesis, p: Parameters, segments: tuple[Segment, ...], *,
        robust: bool = True,
    ) -> tuple[list[FloatArray], float] | None:  # fmt: skip
        """Return the whitened innovations of segments and the sum of their logarithms."""
        structure, tunings = self.bench.structure, self.tuned(hypothesis, p)
        alone = self.filtered and unaided(tunings)
        beyond = None
        if self.filtered and not alone:
            beyond = settled(structure, hypothesis, p, segments, tunings, rounds=2)
        return whitened(
            structure, hypothesis, p, segments, tunings, beyond, robust=robust, filtered=alone
        )

    def height(
        self, hypothesis: Hypothesis, p: Parameters, segments: tuple[Segment, ...]
    ) -> float:
        """Return the deviance of parameters, infinite where the run blows up."""
        tunings = self.tuned(hypothesis, p)
        seen = whitened(
            self.bench.structure, hypothesis, p, segments, tunings, lens=self.lens,
            filtered=self.filtered and unaided(tunings),
        )  # fmt: skip
        if seen is None:
            return float("inf")
        return float(sum(np.vdot(part, part) for part in seen[0])) + seen[1]

    def valley(
        self, hypothesis: Hypothesis, start: Parameters, *, reach: float = 1.0,
        rounds: int = 9, always: bool = False,
    ) -> Parameters:  # fmt: skip
        """Return where to begin a fit: the start itself, or lower where the way is rugged.

        Dry friction by itself under one mass is sought by free runs, which need no such help.
        """
        dry = DRY.intersection(term.candidate.kind for term in hypothesis.terms)
        alone = len(hypothesis.terms) == 1 and self.bench.structure.masses.size == 1
        if not always and (not dry or alone):
            return start
        tunings = self.tuned(hypothesis, start)
        return compass(
            self.bench.structure, hypothesis, start, self.bench.short, tunings,
            rounds=rounds, reach=reach, lens=self.lens,
        )  # fmt: skip


def context(
    bench: Bench, linear: Parameters, loose: float = FLOOR, *, filtered: bool = False
) -> Context:
    """Return the context around a linear fit."""
    reference = bench.structure.with_linear(linear.stiffness, linear.damping)
    return Context(bench, reference, bench.tunings(reference, loose), loose, filtered)


def build_screen(at: Context, p: Parameters) -> Screen | None:
    """Return the screening of a linear fit."""
    omega = float(angular_frequencies(at.reference)[0])
    blend = max(
        blend_frequency(prepared, at.reference, omega)
        for prepared in at.bench.prepared
        if not prepared.hold_out
    )
    return prepare_screen(
        at.bench.structure, p, at.bench.whole, at.bench.short, at.tunings, blend
    )


def parameters_of(
    start: Start, base: Parameters, last: tuple[float, ...] | None = None
) -> Parameters:
    """Return parameters to start a fit from; `last` stands in for its last numbers."""
    return Parameters(
        np.array(start.stiffness), np.array(start.damping), base.gain.copy(), base.delay.copy(),
        (*base.values, *values_of(start, last)),
    )  # fmt: skip


def values_of(
    start: Start, last: tuple[float, ...] | None = None
) -> tuple[tuple[float, ...], ...]:
    """Return the numbers of every candidate of a start; `last` stands in for the last."""
    *first, own = (part.values for part in start.parts)
    return (*first, own if last is None else last)


def term_in(structure: Structure, part: Part) -> Term:
    """Return the term of a part of a start."""
    mass = reduced_mass(structure, structure.joints[part.joint])
    return Term(part.candidate, part.joint, mass)


def fit_starts(at: Context, base: Fit, starts: list[Start], segments: tuple[Segment, ...],
               iterations: int, others: tuple[Parameters, ...] = ()) -> list[Fit]:  # fmt: skip
    """Return the fits of starts beside the terms that a base has already, best first.

    Each begins where the likelihood is best: at the screening's numbers, or at the further
    guesses of its candidate beside the linear numbers of `others`.
    """

    def work(start: Start) -> Fit | None:
        terms = (term_in(at.bench.structure, part) for part in start.parts)
        hypothesis = Hypothesis((*base.hypothesis.terms, *terms), base.hypothesis.faults)
        known = base.parameters.values
        firsts = [parameters_of(start, base.parameters)]
        for other in others:
            firsts.append(replace(other, values=(*known, *values_of(start))))
            firsts += [
                replace(other, values=(*known, *values_of(start, guess)))
                for guess in start.last.guesses
            ]
        first = firsts[0]
        if len(firsts) > 1:
            tried = [at.fit(hypothesis, one, segments, 0) for one in firsts]
            scored = [(deviance(f), i) for i, f in enumerate(tried) if f is not None]
            if not scored:
                return None
            first = firsts[min(scored)[1]]
        return at.fit(hypothesis, at.valley(hypothesis, first), segments, iterations)

    with ThreadPoolExecutor(2) as pool:
        fits = [fit for fit in pool.map(work, starts) if fit is not None]
    return sorted(fits, key=deviance)


def plausible(starts: list[Start], cost: float, least: int = 4, most: int = 8) -> list[Start]:
    """Return the starts worth a fit: those that come near the best of them."""
    best = max(cost - starts[0].gain, 1e-12 * cost)
    keep = [s for i, s in enumerate(starts) if i < least or cost - s.gain < 8.0 * best][:most]
    friction = [s for s in starts if s.last.guesses and s not in keep]
    return keep + (friction if best > 0.3 * cost else [])


def annealed(
    at: Context, base: Fit, starts: list[Start], remaining: float,
    others: tuple[Parameters, ...] = (), most: int = 3, more: Sequence[Start] = (),
) -> tuple[Context, list[Fit]]:  # fmt: skip
    """Return the fits of starts, the observer held ever less to the measurement.

    A far start cannot predict long motions; so the correction begins as loose as the best
    regression was wrong, and tightens as long as the likelihood grows. The `most` best are
    carried on by themselves; where the best of them ends, all are compared. `remaining` is the
    share of the response that the best regression left. Where the starts miss by far more than
    that, `more` join them.
    """
    bench = at.bench
    at = context(bench, base.parameters, min(max(FLOOR, remaining), 0.1))
    fits = fit_starts(at, base, starts, bench.short, 3, others)
    if more and (not fits or fits[0].cost > 1.5 * fits[0].count):
        starts = [*starts, *more]
        fits += fit_starts(at, base, list(more), bench.short, 3, others)
    fits = sorted([*fits, *nested_fits(at, base, starts, fits)], key=deviance)
    fits = one_of_each(fits)
    fits = [f for f in fits if f.cost < 6.0 * fits[0].cost][:6]
    if not fits:
        return at, fits
    near = [f for f in fits if f.cost < 3.0 * fits[0].cost][:most]
    with ThreadPoolExecutor(2) as pool:
        ends = list(pool.map(lambda fit: tightened(at, fit, base.parameters), near))
    ends.sort(key=lambda end: deviance(end[1]))
    final, best = ends[0]
    rest = [e[1] for e in ends[1:]] + [
        f for f in fits if f not in near and f.cost < 4.0 * fits[0].cost
    ]
    again = [best, *refit(final, rest, bench.short, 4)]
    again += nested_fits(final, base, starts, sorted(again, key=deviance))
    return final, one_of_each(sorted(again, key=deviance))


def nested_fits(at: Context, base: Fit, starts: list[Start], fits: list[Fit]) -> list[Fit]:
    """Return fits of candidates that begin where a simpler one has ended."""
    known = {names(f.hypothesis.terms): f for f in reversed(fits)}
    jobs = []
    for start in starts:
        before, part = names(start.parts)[:-1], start.last
        for kind, guess in part.candidate.nested.items():
            simpler = known.get((*names(base.hypothesis.terms), *before, (kind, part.joint)))
            if simpler is not None:
                guesses = guess(simpler.parameters.values[-1], part.motion)
                jobs.append((part, simpler, guesses))

    def work(job: tuple[Part, Fit, list[tuple[float, ...]]]) -> Fit | None:
        part, simpler, guesses = job
        term = term_in(at.bench.structure, part)
        hypothesis = replace(simpler.hypothesis, terms=(*simpler.hypothesis.terms[:-1], term))
        begun = [
            replace(simpler.parameters, values=(*simpler.parameters.values[:-1], values))
            for values in guesses
        ]
        tried = [at.fit(hypothesis, one, at.bench.short, 0) for one in begun]
        scored = sorted((deviance(f), i) for i, f in enumerate(tried) if f is not None)
        ends = [
            at.fit(hypothesis, at.valley(hypothesis, begun[i]), at.bench.short, 6)
            for _, i in scored[: 2 if part.candidate.kind in DRY else 1]
        ]
        return min((f for f in ends if f is not None), key=deviance, default=None)

    with ThreadPoolExecutor(2) as pool:
        return [fit for fit in pool.map(work, jobs) if fit is not None]


def names(parts: Sequence[Part | Term]) -> tuple[tuple[str, int], ...]:
    """Return kind and joint of each of some candidates."""
    return tuple((part.candidate.kind, part.joint) for part in parts)


def one_of_each(fits: list[Fit]) -> list[Fit]:
    """Return the best fit of every set of candidates and joints; `fits` are best first."""
    best: dict[tuple[tuple[str, int, object], ...], Fit] = {}
    for fit in fits:
        key = tuple(
            (term.candidate.kind, term.joint, term.candidate.fixed.get("side"))
            for term in fit.hypothesis.terms
        )
        best.setdefault(key, fit)
    return list(best.values())


def tightened(at: Context, fit: Fit, linear: Parameters) -> tuple[Context, Fit]:
    """Return a fit, and the context in which its likelihood is largest.

    Tried are samples as they are and samples behind a recorder's filter, ever smaller shares
    of the response that the model may miss, and less noise than the quiet part of the band
    shows (a force with jumps is never quiet).
    """
    if fit.cost > 1.5 * fit.count:
        lower = at.valley(fit.hypothesis, fit.parameters, reach=0.5, rounds=6, always=True)
        again = at.fit(fit.hypothesis, lower, at.bench.short, 8)
        if again is not None and deviance(again) < deviance(fit):
            fit = again
    ends = [_descended(at, fit, linear)]
    if not at.filtered and fit.hypothesis.terms:
        begun = [
            context(at.bench, linear, max(FLOOR, share * at.loose), filtered=True)
            for share in (1.0, 0.3, 0.1, 0.03)
        ]
        tried = [one.fit(fit.hypothesis, fit.parameters, at.bench.short, 0) for one in begun]
        scored = [(deviance(f), i) for i, f in enumerate(tried) if f is not None]
        if scored:
            there = begun[min(scored)[1]]
            first = there.fit(fit.hypothesis, fit.parameters, at.bench.short, 6)
            if first is not None:
                ends.append(_descended(there, first, linear))
                if deviance(ends[1][1]) < deviance(ends[0][1]) - 20.0:
                    ends.reverse()
    return _quieted(*ends[0], linear)


def _descended(at: Context, fit: Fit, linear: Parameters) -> tuple[Context, Fit]:
    bench, top, misses = at.bench, (at, fit), 0
    for _ in range(10):
        if at.loose <= FLOOR:
            break
        new = at.loose * float(np.sqrt(fit.cost / fit.count))
        new = max(FLOOR, new if new < 0.5 * at.loose else 0.3 * at.loose)
        at = context(bench, linear, new, filtered=at.filtered)
        first = at.valley(fit.hypothesis, fit.parameters, reach=0.15, rounds=5)
        tried = at.fit(fit.hypothesis, first, bench.short, 4)
        if tried is None:
            break
        fit = tried
        if deviance(fit) < deviance(top[1]):
            top, misses = (at, fit), 0
        else:
            misses += 1
        if misses == 2:
            break
    return top


def _quieted(at: Context, fit: Fit, linear: Parameters) -> tuple[Context, Fit]:
    """Return the same with the sensors' noise of every test as small as the fit shows it."""
    for _ in range(6):
        share = innovation_sizes(at, fit)
        if share is None or np.min(share) > 0.85:
            break
        factor = np.where(share > 0.85, 1.0, np.maximum(share, 0.1))
        bench = at.bench.quieter(factor)
        trial = context(bench, linear, at.loose, filtered=at.filtered)
        again = trial.fit(fit.hypothesis, fit.parameters, bench.short, 2)
        if again is None or deviance(again) > deviance(fit) - 20.0:
            break
        at, fit = _descended(trial, again, linear)
    return at, fit


def innovation_sizes(at: Context, fit: Fit) -> FloatArray | None:
    """Return the rms of the whitened innovations of every test; of a held-out one, the mean."""
    short = at.bench.short
    seen = at.judged(fit.hypothesis, fit.parameters, short)
    if seen is None:
        return None
    power, count = np.zeros(len(at.bench.prepared)), np.zeros(len(at.bench.prepared))
    for segment, part in zip(short, seen[0], strict=True):
        power[segment.test] += float(np.sum(part**2))
        count[segment.test] += part.size
    known = count > 0.0
    out = np.full(power.size, 1.0)
    out[known] = np.sqrt(power[known] / count[known])
    out[~known] = float(np.exp(np.mean(np.log(out[known]))))
    return out


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


def _as_acceleration(structure: Structure, prepared: Prepared) -> float:
    """Return the rms of the responses, as accelerations at the lowest resonance [m/s²]."""
    slowest = float(angular_frequencies(structure)[0])
    factors = np.array([slowest ** (2 - sensing.order) for sensing in structure.sensing])
    return float(np.sqrt(np.mean((prepared.measured * factors[:, None]) ** 2)))


def make_bench(
    structure: Structure, prepared: tuple[Prepared, ...], fine: int, priors: Priors
) -> Bench:
    """Return a bench."""
    whole = tuple(full_segment(p, i, fine) for i, p in enumerate(prepared))
    short = short_segments(whole, prepared)
    rms = np.array([_as_acceleration(structure, p) for p in prepared])
    return Bench(structure, prepared, whole, short, rms, priors)
