"""The verdict: which hypothesis stands, which stand beside it, and what is said of the rest."""

from collections.abc import Sequence

import numpy as np

from shakerproc.diagnosis.estimation.correction import applied_delay, applied_gain
from shakerproc.diagnosis.estimation.intervals import covariance, estimates, linear_estimates
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.linear import LinearModel
from shakerproc.diagnosis.result import (
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    Pair,
    Tried,
    Verdict,
    Where,
)
from shakerproc.diagnosis.search import Found
from shakerproc.diagnosis.selection.errors import error_of, floor_of
from shakerproc.diagnosis.selection.scores import ALIKE, Score, gain, simplest_alike
from shakerproc.models import Model
from shakerproc.testlog import Shaker

SURE = 3.0
"""Standard errors by which an effect must predict better than none: once in 700 by chance [-]."""

GAIN_TOLERANCE = 0.03
"""Gain error of a sensor from which it is a fault: three times its spread [-]."""

DELAY_TOLERANCE = 40e-6
"""Delay of a channel from which it is a fault: twice its spread [s]."""

EXCESS = 1.5
"""Error over the noise floor up to which nothing more is to be found [-]."""


def judged(
    model: Model, found: Found, *, clearances: Sequence[float], shaker: Shaker, seed: int
) -> Diagnosis:
    """Return the verdict on what the search found."""
    standing = _standing(found)
    chosen = standing[0] if standing else found.linear
    fit = chosen.fit
    errors = _errors(found, fit)
    faults = _faults(model, fit, found.linear_model)
    alike = _indistinguishable(standing)
    effects = [
        Finding(one.kind, one.between, 0.99, estimates(fit, i))
        for i, one in enumerate(fit.hypothesis.added)
    ]
    outside = errors.held_out.after > max(EXCESS * errors.noise_floor, 0.01) and (
        errors.held_out.after > 0.06 * errors.held_out.before
    )
    verdict = _verdict(effects, faults, outside=outside)
    if verdict == "outside library":
        effects = []
    return Diagnosis(
        verdict=verdict,
        sentence=_sentence(verdict, effects, faults, errors, alike),
        effects=(*effects, *faults),
        indistinguishable=alike if effects else (),
        errors=errors,
        candidates=tuple(_tried(found, s) for s in found.effects),
        where=Where(),
        next_test=(),
        linear=linear_estimates(fit),
        notes=found.linear_model.notes,
        scores=_features(found, standing, errors),
        seed=seed,
    )


def _standing(found: Found) -> list[Score]:
    """Return the hypotheses that predict best and better than none, the simplest first."""
    better = [s for s in found.effects if gain(s, found.linear).t > SURE]
    return simplest_alike(better) if better else []


def _indistinguishable(standing: Sequence[Score]) -> tuple[str, ...]:
    """Return the kinds that predict as well as the chosen one and are no richer."""
    if not standing:
        return ()
    first = standing[0].fit.hypothesis
    kinds = [
        kind for s in standing[1:] if s.fit.hypothesis.size <= first.size
        for kind in s.fit.hypothesis.kinds if kind not in first.kinds
    ]  # fmt: skip
    return tuple(dict.fromkeys(kinds))


def _errors(found: Found, fit: Fit) -> Errors:
    form, data = found.form, found.data
    start = found.before
    fitted, held = form.scored_fitted, form.held_out
    return Errors(
        Pair(error_of(found.data, start, fitted), error_of(data, fit, fitted)),
        Pair(error_of(found.data, start, held), error_of(data, fit, held)),
        floor_of(data, fit, held),
        {test.name: form.horizon for test in data.tests},
    )


