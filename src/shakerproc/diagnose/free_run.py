"""Dry friction by free runs: motion foretold from the start of a test, never corrected.

Where a contact sticks and slips, an observer that corrects its state at every sample goes
wrong: a slip may last a few samples, and one sample beside a jump moves the state by far. A
free run needs no correction there: two motions under the same input never part, for friction
with a constant force is a monotone law [1]_. So the distance between a free run and the
measurement depends on stiffness, damping and force without steps, once seen as a velocity.

References
----------
.. [1] M. D. P. Monteiro Marques, "Differential Inclusions in Nonsmooth Mechanical Problems",
   Birkhaeuser, 1993.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnose.candidates import COULOMB, STRIBECK
from shakerproc.diagnose.fit import Code, Fit, Lens
from shakerproc.diagnose.prepare import upsample
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    Term,
    assemble,
    cut,
    law_table,
    reduced_mass,
    run,
)
from shakerproc.diagnose.search import (
    DRY,
    Bench,
    Context,
    context,
    deviance,
    innovation_sizes,
    one_of_each,
    refit,
)

LEFT = 0.35
"""Share of the motion that Coulomb friction must not leave, to be looked at further [-]."""
LONGEST = 6.0
"""How much of a test the search looks at [s]."""
RUN_IN = 0.3
"""After how long a run has forgotten what it began with [s]."""
QUIETER = 0.01
"""Share of the most that moved in a test, below which another is left out of the search [-]."""
ALIKE = 3.0
"""How much noisier a response is taken to be than the controls, each over its own rms [-]."""
STIFFNESSES = tuple(np.geomspace(0.7, 1.4, 24))
DAMPINGS = (1.0, 3.0)
"""Stiffness and damping to try, over those of the model [-]."""
FORCES = tuple(np.geomspace(0.004, 1.0, 26))
"""Friction forces to try, over the largest force that the joint has passed on [-]."""
EXCESSES = (0.1, 0.3, 0.7, 1.2)
BREAKAWAYS = (0.98, 1.03, 1.15, 1.35)
SPEEDS = (0.03, 0.1, 0.3, 1.0, 3.0)
"""Breakaway over sliding force less 1, breakaway over Coulomb's force, Stribeck velocity over
the rms of the velocity: what is tried around a fit of Coulomb friction [-]."""
CARRIED_ON = 5
"""Points of the grid from which fits begin."""
ROUNDS = 4
"""How often a fit is carried on at most."""
CREPT = 2
"""Of these fits, how many are carried to their end."""


@dataclass(frozen=True, slots=True, eq=False)
class Hunt:
    """Where friction is looked for.

    Attributes
    ----------
    at : Context
        Free runs, seen as velocities over the rms of the motion.
    pieces : tuple of Segment
        Where the joint moved.
    loudest : Segment
        That in which it moved most.
    force : float
        Largest force that the joint has passed on [N].
    speed : float
        Rms of the velocity there [m/s].
    """

    at: Context
    pieces: tuple[Segment, ...]
    loudest: Segment
    force: float
    speed: float


def friction_fits(
    bench: Bench, start: Parameters, base: Fit, fits: Sequence[Fit]
) -> tuple[Context, list[Fit]] | None:
    """Return dry friction fitted by free runs, beside the best of other fits; None if it fails.

    Only one mass is searched: the other joints of a structure would have to be found as well.

    Parameters
    ----------
    bench : Bench
        The tests.
    start : Parameters
        Of the model as it was.
    base : Fit
        The linear model with the effects that it has already.
    fits : sequence of Fit
        Of one effect more, best first.
    """
    if bench.structure.masses.size != 1:
        return None
    hunt = hunt_for(bench)
    if hunt is None:
        return None
    near = coulomb_fits(hunt, start, base, fits)
    if not near or _better_without(hunt, near[0], fits):
        return None
    at, coulomb = as_recorded(hunt.at, near[0], hunt.pieces)
    found = carried_on(at, near[1:], hunt.pieces)
    found = [min([coulomb, *found], key=deviance)]
    found += carried_on(at, _stribeck(hunt, start, found[0], fits), hunt.pieces)
    found = one_of_each(sorted(found, key=deviance))
    found += [fit for fit in fits if _dry(fit)]
    final, ends = judged(bench, base.parameters, found, hunt.pieces)
    ends += carried_on(final, _simpler(final, ends), _in(final.bench, hunt.pieces))
    others = [fit for fit in fits if not _dry(fit)][:2]
    ended = refit(final, [*ends, *others], final.bench.short, 3)
    return final, one_of_each(ended)


def _better_without(hunt: Hunt, coulomb: Fit, fits: Sequence[Fit]) -> bool:
    """Return whether friction leaves much of the motion, or more than another effect."""
    if coulomb.cost > LEFT**2 * coulomb.count:
        return True
    ends = [
        hunt.at.fit(fit.hypothesis, fit.parameters, hunt.pieces, 4)
        for fit in fits[:1] if not _dry(fit)
    ]  # fmt: skip
    return any(end is not None and deviance(end) < deviance(coulomb) for end in ends)


def _dry(fit: Fit) -> bool:
    return any(term.candidate.kind in DRY for term in fit.hypothesis.terms)


def hunt_for(bench: Bench) -> Hunt | None:
    """Return where the joint of one mass moves; None where it never does."""
    structure = bench.structure
    omega = float(np.sqrt(np.sum(structure.stiffness) / structure.masses[0]))
    order = structure.sensing[0].order
    moved = [(s, _moving(bench, s)) for s in replace(bench, free=True).fitted()]
    power = {s.test: found[2] for s, found in moved if found is not None}
    if not power:
        return None
    most = max(power.values())
    pieces = [
        cut(s, found[0], found[1], round(RUN_IN * s.sample_rate))
        for s, found in moved if found is not None and found[2] > QUIETER * most
    ]  # fmt: skip
    size = {s.test: float(np.sqrt(np.mean(_departure(bench, s) ** 2))) for s in pieces}
    factor = np.array([
        size.get(i, 1.0) / float(np.mean(p.noise)) for i, p in enumerate(bench.prepared)
    ])
    loudest = max(pieces, key=lambda s: size[s.test])
    free = replace(bench.quieter(factor), free=True, short=tuple(pieces))
    nothing = Parameters(structure.stiffness, structure.damping, np.ones(1), np.zeros(1))
    lens = _as_velocity(omega, loudest.sample_rate) if order == 2 else None
    seen = replace(context(free, nothing), lens=lens)
    largest = float(np.max(np.abs(loudest.measured[0])))
    scale = omega ** (2 - order) * float(structure.masses[0])
    speed = size[loudest.test] * omega ** (1 - order)
    return Hunt(seen, tuple(pieces), loudest, scale * largest, speed)


def _departure(bench: Bench, segment: Segment) -> FloatArray:
    """Return what the first sensor shows beyond a joint that sticks, (n,) array."""
    structure = bench.structure
    rigid = structure.sensing[0].absolute and structure.forced < 0
    base = segment.input[:: segment.fine] if rigid else 0.0
    departure: FloatArray = (segment.measured[0] - base) * segment.weight[0]
    return departure


def _moving(bench: Bench, segment: Segment) -> tuple[int, int, float] | None:
    """Return first and last sample between which a joint moved, and the power of its motion."""
    rate = segment.sample_rate
    size = round(0.05 * rate)
    departure = _departure(bench, segment)
    count = departure.size // size
    if count < 10:
        return None
    power = np.sum(departure[: count * size].reshape(count, size) ** 2, axis=1)
    noise = bench.prepared[segment.test]
    still = min(
        float(np.mean(np.sort(power)[: max(count // 10, 1)])),
        size * float(noise.noise[0] ** 2 + noise.input_noise**2),
    )
    grown = np.cumsum(np.where(power > 4.0 * still, power, 0.0))
    if grown[-1] <= 0.0:
        return None
    longest = round(LONGEST * rate) // size
    first, last = np.searchsorted(grown, np.array([0.002, 0.998]) * grown[-1])
    if last - first > longest:
        before = np.concatenate([[0.0], grown])
        first = int(np.argmax(before[longest:] - before[:-longest]))
        last = first + longest
    start = max(int(first) * size - round(RUN_IN * rate), 0)
    return start, min((int(last) + 3) * size, departure.size), float(grown[-1])


def _as_velocity(omega: float, sample_rate: float) -> Lens:
    """Return what takes accelerations to velocities times omega, slow drift left out."""
    leak = np.exp(-0.5 * omega / sample_rate)

    def lens(innovations: FloatArray) -> FloatArray:
        out: FloatArray = scipy.signal.lfilter(
            [omega / sample_rate], [1.0, -leak], innovations, axis=1
        )
        return out

    return lens


def coulomb_fits(hunt: Hunt, start: Parameters, base: Fit, fits: Sequence[Fit]) -> list[Fit]:
    """Return Coulomb friction fitted, from the best points of a grid."""
    structure = hunt.at.bench.structure
    term = Term(COULOMB, 0, reduced_mass(structure, structure.joints[0]))
    hypothesis = Hypothesis((*base.hypothesis.terms, term), base.hypothesis.faults)
    known = base.parameters.values
    total = float(np.sum(start.stiffness))
    stiffnesses = list(STIFFNESSES)
    stiffnesses += [float(np.sum(f.parameters.stiffness)) / total for f in fits if _dry(f)]
    points = [
        replace(
            start, stiffness=start.stiffness * k, damping=start.damping * c,
            values=(*known, (share * hunt.force,)),
        )
        for k, c, share in product(stiffnesses, DAMPINGS, FORCES)
    ]  # fmt: skip
    return _searched(hunt, hypothesis, points)


def _stribeck(hunt: Hunt, start: Parameters, coulomb: Fit, fits: Sequence[Fit]) -> list[Fit]:
    """Return Stribeck friction fitted, from around a fit of Coulomb friction."""
    *rest, term = coulomb.hypothesis.terms
    hypothesis = replace(coulomb.hypothesis, terms=(*rest, replace(term, candidate=STRIBECK)))
    p = coulomb.parameters
    known, force = p.values[:-1], p.values[-1][0]
    places = [p, *(replace(start, stiffness=start.stiffness * k) for k in STIFFNESSES[::2])]
    points = [
        replace(
            place,
            values=(*known, (force * breakaway / (1.0 + excess), excess, share * hunt.speed)),
        )
        for place, breakaway, excess, share in product(places, BREAKAWAYS, EXCESSES, SPEEDS)
    ]
    points += [f.parameters for f in fits if f.hypothesis == hypothesis]
    return _searched(hunt, hypothesis, points)


def _simpler(at: Context, ends: Sequence[Fit]) -> list[Fit]:
    """Return Coulomb friction begun where Stribeck friction has ended, if that is the best."""
    best = min(ends, key=deviance)
    *rest, term = best.hypothesis.terms
    if term.candidate is not STRIBECK:
        return []
    hypothesis = replace(best.hypothesis, terms=(*rest, replace(term, candidate=COULOMB)))
    *known, values = best.parameters.values
    begun = [
        at.fit(hypothesis, replace(best.parameters, values=(*known, one)), at.bench.short, 0)
        for one in ((values[0],), (values[0] * (1.0 + 0.5 * values[1]),))
    ]
    return [fit for fit in begun if fit is not None]


def _searched(hunt: Hunt, hypothesis: Hypothesis, points: Sequence[Parameters]) -> list[Fit]:
    """Return the best fits that begin at some points."""
    at, pieces = hunt.at, hunt.pieces
    begun = _best(hunt, hypothesis, points)
    with ThreadPoolExecutor(2) as pool:
        fits = list(pool.map(lambda p: at.fit(hypothesis, p, pieces, 10), begun))
    return sorted((fit for fit in fits if fit is not None), key=deviance)[:CREPT]


def as_recorded(at: Context, fit: Fit, pieces: tuple[Segment, ...]) -> tuple[Context, Fit]:
    """Return a fit carried on, with or without a recorder's filter, whichever fits better."""
    both = [replace(at, filtered=filtered) for filtered in (False, True)]
    with ThreadPoolExecutor(2) as pool:
        ends = list(pool.map(lambda one: _crept(one, fit, pieces), both))
    return min(zip(both, ends, strict=True), key=lambda end: deviance(end[1]))


