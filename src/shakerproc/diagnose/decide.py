"""From what was found to a verdict in words and numbers."""

from collections.abc import Sequence

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.problem import Hypothesis, Parameters, Segment, Term
from shakerproc.diagnose.search import DRY, Bench, Context, deviance
from shakerproc.diagnosis.result import Estimate

EXPONENT = 3.0
"""Exponent at which a power law is a cubic spring [-]."""
ALIKE = 1.2
"""By how much the cost of a simpler law may exceed that of the richer one that holds it [-]."""
RUGGED = 5e-3
"""How far from the top a fit of dry friction ends, where every stick and slip is a step in the
likelihood; seen on tuning draws, one standard deviation [-]."""
CALIBRATION = 2e-3
"""How well the sensors' gains are known, one standard deviation [-]."""


def size(fit: Fit) -> int:
    """Return how many numbers a hypothesis adds to the linear model."""
    return sum(len(term.candidate.names) for term in fit.hypothesis.terms)


def window(fits: Sequence[Fit]) -> float:
    """Return by how much deviances must differ for data of this size to tell hypotheses apart.

    Bayes' price for one number, or 1 % of the variance of the innovations: what the numerics
    and the calibration of the sensors leave in doubt.
    """
    count = min(fit.count for fit in fits)
    return max(float(np.log(count)), 0.01 * count)


