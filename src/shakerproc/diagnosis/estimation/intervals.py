"""Intervals of 95 % from the scatter between blocks, model error included."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.scatter import UNTOLD
from shakerproc.diagnosis.hypotheses.hypothesis import FARTHEST, Addition
from shakerproc.diagnosis.hypotheses.naming import element_names, mass_name
from shakerproc.diagnosis.result import Estimate

WIDTH: Final = 1.96
"""Half width of a 95 % interval in standard errors [-]."""

DIFFERENCE: Final = 1e-5
"""Change of a coordinate for the slopes of the printed numbers [-]."""


def numbers(fit: Fit, index: int) -> dict[str, Estimate]:
    """Return the numbers of an added effect without intervals."""
    one, (_own, *added) = fit.hypothesis.added[index], fit.hypothesis.parts(fit.x)
    unit_of = fit.hypothesis.model.unit_of
    units = {name: unit_of(p.unit) for name, p in one.effect.estimated().items()}
    return {
        name: Estimate(value, None, None, "" if isinstance(value, str) else units[name])
        for name, value in one.parameters(added[index]).items()
    }


def estimates(fit: Fit, index: int) -> dict[str, Estimate]:
    """Return the numbers of an added effect with their intervals."""
    _own, *added = fit.hypothesis.parts(np.arange(fit.hypothesis.size, dtype=float))
    rows = added[index].astype(int)
    part = fit.widened_covariance[np.ix_(rows, rows)]
    return _with_intervals(numbers(fit, index), fit.hypothesis.added[index], fit.x[rows], part)


def _with_intervals(
    found: dict[str, Estimate], one: Addition, x: FloatArray, part: FloatArray
) -> dict[str, Estimate]:
    """Return numbers with intervals: spread through logarithms of what is positive."""
    low, high = one.bounds()
    out = dict(found)
    for name, number in found.items():
        if isinstance(number.value, str):
            continue
        value = float(number.value)
        slopes = np.array([
            (float(_moved(one, x, k)[name]) - value) / DIFFERENCE for k in range(x.size)
        ])
        spread = float(np.sqrt(max(slopes @ part @ slopes, 0.0)))
        out[name] = _estimate(value, spread, number.unit)
        if not np.any(slopes):
            out[name] = Estimate(value, value, value, number.unit)
    return _unexercised(out, one, x, low, high)


def _moved(one: Addition, x: FloatArray, k: int) -> Mapping[str, float | str]:
    there = x.copy()
    there[k] += DIFFERENCE
    return one.parameters(there)


def _estimate(value: float, spread: float, unit: str) -> Estimate:
    if value != 0.0 and spread < UNTOLD * abs(value):
        share = spread / abs(value)
        if value > 0.0:
            factor = float(np.exp(WIDTH * share))
            return Estimate(value, value / factor, value * factor, unit)
        return Estimate(value, value - WIDTH * spread, value + WIDTH * spread, unit)
    return Estimate(value, None, None, unit)


def _unexercised(
    numbers: dict[str, Estimate],
    one: Addition,
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> dict[str, Estimate]:
    """Return numbers of which those that stand at a bound have no interval on that side."""
    for i, name in enumerate(one.names):
        if name not in numbers or not isinstance(numbers[name].value, float):
            continue
        found = numbers[name]
        if x[i] >= high[i] - 1e-6:
            numbers[name] = Estimate(found.value, found.low, None, found.unit)
        elif x[i] <= low[i] + 1e-6:
            numbers[name] = Estimate(found.value, None, found.high, found.unit)
    return numbers


def far_numbers(fit: Fit) -> dict[str, tuple[float, Estimate]]:
    """Return the own numbers that are not the model's any more: how many times, and the value.

    See `FARTHEST`.
    """
    ratios = np.exp(fit.x[: len(fit.hypothesis.own)])
    return {
        name: (float(ratio), value)
        for (name, value), ratio in zip(linear_estimates(fit).items(), ratios, strict=True)
        if abs(np.log(ratio)) > np.log(FARTHEST)
    }


def linear_estimates(fit: Fit) -> dict[str, Estimate]:
    """Return the model's own numbers with their intervals, by kind and joint."""
    spread = np.sqrt(np.maximum(np.diag(fit.widened_covariance), 0.0))
    names = element_names(fit.hypothesis.model.elements)
    out = {}
    for i, number in enumerate(fit.hypothesis.own):
        value = number.value(fit.hypothesis.model) * number.sign * float(np.exp(fit.x[i]))
        if number.element is None:
            name, unit = mass_name(number.name), "kg"
        else:
            element = fit.hypothesis.model.elements[number.element]
            unit = element.effect.parameters[number.name].unit
            name = names[number.element, number.name]
        out[name] = _estimate(value, float(spread[i]) * abs(value), unit)
    return out