def _best(hunt: Hunt, hypothesis: Hypothesis, points: Sequence[Parameters]) -> list[Parameters]:
    """Return the points at which the loudest test is met best, no two close to each other."""
    with ThreadPoolExecutor(2) as pool:
        costs = list(pool.map(lambda p: hunt.at.height(hypothesis, p, (hunt.loudest,)), points))
    out: list[Parameters] = []
    for i in np.argsort(costs):
        if len(out) == CARRIED_ON or not np.isfinite(costs[i]):
            break
        if all(_apart(points[i], other) for other in out):
            out.append(points[i])
    return out


def _apart(one: Parameters, other: Parameters) -> bool:
    stiffness = abs(np.log(np.sum(one.stiffness) / np.sum(other.stiffness)))
    numbers = np.abs(np.log(np.array(one.values[-1]) / np.array(other.values[-1])))
    return bool(stiffness > 0.05 or np.max(numbers) > 0.3)


def carried_on(at: Context, fits: Sequence[Fit], pieces: tuple[Segment, ...]) -> list[Fit]:
    """Return fits, each carried to its end."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda fit: _crept(at, fit, pieces), fits))


def _crept(at: Context, fit: Fit, pieces: tuple[Segment, ...]) -> Fit:
    """Return the best near a fit: by the slope and by a simplex in turn, while it gets better.

    The slope finds the bottom of a valley, the simplex the way along it.
    """
    best = at.fit(fit.hypothesis, fit.parameters, pieces, 12)
    if best is None:
        return fit
    for _ in range(ROUNDS):
        lower = simplex(at, fit.hypothesis, best.parameters, pieces)
        again = at.fit(fit.hypothesis, lower, pieces, 12)
        if again is None or deviance(again) > deviance(best):
            break
        gained = best.cost - again.cost
        best = again
        if gained < 0.02 * best.cost:
            break
    return best


def simplex(
    at: Context, hypothesis: Hypothesis, start: Parameters, pieces: tuple[Segment, ...]
) -> Parameters:
    """Return better parameters near the start, by a simplex that creeps downhill [1]_.

    Every stick and slip is a kink in the likelihood, which lies in narrow valleys that no
    single number follows.

    References
    ----------
    .. [1] J. A. Nelder and R. Mead, "A simplex method for function minimization", Computer
       Journal 7, 308-313, 1965.
    """
    code = Code(hypothesis, start, at.bench.structure.damping)
    first, free = code.pack(start), np.flatnonzero(code.free(sensors=False))
    n = start.stiffness.size
    sizes = np.full(first.size, 0.05)
    sizes[:n], sizes[n : 2 * n] = 0.01, 0.2
    corners = np.tile(first[free], (free.size + 1, 1))
    corners[1:] += np.diag(sizes[free])

    def parameters(vector: FloatArray) -> Parameters:
        whole = first.copy()
        whole[free] = vector
        whole = np.maximum(whole, code.least)
        return code.unpack(whole)

    def height(vector: FloatArray) -> float:
        return at.height(hypothesis, parameters(vector), pieces)

    found = scipy.optimize.minimize(
        height, first[free], method="Nelder-Mead",
        options={"initial_simplex": corners, "maxfev": 40 * free.size, "xatol": 1e-5,
                 "fatol": 1.0},
    )  # fmt: skip
    return parameters(found.x)


def judged(
    bench: Bench, linear: Parameters, found: Sequence[Fit], pieces: tuple[Segment, ...]
) -> tuple[Context, list[Fit]]:
    """Return fits, the best first, carried on as they are judged: how recorded, which noise.

    The noise of the controls moves a contact as the controls do; by how much, a second run
    with as much noise again shows. The noise is no more than the best fit leaves: where a force
    jumps, the band in which sensors are otherwise quiet is not.
    """
    free = replace(bench, free=True)
    best, *others = found
    noisier = free.quieter(_noise_beside_scatter(free, best))
    at = context(replace(noisier, short=noisier.fitted()), linear)
    own = _in(at.bench, pieces)
    at, end = as_recorded(at, best, own)
    sizes = innovation_sizes(at, end)
    if sizes is not None:
        quiet = at.bench.quieter(np.clip(sizes, 1e-3, 1.0))
        at = context(quiet, linear, filtered=at.filtered)
    return at, carried_on(at, [end, *others], own)


def _in(bench: Bench, pieces: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Return the stretches of a bench's tests that some pieces cover."""
    fitted = {s.test: s for s in bench.fitted()}
    return tuple(
        cut(fitted[s.test], s.start, s.start + s.measured.shape[1], s.skip) for s in pieces
    )


