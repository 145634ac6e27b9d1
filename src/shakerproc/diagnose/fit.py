"""Maximum likelihood by prediction error: Levenberg-Marquardt on the observer's innovations."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    Tuning,
    assemble,
    beyond_filter,
    law_table,
    run,
)
from shakerproc.diagnose.structure import Structure
from shakerproc.models import EFFECTS

GAIN_SCALE = 0.01
DELAY_SCALE = 1e-5
BLOCK_SECONDS = 0.25
Lens = Callable[[FloatArray], FloatArray]
"""From innovations (n_sensors, n) to what of them is to be small."""


@dataclass(frozen=True, slots=True)
class Priors:
    """How well gain [-] and delay [s] of a sensor are known where no fault is assumed."""

    gain: float = 2e-3
    delay: float = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A hypothesis with its best parameters.

    Attributes
    ----------
    cost : float
        Sum of squares of the whitened innovations and of the priors [-].
    count : int
        Samples judged.
    blocks : (n_blocks,) array
        Share of each quarter second in the cost.
    vector, variance : (n_parameters,) array
        Scaled parameters, and their variances.
    scales : tuple of tuple of float
        What the signed numbers of each term are scaled with.
    logs : float
        Sum of the logarithms of the expected variances of the innovations.
    linear_scales : (2 n_joints,) array
        What stiffnesses [N/m] and dampings [N s/m] are scaled with.
    """

    hypothesis: Hypothesis
    parameters: Parameters
    cost: float
    count: int
    blocks: FloatArray
    vector: FloatArray
    variance: FloatArray
    converged: bool
    logs: float
    scales: tuple[tuple[float, ...], ...] = ()
    linear_scales: FloatArray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True, eq=False)
class Code:
    """Takes parameters to a vector of scaled numbers and back.

    The damping is scaled with that of the start or with a part of the nominal, whichever is
    larger, so that a damping that came near 0 can grow again.
    """

    hypothesis: Hypothesis
    start: Parameters
    nominal: FloatArray

    @property
    def damping_scale(self) -> FloatArray:
        """What dampings are scaled with [N s/m]."""
        return np.maximum(self.start.damping, 0.3 * self.nominal)

    @property
    def least(self) -> FloatArray:
        """Smallest entries: stiffnesses and dampings above 0, and what the effects allow."""
        scale = self.damping_scale
        parts = [
            np.full(self.start.stiffness.size, -0.98),
            (1e-5 * scale - self.start.damping) / scale,
            np.full(2 * self.start.gain.size, -np.inf),
        ]
        for term in self.hypothesis.terms:
            known = EFFECTS[term.candidate.kind].parameters
            for name, positive in zip(
                term.candidate.names, term.candidate.positive, strict=True
            ):
                least = known[name].least if name in known else None
                bound = -np.inf if least is None or not positive else float(np.log(least))
                parts.append(np.array([bound]))
        return np.concatenate(parts)

    def names(self) -> list[str]:
        """Return what each entry is."""
        p = self.start
        entries = [f"k{i}" for i in range(p.stiffness.size)]
        entries += [f"c{i}" for i in range(p.damping.size)]
        entries += [f"g{i}" for i in range(p.gain.size)] + [
            f"d{i}" for i in range(p.delay.size)
        ]
        for t, term in enumerate(self.hypothesis.terms):
            entries += [f"t{t}{name}" for name in term.candidate.names]
        return entries

    def pack(self, p: Parameters) -> FloatArray:
        """Return the vector of parameters."""
        parts = [
            p.stiffness / self.start.stiffness - 1.0,
            (p.damping - self.start.damping) / self.damping_scale,
            (p.gain - 1.0) / GAIN_SCALE,
            p.delay / DELAY_SCALE,
        ]
        for term, values, first in zip(
            self.hypothesis.terms, p.values, self.start.values, strict=True
        ):
            row = [
                np.log(value) if positive else value / abs(one)
                for value, one, positive in zip(
                    values, first, term.candidate.positive, strict=True
                )
            ]
            parts.append(np.array(row))
        return np.concatenate(parts)

    def unpack(self, vector: FloatArray) -> Parameters:
        """Return the parameters of a vector."""
        n, s = self.start.stiffness.size, self.start.gain.size
        stiffness = self.start.stiffness * np.maximum(1.0 + vector[:n], 1e-6)
        least = self.least
        damping = self.start.damping + self.damping_scale * np.maximum(
            vector[n : 2 * n], least[n : 2 * n]
        )
        gain = 1.0 + vector[2 * n : 2 * n + s] * GAIN_SCALE
        delay = vector[2 * n + s : 2 * n + 2 * s] * DELAY_SCALE
        at, values = 2 * n + 2 * s, []
        for term, first in zip(self.hypothesis.terms, self.start.values, strict=True):
            row = []
            for positive, one in zip(term.candidate.positive, first, strict=True):
                x = float(max(vector[at], least[at]))
                row.append(
                    float(np.exp(np.clip(x, -200.0, 200.0))) if positive else x * abs(one)
                )
                at += 1
            values.append(tuple(row))
        return Parameters(stiffness, damping, gain, delay, tuple(values))

    def steps(self) -> FloatArray:
        """Return steps for differences."""
        n, s = self.start.stiffness.size, self.start.gain.size
        steps = [2e-4] * n + [5e-3] * n + [0.01] * s + [0.01] * s
        for term in self.hypothesis.terms:
            steps += [2e-3] * len(term.candidate.positive)
        return np.array(steps)

    def free(self, *, sensors: bool) -> FloatArray:
        """Return which entries a fit may move."""
        n, s = self.start.stiffness.size, self.start.gain.size
        out = np.ones(2 * n + 2 * s + sum(len(v) for v in self.start.values), dtype=bool)
        out[2 * n : 2 * n + 2 * s] = sensors
        for kind, sensor in self.hypothesis.faults:
            out[2 * n + sensor + (s if kind == "sensor_delay" else 0)] = True
        return out

    def precision(self, priors: Priors) -> FloatArray:
        """Return the weight of each entry's square."""
        n, s = self.start.stiffness.size, self.start.gain.size
        weights = np.zeros(2 * n + 2 * s + sum(len(v) for v in self.start.values))
        weights[: 2 * n] = 1e-6
        weights[2 * n : 2 * n + s] = (GAIN_SCALE / priors.gain) ** 2
        weights[2 * n + s : 2 * n + 2 * s] = (DELAY_SCALE / priors.delay) ** 2
        for kind, sensor in self.hypothesis.faults:
            if kind == "sensor_gain":
                weights[2 * n + sensor] = (GAIN_SCALE / 0.5) ** 2
            if kind == "sensor_delay":
                weights[2 * n + s + sensor] = (DELAY_SCALE / 0.02) ** 2
        return weights


