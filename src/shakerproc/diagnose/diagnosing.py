"""From a model and its tests to a diagnosis."""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnose.arrays import Correction
from shakerproc.diagnose.candidates import Candidate
from shakerproc.diagnose.decide import (
    error_of,
    estimates,
    intervals,
    kinds,
    linear_estimates,
    noise_floor,
    rank,
    rivals,
    ties,
)
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.imposed import diagnose_imposed
from shakerproc.diagnose.next_test import loudest, settle, times_level
from shakerproc.diagnose.pipeline import MATTERS, Findings, investigate
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    assemble,
    law_table,
    run,
)
from shakerproc.diagnose.search import DRY, deviance
from shakerproc.diagnose.structure import angular_frequencies, pattern
from shakerproc.diagnose.translate import Skeleton, skeleton, start_parameters
from shakerproc.diagnosis.data import TestArrays, check
from shakerproc.diagnosis.result import (
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    NextTest,
    Pair,
    Tried,
    Verdict,
    Where,
)
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model
from shakerproc.testlog import Shaker

GAIN_TOLERANCE = 0.01
"""Gain error of a sensor below which no fault is named [-]."""
NEGLIGIBLE = 0.01
"""Share of the response that is as good as explained: what sensors are calibrated to [-]."""
DELAY_TOLERANCE = 5e-6
"""Delay below which no fault is named [s]."""