def _faults(model: Model, fit: Fit, linear: LinearModel) -> list[Finding]:
    n, n_sensors = fit.hypothesis.size, fit.gain.size
    spread = 1.96 * np.sqrt(np.maximum(np.diag(covariance(fit)), 0.0))
    out = []
    for i, name in enumerate(model.sensors):
        gain_ = float(fit.gain[i] * applied_gain(linear)[i])
        delay = float(fit.delay[i] + applied_delay(linear)[i])
        own, late = float(spread[n + i]), float(spread[n + n_sensors + i])
        if gain_ < 0.0:
            out.append(Finding("sensor_polarity", (name,), 0.99, {}))
        if abs(abs(gain_) - 1.0) > GAIN_TOLERANCE:
            value = Estimate(abs(gain_), abs(gain_) - own, abs(gain_) + own, "1")
            out.append(Finding("sensor_gain", (name,), 0.98, {"gain": value}))
        if abs(delay) > DELAY_TOLERANCE:
            value = Estimate(delay, delay - late, delay + late, "s")
            out.append(Finding("sensor_delay", (name,), 0.98, {"delay": value}))
    return out


def _verdict(
    effects: Sequence[Finding], faults: Sequence[Finding], *, outside: bool
) -> Verdict:
    if outside:
        return "outside library"
    if effects:
        return "effect found"
    return "measurement fault" if faults else "nothing missing"


def _sentence(
    verdict: Verdict, effects: Sequence[Finding], faults: Sequence[Finding], errors: Errors,
    alike: Sequence[str],
) -> str:  # fmt: skip
    held = errors.held_out
    fall = f"the held-out free-run error falls from {held.before:.3g} to {held.after:.3g}"
    named = " and ".join(
        f"{e.kind.replace('_', ' ')} between {' and '.join(e.between)}" for e in effects
    )
    wrong = " and ".join(f"{f.kind.replace('_', ' ')} of {f.between[0]}" for f in faults)
    if verdict == "outside library":
        return (
            f"Something is missing that is not in the library: the best that was tried leaves "
            f"{held.after:.3g} of the response where the noise is {errors.noise_floor:.3g}."
        )
    if verdict == "effect found":
        doubt = f"; {', '.join(alike)} predict these tests as well" if alike else ""
        beside = f"; besides, the measurement has a {wrong}" if wrong else ""
        return f"The model lacks {named}: {fall}{doubt}{beside}."
    if verdict == "measurement fault":
        return f"The measurement has a {wrong}; no physics is missing: {fall}."
    return (
        f"Nothing is missing: the fitted model leaves {held.after:.3g} of the response, the "
        f"noise {errors.noise_floor:.3g}."
    )


def _features(found: Found, standing: Sequence[Score], errors: Errors) -> dict[str, float]:
    """Return the numbers that the probability is made of."""
    best = found.effects[0] if found.effects else found.linear
    rest = [s for s in found.effects if s not in standing]
    return {
        "gain_over_linear": gain(best, found.linear).mean,
        "t_over_linear": float(np.clip(gain(best, found.linear).t, -50.0, 50.0)),
        "t_over_next": float(
            np.clip(min([gain(best, s).t for s in rest], default=50.0), -50.0, 50.0)
        ),
        "alike": float(len(standing)),
        "excess": float(
            np.log(max(errors.held_out.after, 1e-9) / max(errors.noise_floor, 1e-9))
        ),
        "left": float(
            np.log(max(errors.held_out.after, 1e-9) / max(errors.held_out.before, 1e-9))
        ),
    }


def _tried(found: Found, score: Score) -> Tried:
    fit = score.fit
    numbers: dict[str, Estimate] = {}
    for i, one in enumerate(fit.hypothesis.added):
        before = f"{one.kind} " if len(fit.hypothesis.added) > 1 else ""
        numbers |= {before + k: v for k, v in estimates(fit, i).items()}
    return Tried(
        "+".join(fit.hypothesis.kinds),
        fit.hypothesis.added[-1].between,
        error_of(found.data, fit, found.form.scored_fitted),
        error_of(found.data, fit, found.form.held_out),
        numbers,
    )


__all__ = ["ALIKE", "judged"]