def whitened(
    structure: Structure,
    hypothesis: Hypothesis,
    p: Parameters,
    segments: tuple[Segment, ...],
    tunings: tuple[Tuning, ...],
    beyond: list[FloatArray] | None = None,
    *,
    robust: bool = True,
    lens: Lens | None = None,
    filtered: bool = False,
) -> tuple[list[FloatArray], float] | None:
    """Return innovations over their expected size, of the judged part of every segment.

    Besides them the sum of the logarithms of their expected variances. Where `robust`, those
    above 5 are drawn in so that their squares grow linearly (Huber): one sample beside a jump
    of a force may miss by far, and says little. `lens` is what they are seen through before.
    What a recorder's filter took is `beyond`; of runs that nothing corrects it follows from the
    run itself, where `filtered`.
    """
    whole = assemble(structure, hypothesis, p)
    table = law_table(structure, hypothesis, p, whole.masses.size)
    out, logs = [], 0.0
    for i, segment in enumerate(segments):
        lost = None if beyond is None else beyond[i]
        tuned = tunings[segment.gain_key]
        result = run(whole, table, segment, tuned, p, beyond=lost, keep=filtered)
        if result is None:
            return None
        judged = result.innovations
        if filtered:
            share = np.abs(p.gain) / tuned.noise
            judged = judged + beyond_filter(result, segment.fine) * share[:, None] * (
                segment.weight
            )
        judged = judged[:, segment.skip :]
        if lens is not None:
            judged = lens(judged)
        out.append(drawn_in(judged) if robust else judged)
        logs += result.logs
    return out, logs


def unaided(tunings: tuple[Tuning, ...]) -> bool:
    """Return whether nothing corrects the runs of these tunings."""
    return all(tuned.unaided for tuned in tunings)


def drawn_in(innovations: FloatArray, edge: float = 5.0) -> FloatArray:
    """Return numbers whose squares are Huber's loss of these [-]."""
    size = np.abs(innovations)
    far = np.sqrt(np.maximum(2.0 * edge * size - edge * edge, 0.0))
    return np.where(size > edge, np.copysign(far, innovations), innovations)