def _noise_beside_scatter(bench: Bench, fit: Fit) -> FloatArray:
    """Return the noise of free runs over that of the sensors, for every test [-]."""
    own = np.array([float(np.mean(p.noise**2)) for p in bench.prepared])
    factor: FloatArray = np.sqrt(1.0 + _scatter(bench, fit) / own)
    return factor


def least_floor(bench: Bench, fit: Fit) -> float:
    """Return the least that noise lets a free run leave, over the response [-].

    Where forces jump, the noise of a sensor cannot be read off the top of its band. Here it is
    no more than a few times that of the controls, each over what it measures.
    """
    above = below = 0.0
    scatter = _scatter(bench, fit)
    for segment in bench.fitted():
        prepared = bench.prepared[segment.test]
        response = float(np.mean(segment.measured**2))
        shaken = float(np.mean(segment.input**2))
        like_controls = (ALIKE * prepared.input_noise) ** 2 * response / max(shaken, 1e-300)
        noise = min(float(np.mean(prepared.noise**2)), like_controls)
        above += (noise + scatter[segment.test]) * segment.measured.shape[1]
        below += response * segment.measured.shape[1]
    return float(np.sqrt(above / below))


def _scatter(bench: Bench, fit: Fit) -> FloatArray:
    """Return the mean square of what the controls' noise does to free runs, for every test."""
    bench = replace(bench, free=True)
    whole = assemble(bench.structure, fit.hypothesis, fit.parameters)
    table = law_table(bench.structure, fit.hypothesis, fit.parameters, whole.masses.size)
    tunings = bench.tunings(whole)
    generator = np.random.default_rng(0)
    out = np.zeros(len(bench.prepared))
    for segment in bench.whole:
        prepared = bench.prepared[segment.test]
        noise = np.asarray(
            generator.normal(scale=prepared.input_noise, size=segment.measured.shape[1])
        )
        shaken = replace(segment, input=segment.input + upsample(noise, segment.fine))
        seen = [
            run(whole, table, one, tunings[segment.test], fit.parameters, keep=True)
            for one in (segment, shaken)
        ]
        if seen[0] is not None and seen[1] is not None:
            out[segment.test] = float(np.mean((seen[1].expected - seen[0].expected) ** 2))
    return out
