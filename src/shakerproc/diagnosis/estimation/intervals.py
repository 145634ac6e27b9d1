"""Intervals of 95 % from the scatter between blocks, model error included."""

from typing import Final

import numpy as np

from shakerproc.comparison.measured import UNCALIBRATED
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimate import Estimate, Known
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.uncertain import Number, known_together
from shakerproc.diagnosis.hypotheses.hypothesis import Addition
from shakerproc.diagnosis.hypotheses.own_numbers import own_names

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
    """Return the numbers of an added effect with their intervals.

    Of what is positive in logarithms; open where no test tells a number, and where it stands
    at a bound.
    """
    one, (_own, *added) = fit.hypothesis.added[index], fit.hypothesis.parts(fit.x)
    out = numbers(fit, index)
    for name, number in _of_effect(fit, index).items():
        value, unit = number.value, number.unit
        out[name] = fit.uncertainty.of(number.slopes).interval(value, unit)
        if not np.any(number.slopes):
            out[name] = Estimate(value, value, value, unit)
    return _unexercised(out, one, added[index], *one.bounds())


def known_of(fit: Fit) -> tuple[Known, ...]:
    """Return combinations of numbers that the tests determine where not each one by itself."""
    every = dict(_own_numbers(fit))
    for i, one in enumerate(fit.hypothesis.added):
        kind = one.kind.replace("_", " ")
        for name, number in _of_effect(fit, i).items():
            if number.value != 0.0 and np.any(number.slopes):
                every[f"{name.replace('_', ' ')} of the {kind}"] = number
    return known_together(fit.uncertainty, every)


def _of_effect(fit: Fit, index: int) -> dict[str, Number]:
    """Return the numbers of an added effect, and how they move with all coordinates."""
    one, (_own, *added) = fit.hypothesis.added[index], fit.hypothesis.parts(fit.x)
    _places, *places = fit.hypothesis.parts(np.arange(fit.x.size, dtype=float))
    x, rows = added[index], places[index].astype(int)
    steps = np.where(x + DIFFERENCE > one.bounds()[1], -DIFFERENCE, DIFFERENCE)
    moved = [one.parameters(x + step) for step in np.diag(steps)]
    out = {}
    for name, found in numbers(fit, index).items():
        if isinstance(found.value, str):
            continue
        value, slopes = float(found.value), np.zeros(fit.x.size)
        changes = np.array([float(there[name]) - value for there in moved])
        slopes[rows] = changes / steps / (value or 1.0)
        out[name] = Number(value, slopes, found.unit)
    return out


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

    See `Hypothesis.far`.
    """
    ratios, far = np.exp(fit.x[: len(fit.hypothesis.own)]), fit.hypothesis.far(fit.x)
    rows = zip(linear_estimates(fit).items(), ratios, far, strict=True)
    return {name: (float(ratio), value) for (name, value), ratio, is_far in rows if is_far}


def numbers_off(fit: Fit) -> dict[str, tuple[float, Estimate]]:
    """Return the own numbers whose interval leaves out that of the model file: this, and that.

    Not those that are off by less than sensors are calibrated to.
    """
    size = len(fit.hypothesis.own)
    values = [number.value(fit.hypothesis.model) * number.sign for number in fit.hypothesis.own]
    rows = zip(linear_estimates(fit).items(), values, fit.x[:size], strict=True)
    return {
        name: (was, one)
        for (name, one), was, change in rows
        if abs(change) > UNCALIBRATED
        and one.low is not None
        and one.high is not None
        and not one.low <= was <= one.high
    }


def linear_estimates(fit: Fit) -> dict[str, Estimate]:
    """Return the model's own numbers with their intervals, by kind and joint."""
    return {
        name: fit.uncertainty.of(number.slopes).interval(number.value, number.unit)
        for name, number in _own_numbers(fit).items()
    }


def _own_numbers(fit: Fit) -> dict[str, Number]:
    """Return the model's own numbers, by kind and joint, and their own coordinates."""
    hypothesis, out = fit.hypothesis, {}
    names = own_names(hypothesis.model, hypothesis.own)
    for i, (name, number) in enumerate(zip(names, hypothesis.own, strict=True)):
        value = number.value(hypothesis.model) * number.sign * float(np.exp(fit.x[i]))
        out[name] = Number(value, np.eye(fit.x.size)[i], number.unit(hypothesis.model))
    return out