def taken_away(
    structure: Structure,
    hypothesis: Hypothesis,
    p: Parameters,
    segments: tuple[Segment, ...],
    tunings: tuple[Tuning, ...],
    beyond: list[FloatArray] | None,
) -> list[FloatArray] | None:
    """Return what the recorder's filter took from every segment, by this hypothesis."""
    whole = assemble(structure, hypothesis, p)
    table = law_table(structure, hypothesis, p, whole.masses.size)
    out = []
    for i, segment in enumerate(segments):
        lost = None if beyond is None else beyond[i]
        tuned = tunings[segment.gain_key]
        result = run(whole, table, segment, tuned, p, beyond=lost, keep=True)
        if result is None:
            return None
        out.append(p.gain[:, None] * beyond_filter(result, segment.fine))
    return out


def settled(
    structure: Structure,
    hypothesis: Hypothesis,
    p: Parameters,
    segments: tuple[Segment, ...],
    tunings: tuple[Tuning, ...],
    *,
    rounds: int,
) -> list[FloatArray] | None:
    """Return what the recorder's filter took, found in rounds: it bears on what is observed."""
    beyond = taken_away(structure, hypothesis, p, segments, tunings, None)
    for _ in range(rounds - 1):
        if beyond is None:
            return None
        beyond = taken_away(structure, hypothesis, p, segments, tunings, beyond)
    return beyond