def diagnose_arrays(
    model: Model,
    tests: Sequence[TestArrays],
    *,
    sensors: Sequence[str] | None = None,
    clearances: Sequence[float] = (),
    shaker: Shaker = Shaker(),  # noqa: B008
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from samples in memory.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of TestArrays
        Tests whose responses stand in the order of `sensors`.
    sensors : sequence of str, optional
        Names of the responses; by default all sensors of the model.
    clearances : sequence of float, optional
        Free play that the log says the specimens have [m].
    shaker : Shaker, optional
        Limits for the test that is proposed.
    seed : int
        Returned with the result; nothing is drawn.
    progress : callable, optional
        Called with what is being done.

    Returns
    -------
    Diagnosis
        The verdict and all that stands behind it.

    Raises
    ------
    DiagnosisError
        If the tests do not fit the model, or are too short.
    """
    names = tuple(model.sensors if sensors is None else sensors)
    known = skeleton(model, names)
    for test in tests:
        check(test, len(names))
    used = tuple(tests)
    if not used:
        raise DiagnosisError(
            f"{model.title}: no test to judge by; the log has none that was run."
        )
    base, start = start_parameters(known)
    say = progress or (lambda _text: None)
    imposed = diagnose_imposed(known, used, base, start, clearances, say, seed)
    if imposed is not None:
        return imposed
    try:
        found = investigate(known.structure, used, base, start, progress=say)
    except FloatingPointError as error:
        raise DiagnosisError(
            f"{model.title}: {error}; check stiffness, damping and masses of the model."
        ) from error
    say("the verdict")
    return _worded(known, found, used, base, start, clearances, shaker, seed)


def _worded(
    known: Skeleton, found: Findings, tests: tuple[TestArrays, ...], base: Hypothesis,
    start: Parameters, clearances: Sequence[float], shaker: Shaker, seed: int,
) -> Diagnosis:  # fmt: skip
    at, linear = found.at, found.linear
    fitted, kept = at.bench.fitted(), at.bench.kept()
    ordered = rank(found.fits)
    best = ordered[0] if ordered else None
    real = best is not None and _matters(best, linear)
    chosen = best if real and best is not None else linear
    n_base = len(base.terms)
    same = tuple(dict.fromkeys(
        kind for f in ties(ordered) for kind in kinds(f) if kind not in kinds(ordered[0])
    )) if real else ()  # fmt: skip
    errors = Errors(
        Pair(
            error_of(at, base, start, fitted),
            error_of(at, chosen.hypothesis, chosen.parameters, fitted),
        ),
        Pair(
            error_of(at, base, start, kept),
            error_of(at, chosen.hypothesis, chosen.parameters, kept),
        ),
        noise_floor(kept, at.bench),
    )
    faults = _faults(known, found, chosen)
    effects = [
        Finding(
            term.candidate.kind, known.between(term.joint), _confidence(ordered),
            estimates(chosen, n_base + i),
        )
        for i, term in enumerate(chosen.hypothesis.terms[n_base:])
    ]  # fmt: skip
    if real and best is not None:
        outside = _outside(found, best, errors, fitted)
    else:
        outside = any(
            one.after > max(2.0 * errors.noise_floor, NEGLIGIBLE, 0.06 * one.before)
            for one in (errors.fitted, errors.held_out)
        )
    if outside:
        faults = [f for f in faults if _stands_alone(f, known)]
    verdict, sentence = _verdict(
        known, effects, faults, same, errors, clearances, found, outside=outside
    )
    if verdict in {"outside library", "cannot tell"}:
        effects = []
    tried = [_tried(known, found, fit, (fitted, kept), n_base) for fit in ordered]
    tried += [
        Tried(part.candidate.kind, known.between(part.joint), None, None, _side(part.candidate))
        for part in (start.last for start in found.starts)
        if part.candidate.kind not in {t.kind for t in tried}
    ]
    return Diagnosis(
        verdict=verdict,
        sentence=sentence,
        effects=(*effects, *faults),
        indistinguishable=same,
        errors=errors,
        candidates=tuple(tried),
        where=_where(found, base, start),
        next_test=_next(found, ordered, same, verdict, clearances, tests, shaker, seed),
        linear=_linear(known, chosen),
        notes=_notes(tests),
        seed=seed,
    )


def _side(candidate: Candidate) -> dict[str, Estimate]:
    """Return what tells candidates of one kind apart: the side of a stop."""
    words = {name: value for name, value in candidate.fixed.items() if isinstance(value, str)}
    return {name: Estimate(word, None, None, "") for name, word in words.items()}


def _stands_alone(fault: Finding, known: Skeleton) -> bool:
    """Return whether a fault is no mere make-up for physics that is not known.

    Unknown physics bends amplitude and phase near the resonance: it may pass for a gain, or for
    a delay of a small part of a period.
    """
    if fault.kind == "sensor_delay":
        period = 2.0 * np.pi / float(angular_frequencies(known.structure)[0])
        return abs(float(fault.parameters["delay"].value)) > 0.1 * period
    return fault.kind != "sensor_gain"


def _matters(best: Fit, linear: Fit) -> bool:
    """Return whether a fit explains more than a share of what the linear model leaves."""
    spread = max(best.cost / best.count, 1e-3)
    gained = (deviance(linear) - deviance(best)) / spread
    return gained > MATTERS * best.count and gained > 50.0


def _outside(found: Findings, best: Fit, errors: Errors, fitted) -> bool:  # type: ignore[no-untyped-def]
    """Return whether the best candidate leaves clearly more than noise unexplained."""
    at = found.at
    # beside the jumps of dry friction samples miss by far, whatever the model
    robust = bool(DRY.intersection(kinds(best)))
    after = error_of(at, best.hypothesis, best.parameters, fitted, robust=robust)
    linear = error_of(at, found.linear.hypothesis, found.linear.parameters, fitted)
    floor = noise_floor(fitted, at.bench)
    excess = float(np.sqrt(max(after**2 - floor**2, 0.0)))
    return after > max(1.5 * floor, NEGLIGIBLE) and excess > 0.06 * linear


def _confidence(ordered: Sequence[Fit]) -> float:
    """Return the weight of the best among all, by their likelihoods on blocks."""
    best = deviance(ordered[0])
    spread = max(ordered[0].cost / ordered[0].count, 1.0) * 10.0
    gaps = np.array([(deviance(fit) - best) / spread for fit in rivals(ordered)])
    weights = np.exp(-0.5 * np.clip(gaps, 0.0, 500.0))
    return float(min(1.0 / (1.0 + np.sum(weights)), 0.99))


def _faults(known: Skeleton, found: Findings, chosen: Fit) -> list[Finding]:
    fix: Correction = found.correction
    out = []
    n, s = chosen.parameters.stiffness.size, chosen.parameters.gain.size
    sigma = intervals(chosen)
    for i, name in enumerate(known.sensors):
        gain = float(chosen.parameters.gain[i] * fix.gain[i])
        delay = float(chosen.parameters.delay[i] + fix.delay[i])
        own = float(sigma[2 * n + i]) * 0.01 * abs(gain) * 1.96
        late = float(sigma[2 * n + s + i]) * 1e-5 * 1.96
        if gain < 0.0:
            out.append(Finding("sensor_polarity", (name,), 0.99, {}))
        if abs(abs(gain) - 1.0) > GAIN_TOLERANCE:
            gains = {"gain": Estimate(abs(gain), abs(gain) - own, abs(gain) + own, "1")}
            out.append(Finding("sensor_gain", (name,), 0.98, gains))
        if abs(delay) > DELAY_TOLERANCE:
            delays = {"delay": Estimate(delay, delay - late, delay + late, "s")}
            out.append(Finding("sensor_delay", (name,), 0.98, delays))
    seen = set()
    for kind, sensor, value in found.faults:
        if (kind, sensor) in seen:
            continue
        seen.add((kind, sensor))
        label, unit = ("frequency", "Hz") if kind == "mains_hum" else ("level", "m/s^2")
        numbers = {label: Estimate(value, value, value, unit)}
        out.append(Finding(kind, (known.sensors[sensor],), 0.98, numbers))
    return out


def _verdict(
    known: Skeleton, effects: Sequence[Finding], faults: Sequence[Finding],
    same: tuple[str, ...], errors: Errors, clearances: Sequence[float], found: Findings,
    *, outside: bool,
) -> tuple[Verdict, str]:  # fmt: skip
    named = " and ".join(
        f"{e.kind.replace('_', ' ')} between {' and '.join(e.between)}" for e in effects
    )
    wrong = " and ".join(f"{f.kind.replace('_', ' ')} of {f.between[0]}" for f in faults)
    held = errors.held_out
    fall = f"the held-out error falls from {held.before:.3g} to {held.after:.3g}"
    if outside:
        nearest = f"the nearest, {named}," if effects else "the refitted model"
        return "outside library", (
            f"Something is missing that is not in the library: {nearest} leaves "
            f"{held.after:.3g} of the response where the noise is {errors.noise_floor:.3g}."
        )
    if effects:
        beside = f"; besides, the measurement has a {wrong}" if wrong else ""
        doubt = f"; {', '.join(same)} would do as well on these tests" if same else ""
        return "effect found", f"The model lacks {named}: {fall}{doubt}{beside}."
    if faults:
        return (
            "measurement fault",
            f"The measurement has a {wrong}; no physics is missing: {fall}.",
        )
    reach = _reach(found)
    unexercised = [c for c in clearances if c > reach]
    if unexercised:
        times = min(unexercised) / reach
        return "cannot tell", (
            f"The joint has a clearance of {min(unexercised):.3g} m but moved {reach:.3g} m at "
            f"most: it never closed. {times:.2g} times the level would close it."
        )
    return "nothing missing", (
        f"Nothing is missing up to a motion of {reach:.3g} m: the refitted model leaves "
        f"{held.after:.3g} of the response, the noise of the sensors {errors.noise_floor:.3g}."
    )


def _reach(found: Findings) -> float:
    """Return the largest relative displacement in any joint over all tests [m]."""
    at, fit = found.at, found.linear
    whole = assemble(at.bench.structure, fit.hypothesis, fit.parameters)
    table = law_table(at.bench.structure, fit.hypothesis, fit.parameters, whole.masses.size)
    tunings = at.tuned(fit.hypothesis, fit.parameters)
    reach = 0.0
    for segment in at.bench.whole:
        seen = run(whole, table, segment, tunings[segment.gain_key], fit.parameters, keep=True)
        if seen is None:
            continue
        for joint in at.bench.structure.joints:
            row = pattern(joint, at.bench.structure.masses.size)
            moved = row @ seen.states[: row.size]
            reach = max(reach, float(np.max(np.abs(moved))))
    return reach


def _tried(
    known: Skeleton, found: Findings, fit: Fit,
    parts: tuple[tuple[Segment, ...], tuple[Segment, ...]], n_base: int,
) -> Tried:  # fmt: skip
    terms = fit.hypothesis.terms[n_base:]
    numbers: dict[str, Estimate] = {}
    for i, term in enumerate(terms):
        before = f"{term.candidate.kind} " if len(terms) > 1 else ""
        numbers |= {before + k: v for k, v in estimates(fit, n_base + i).items()}
    return Tried(
        "+".join(term.candidate.kind for term in terms),
        known.between(terms[-1].joint),
        error_of(found.at, fit.hypothesis, fit.parameters, parts[0]),
        error_of(found.at, fit.hypothesis, fit.parameters, parts[1]),
        numbers,
    )


def _where(found: Findings, base: Hypothesis, start: Parameters) -> Where:
    """Return where the model as it was fails: bands, motions and tests above the average."""
    at = found.at
    whole = assemble(at.bench.structure, base, start)
    table = law_table(at.bench.structure, base, start, whole.masses.size)
    tunings = at.tuned(base, start)
    power, tests, moved, fast, left = 0.0, {}, [], [], []
    frequency = np.zeros(0)
    size = min([1024, *(s.measured.shape[1] for s in at.bench.whole)])
    for segment in (s for s in at.bench.whole if not s.hold_out):
        seen = run(whole, table, segment, tunings[segment.gain_key], start, keep=True)
        if seen is None:
            continue
        frequency, own = scipy.signal.welch(seen.innovations, segment.sample_rate, nperseg=size)
        power = power + own.sum(axis=0)
        tests[segment.name] = float(np.mean(seen.innovations**2))
        row = pattern(at.bench.structure.joints[0], at.bench.structure.masses.size)
        moved.append(np.abs(row @ seen.states[: row.size]))
        fast.append(np.abs(row @ seen.states[row.size : 2 * row.size]))
        left.append(np.sum(seen.innovations**2, axis=0))
    if not tests:
        return Where()
    return Where(
        _bands(frequency, np.asarray(power)),
        _range(np.concatenate(moved), np.concatenate(left)),
        _range(np.concatenate(fast), np.concatenate(left)),
        tuple(name for name, value in tests.items() if value > 1.5),
    )


def _bands(frequency: FloatArray, power: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return the third-octaves that hold most of what is left, joined where they touch."""
    edges = 5.0 * 2.0 ** (np.arange(28) / 3.0)
    sums = np.array([
        float(np.sum(power[(frequency >= a) & (frequency < b)])) for a, b in pairwise(edges)
    ])
    out: list[tuple[float, float]] = []
    for a, b, value in zip(edges[:-1], edges[1:], sums, strict=True):
        if value < 0.1 * np.sum(sums) or value == 0.0:
            continue
        if out and np.isclose(out[-1][1], a):
            out[-1] = (out[-1][0], float(b))
        else:
            out.append((float(a), float(b)))
    return tuple(out)


def _range(size: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Return the range of a motion over which more than the average is left."""
    edges = np.quantile(size, np.linspace(0.0, 1.0, 21))
    index = np.clip(np.searchsorted(edges, size) - 1, 0, 19)
    count = np.bincount(index, minlength=20)
    mean = np.bincount(index, left, minlength=20) / np.maximum(count, 1)
    bad = np.flatnonzero(mean > np.mean(left))
    if bad.size == 0:
        return float(edges[0]), float(edges[-1])
    return float(edges[bad[0]]), float(edges[bad[-1] + 1])


def _next(
    found: Findings, ordered: Sequence[Fit], same: tuple[str, ...], verdict: Verdict,
    clearances: Sequence[float], tests: Sequence[TestArrays], shaker: Shaker, seed: int,
) -> tuple[NextTest, ...]:  # fmt: skip
    at = found.at
    if same and ordered:
        rival = next(f for f in ties(ordered))
        one, other = kinds(ordered[0]), kinds(rival)
        names = (*(k for k in one if k not in other), *(k for k in other if k not in one))
        return settle(at, [ordered[0], rival], names, tests, shaker, seed)
    if verdict in {"nothing missing", "cannot tell"}:
        reach = _reach(found)
        beyond = [c for c in clearances if c > reach]
        times = 1.2 * min(beyond) / reach if beyond else 2.0
        test = loudest(tests)
        level = times_level(test, times, forced=at.bench.structure.forced >= 0)
        reason = "closes the clearance of the log" if beyond else "moves beyond what was tested"
        return (NextTest(test.excitation, level, (), reason, test.band, test.name),)
    return ()


def _linear(known: Skeleton, fit: Fit) -> Mapping[str, Estimate]:
    out = {}
    for i, (stiffness, damping) in enumerate(linear_estimates(fit)):
        a, b = known.between(i)
        out[f"stiffness {a}-{b}"] = stiffness
        out[f"damping {a}-{b}"] = damping
    return out


def _notes(tests: tuple[TestArrays, ...]) -> tuple[str, ...]:
    out = []
    if not any(t.hold_out for t in tests):
        out.append(
            "No test is marked hold_out: true; the held-out error is of every third block of "
            "the tests, which took no part in the fit."
        )
    if len({round(float(np.std(t.controls)), 6) for t in tests}) < 2:
        out.append("All tests are at one level: what depends on amplitude is hard to see.")
    return tuple(out)