def rank(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits, the best first; of those as good as the best, the simplest first."""
    if not fits:
        return []
    by_likelihood = sorted(fits, key=deviance)
    edge = deviance(by_likelihood[0]) + window(by_likelihood)
    best = by_likelihood[0]
    near = [
        fit for fit in by_likelihood
        if deviance(fit) <= edge or (_is_case_of(fit, best) and fit.cost < ALIKE * best.cost)
    ]  # fmt: skip
    far = [fit for fit in by_likelihood if fit not in near]
    return sorted(near, key=lambda fit: (size(fit), deviance(fit))) + far


def _is_case_of(fit: Fit, richer: Fit) -> bool:
    """Return whether a fit is a richer one with a number that its interval holds.

    A power law whose exponent may be 3 is a cubic spring; play that may be the same on both
    sides is a plain gap.
    """
    simple = {"power_law": "cubic_stiffness", "offset_gap": "gap"}
    if len(kinds(fit)) != len(kinds(richer)):
        return False
    for i, (own, other) in enumerate(zip(kinds(fit), kinds(richer), strict=True)):
        if own == other:
            continue
        if simple.get(other) != own:
            return False
        numbers = estimates(richer, i)
        if other == "power_law":
            low, high = numbers["exponent"].low or 0.0, numbers["exponent"].high or 0.0
            if not low <= EXPONENT <= high:
                return False
            continue
        one, two = numbers["clearance_positive"], numbers["clearance_negative"]
        if max(one.low or 0.0, two.low or 0.0) > min(one.high or 0.0, two.high or 0.0):
            return False
    return True


def kinds(fit: Fit) -> tuple[str, ...]:
    """Return the kinds of a hypothesis."""
    return tuple(term.candidate.kind for term in fit.hypothesis.terms)


def ties(ordered: Sequence[Fit]) -> list[Fit]:
    """Return the fits that explain the data as well as the first, with other effects."""
    if not ordered:
        return []
    edge = min(deviance(fit) for fit in ordered) + window(ordered)
    return [fit for fit in rivals(ordered) if deviance(fit) <= edge]


def rivals(ordered: Sequence[Fit]) -> list[Fit]:
    """Return the fits after the first that do not contain all of its effects."""
    best = set(kinds(ordered[0]))
    return [fit for fit in ordered[1:] if not best <= set(kinds(fit))]


def intervals(fit: Fit) -> FloatArray:
    """Return the standard deviation of every scaled number of a fit."""
    return np.sqrt(np.maximum(fit.variance, 0.0) + CALIBRATION**2)


def estimates(fit: Fit, term_index: int) -> dict[str, Estimate]:
    """Return the parameters of one term, with 95 % intervals, as its effect names them."""
    term: Term = fit.hypothesis.terms[term_index]
    values = fit.parameters.values[term_index]
    n, s = fit.parameters.stiffness.size, fit.parameters.gain.size
    first = 2 * n + 2 * s + sum(len(v) for v in fit.parameters.values[:term_index])
    sigma = intervals(fit)[first : first + len(values)]
    if term.candidate.kind in DRY:
        sigma = np.hypot(sigma, RUGGED)
    out: dict[str, Estimate] = {}
    for name, unit, value, sd, positive in zip(
        term.candidate.names, term.candidate.units, values, sigma, term.candidate.positive,
        strict=True,
    ):  # fmt: skip
        if positive:
            factor = float(np.exp(min(1.96 * sd, 50.0)))
            out[name] = Estimate(value, value / factor, value * factor, unit)
        else:
            half = float(1.96 * sd * abs(_start_scale(fit, term_index, name)))
            out[name] = Estimate(value, value - half, value + half, unit)
    return as_effect(term, out)


def linear_estimates(fit: Fit) -> tuple[tuple[Estimate, Estimate], ...]:
    """Return stiffness and damping of every joint with 95 % intervals."""
    n = fit.parameters.stiffness.size
    half = 1.96 * intervals(fit)[: 2 * n] * fit.linear_scales
    out = []
    for i in range(n):
        k, c = float(fit.parameters.stiffness[i]), float(fit.parameters.damping[i])
        dk, dc = float(half[i]), float(half[n + i])
        out.append((Estimate(k, k - dk, k + dk, "N/m"), Estimate(c, c - dc, c + dc, "N s/m")))
    return tuple(out)


def _start_scale(fit: Fit, term_index: int, name: str) -> float:
    at = fit.hypothesis.terms[term_index].candidate.names.index(name)
    return fit.scales[term_index][at]


def _estimate(numbers: list[float], unit: str) -> Estimate:
    value, low, high = numbers
    return Estimate(value, low, high, unit)


def as_effect(term: Term, fitted: dict[str, Estimate]) -> dict[str, Estimate]:
    """Return the estimates under the names of the effect in the model file."""
    out = dict(fitted)
    if "excess" in out:
        extra, sliding = out.pop("excess"), out["sliding_force"]
        force = float(sliding.value) * (1.0 + float(extra.value))
        shares = [
            np.hypot(
                float(s or 0.0) / float(sliding.value) - 1.0,
                (1.0 + float(e or 0.0)) / (1.0 + float(extra.value)) - 1.0,
            )
            for s, e in ((sliding.low, extra.low), (sliding.high, extra.high))
        ]
        numbers = [force, force * (1.0 - shares[0]), force * (1.0 + shares[1])]
        out["breakaway_force"] = _estimate([float(x) for x in numbers], "N")
    if "bristle_ratio" in out:
        ratio, bristle = out.pop("bristle_ratio"), out["bristle_stiffness"]
        root = float(np.sqrt(float(bristle.value) * term.mass))
        numbers = [float(x) * root for x in (ratio.value, ratio.low or 0.0, ratio.high or 0.0)]
        out["bristle_damping"] = _estimate(numbers, "N s/m")
        out["viscous_damping"] = Estimate(0.0, 0.0, 0.0, "N s/m")
    if term.candidate.kind == "jenkins":
        k, slip = out["stiffness"], out.pop("slip_displacement")
        numbers = [float(k.value) * float(x or 0.0) for x in (slip.value, slip.low, slip.high)]
        out["slip_force"] = _estimate(numbers, "N")
    for name, value in term.candidate.fixed.items():
        unit = {"reference": "s", "reference_displacement": "m"}.get(name, "")
        number = value if isinstance(value, str) else float(value)
        out[name] = (
            Estimate(number, None, None, unit)
            if isinstance(number, str)
            else Estimate(number, number, number, unit)
        )
    return out


def error_of(
    at: Context, hypothesis: Hypothesis, p: Parameters, segments: tuple[Segment, ...], *,
    robust: bool = False,
) -> float:  # fmt: skip
    """Return rms of what is not predicted over rms of the response, over these segments.

    The prediction is one sample ahead, by an observer that follows the measurement as far as
    the noise of the sensors justifies. Where `robust`, samples that miss by far weigh less.
    """
    above = below = 0.0
    for segment in segments:
        seen = at.judged(hypothesis, p, (segment,), robust=robust)
        if seen is None:
            return float("inf")
        parts, logs = seen
        count = parts[0].size
        above += float(np.sum(parts[0] ** 2)) * float(np.exp(logs / count))
        below += float(np.sum(_counted(segment) ** 2))
    return float(np.sqrt(above / max(below, 1e-300)))


def _counted(segment: Segment) -> FloatArray:
    """Return the samples of a segment that are judged, 0 for those that do not count."""
    return segment.measured[:, segment.skip :] * (segment.weight[:, segment.skip :] > 0.0)


def noise_floor(segments: tuple[Segment, ...], bench: Bench) -> float:
    """Return rms of the sensors' noise over rms of the response, over these segments."""
    above = below = 0.0
    for segment in segments:
        counted = segment.weight[:, segment.skip :] > 0.0
        noise = bench.prepared[segment.test].noise
        above += float(np.sum(noise**2 @ counted))
        below += float(np.sum(_counted(segment) ** 2))
    return float(np.sqrt(above / max(below, 1e-300)))