def _flat(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate([part.ravel() for part in parts])


def block_costs(parts: list[FloatArray], sample_rate: float) -> FloatArray:
    """Return the sum of squares of each quarter second."""
    size = int(BLOCK_SECONDS * sample_rate)
    costs = []
    for part in parts:
        square = np.sum(part * part, axis=0)
        n = square.size // size
        costs.append(square[: n * size].reshape(n, size).sum(axis=1))
    return np.concatenate(costs)


def levenberg(
    structure: Structure,
    hypothesis: Hypothesis,
    start: Parameters,
    segments: tuple[Segment, ...],
    tunings: tuple[Tuning, ...],
    *,
    priors: Priors,
    iterations: int,
    sensors: bool = False,
    filtered: bool = False,
    lens: Lens | None = None,
    tolerance: float = 1e-4,
) -> Fit | None:
    """Return the fit nearest to the start, or None where the start blows up.

    Gains and delays of the sensors move only where `sensors` says so, or the hypothesis frees
    them. Stops when an iteration gains less than this share of the cost (and less than 0.3 of
    the cost per judged sample's variance).
    """
    code = Code(hypothesis, start, structure.damping)
    weights, steps = code.precision(priors), code.steps()
    vector = code.pack(start)
    free = np.flatnonzero(code.free(sensors=sensors))
    reach = np.full(vector.size, _LIMIT)
    reach[2 * start.stiffness.size : 2 * (start.stiffness.size + start.gain.size)] = 20.0

    def cost_of(parts: list[FloatArray], at: FloatArray) -> float:
        return float(sum(np.sum(part * part) for part in parts) + np.sum(weights * at * at))

    def parts_at(at: FloatArray) -> tuple[list[FloatArray], float] | None:
        p = code.unpack(at)
        return whitened(
            structure, hypothesis, p, segments, tunings, beyond, lens=lens, filtered=alone
        )

    alone = filtered and unaided(tunings)
    filtered = filtered and not alone
    beyond: list[FloatArray] | None = None
    if filtered:
        beyond = settled(structure, hypothesis, start, segments, tunings, rounds=3)
        if beyond is None:
            return None
    first = parts_at(vector)
    if first is None:
        return None
    parts, logs = first
    cost, damping, converged = cost_of(parts, vector), 1e-4, False
    flat_size = sum(part.size for part in parts)
    normal = np.diag(weights[free]) + 1e-9 * np.eye(free.size)
    meat = np.zeros_like(normal)
    for iteration in range(iterations):
        if filtered and iteration:
            now = code.unpack(vector)
            lost = taken_away(structure, hypothesis, now, segments, tunings, beyond)
            if lost is not None:
                beyond = lost
                again = parts_at(vector)
                if again is not None:
                    parts, logs = again
                    cost = cost_of(parts, vector)
        normal, slope, meat = _normal_equations(parts_at, vector, parts, steps, free)
        normal = normal + np.diag(weights[free])
        slope = slope + (weights * vector)[free]
        gained = 0.0
        for _attempt in range(4):
            step = _solve(normal, slope, damping)
            trial = vector.copy()
            trial[free] += np.clip(step, -reach[free], reach[free])
            trial = np.maximum(trial, code.least)
            there = parts_at(trial)
            if there is None:
                damping = max(damping * 30.0, 1e-3)
                continue
            new, unit = cost_of(there[0], trial), max(cost / flat_size, 1e-12)
            gain = cost - new + unit * (logs - there[1])
            if gain > 0.0:
                gained, cost, vector = gain, new, trial
                parts, logs = there
                damping = max(damping * 0.1, 1e-9)
                break
            damping = max(damping * 30.0, 1e-3)
        if gained < max(0.3 * cost / flat_size, tolerance * cost):
            converged = True
            break
    variance = np.zeros(vector.size)
    variance[free] = _variance(normal, meat, max(cost / flat_size, 1.0))
    return Fit(
        hypothesis, code.unpack(vector), cost, sum(part.size for part in parts),
        block_costs(parts, segments[0].sample_rate),
        vector,
        variance,
        converged,
        logs,
        start.values,
        np.concatenate([start.stiffness, code.damping_scale]),
    )  # fmt: skip


def compass(
    structure: Structure, hypothesis: Hypothesis, start: Parameters,
    segments: tuple[Segment, ...], tunings: tuple[Tuning, ...], *, rounds: int = 9,
    reach: float = 1.0, lens: Lens | None = None,
) -> Parameters:  # fmt: skip
    """Return better parameters near the start, by steps along each number in turn.

    Where a contact sticks or slips the likelihood is rugged, and its slope at one point says
    little; steps of decreasing size find the valley in which `levenberg` then works [1]_.

    References
    ----------
    .. [1] R. Hooke and T. A. Jeeves, "Direct search solution of numerical and statistical
       problems", Journal of the ACM 8, 212-229, 1961.
    """
    code = Code(hypothesis, start, structure.damping)
    n, s = start.stiffness.size, start.gain.size
    vector = code.pack(start)
    sizes = np.full(vector.size, 0.25)
    sizes[:n], sizes[n : 2 * n] = 0.03, 0.5
    sizes *= reach

    def deviance(at: FloatArray) -> float:
        found = whitened(structure, hypothesis, code.unpack(at), segments, tunings, lens=lens)
        if found is None:
            return float("inf")
        return float(sum(np.sum(part * part) for part in found[0])) + found[1]

    free = [i for i in range(vector.size) if not 2 * n <= i < 2 * (n + s)]
    best = deviance(vector)
    for _ in range(rounds):
        before = best
        for i in free:
            for sign in (1.0, -1.0):
                trial = vector.copy()
                trial[i] += sign * sizes[i]
                trial = np.maximum(trial, code.least)
                value = deviance(trial)
                if value < best:
                    best, vector = value, trial
                    break
        if not best < before:
            sizes *= 0.4
    return code.unpack(vector)


_LIMIT = 0.7


def _solve(normal: FloatArray, slope: FloatArray, damping: float) -> FloatArray:
    """Return a damped step, in the scale of the normal matrix' own diagonal."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-30))
    shaped = normal / np.outer(scale, scale) + damping * np.eye(scale.size)
    step: FloatArray = -np.linalg.solve(shaped + 1e-12 * np.eye(scale.size), slope / scale)
    return step / scale


def _normal_equations(
    parts_at: Callable[[FloatArray], tuple[list[FloatArray], float] | None],
    vector: FloatArray,
    parts: list[FloatArray],
    steps: FloatArray,
    free: NDArray[np.intp],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normal matrix and slope of half the sum of squares, and the slopes' scatter.

    The scatter is the sum over the thirds of all segments of the squares of their own slopes.
    """
    flat = _flat(parts)
    columns = np.zeros((free.size, flat.size), dtype=np.float32)
    for row, i in enumerate(free):
        for sign in (1.0, -1.0):
            moved = vector.copy()
            moved[i] += sign * steps[i]
            there = parts_at(moved)
            if there is not None:
                columns[row] = (_flat(there[0]) - flat) / (sign * steps[i])
                break
    own = columns * flat.astype(np.float32)
    thirds, at = [], 0
    for part in parts:
        shaped = own[:, at : at + part.size].reshape(free.size, *part.shape)
        thirds += [third.sum(axis=(1, 2)) for third in np.array_split(shaped, 3, axis=2)]
        at += part.size
    slopes = np.array(thirds, dtype=float).T
    normal = (columns @ columns.T).astype(float)
    return normal, slopes.sum(axis=1), slopes @ slopes.T


def _variance(normal: FloatArray, meat: FloatArray, spread: float) -> FloatArray:
    """Return the variances of a fit: by the curvature, or by the scatter where that is more.

    The curvature is right where innovations are independent; beside the jumps of a force they
    are not, and the scatter of the slopes from stretch to stretch tells it [1]_.

    References
    ----------
    .. [1] H. White, "Maximum likelihood estimation of misspecified models", Econometrica 50,
       1-25, 1982.
    """
    inverse = np.linalg.pinv(normal)
    scattered = np.diag(inverse @ meat @ inverse)
    larger: FloatArray = np.maximum(np.diag(inverse) * spread, scattered)
    return larger
