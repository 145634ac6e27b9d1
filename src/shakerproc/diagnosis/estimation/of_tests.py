"""Numbers of each test alone: further excitation, and springs that drift."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import models_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.models import Element, Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects import Spring, StiffnessDrift
from shakerproc.models.laws import Law
from shakerproc.simulation import Input
from shakerproc.simulation.inputs import with_constant

STIFFNESS_SPREAD: Final = 0.005
"""Standard deviation of the stiffness in a test about that of the campaign, and of its change
while a test runs: joints settle and warm up (starting value) [-]."""

KEPT: Final = 2
"""Inputs that are kept: where a search is, and a step away [-]."""


def spreads_of(data: DataSet) -> FloatArray:
    """Return standard deviations of the numbers of tests beforehand, (n, n_tests) [-].

    The rows: the constant of the input over its rms, where a force drives; offsets of sensors
    over theirs, where tests are too short to tell them (see `offsets`); where tests differ,
    what the difference of the controls adds to it, if a table rocks, the change of stiffness in
    the middle of a test, and that from its beginning to its end, of all springs alike.
    """
    n_tests = len(data.tests)
    alike = data.sways.spread.tolist()
    alike += [STIFFNESS_SPREAD, STIFFNESS_SPREAD] if data.differing else []
    rows = np.repeat(np.array(alike, float)[:, None], n_tests, axis=1)
    constants = data.constant_spreads[np.newaxis] if data.has_constants else rows[:0]
    return np.concatenate([constants, data.offsets.spread, rows])


def offsets_in(data: DataSet, of_tests: FloatArray) -> FloatArray:
    """Return the offsets of sensors, (n_offsets, n_tests) array [-]."""
    first = int(data.has_constants)
    return of_tests[first : first + len(data.offsets.sensors)]


def as_free(data: DataSet, of_tests: FloatArray) -> FloatArray:
    """Return the numbers of tests that are free in a data set, from those of another one.

    What only the other has is left out, and what it lacks is 0.

    Parameters
    ----------
    data : DataSet
        The tests.
    of_tests : (n, n_tests) array
        Numbers of the same tests, of springs that drift or do not.
    """
    free = np.zeros_like(spreads_of(data))
    for own, other in zip(free, of_tests, strict=False):
        own[:] = other
    return free


def shares_of(data: DataSet, of_tests: FloatArray) -> FloatArray:
    """Return the input by differences of the controls, (n, n_tests) array [-]."""
    first = int(data.has_constants) + len(data.offsets.sensors)
    return of_tests[first : first + data.sways.spread.size]


def weights_of(data: DataSet, of_tests: FloatArray) -> FloatArray:
    """Return the weights of the controls in what drives the model, (n,) array [-].

    Means over all tests; one weight where controls are taken as one.
    """
    return data.sways.weights(shares_of(data, of_tests).mean(axis=1))


def drift_of(data: DataSet, of_tests: FloatArray) -> FloatArray:
    """Return how springs drift: their change in each test and while it runs, (2, n_tests) [-].

    Without a row where they do not.
    """
    return of_tests[-2:] if data.differing else np.zeros((0, len(data.tests)))


def inputs_with(data: DataSet, of_tests: FloatArray) -> tuple[Input, ...]:
    """Return the excitation of each test, with its constant and differences of the controls."""
    constants = of_tests[: int(data.has_constants)]
    own = np.concatenate([constants, shares_of(data, of_tests)])
    if not np.any(own):
        return data.inputs
    key = own.tobytes()
    found = data.driven.get(key)
    if found is None:
        for old in list(data.driven)[: 1 - KEPT]:
            data.driven.pop(old, None)
        found = data.driven[key] = _driven(data, of_tests)
    return found


def _driven(data: DataSet, of_tests: FloatArray) -> tuple[Input, ...]:
    shares = shares_of(data, of_tests)
    inputs = list(data.inputs)
    for i, (given, own) in enumerate(zip(data.inputs, of_tests.T, strict=True)):
        if data.has_constants and own[0] != 0.0:
            inputs[i] = with_constant(given, data.input_sizes[i] * own[0])
        if np.any(shares[:, i]):
            swayed = np.tensordot(shares[:, i], data.sway_pieces[i], 1)
            inputs[i] = replace(inputs[i], pieces=inputs[i].pieces + swayed)
    return tuple(inputs)


def models_with(data: DataSet, model: Model, of_tests: FloatArray) -> tuple[Model, ...]:
    """Return the model in each test; one object for those that do not differ.

    Raises
    ------
    ModelError
        If the model cannot be assembled.
    """
    drift, models = drift_of(data, of_tests), models_of(model, data.tests)
    if not np.any(drift):
        return models
    return tuple(
        _drifted(under, test.start / test.sample_rate, test.stop / test.sample_rate, *own)
        for under, test, own in zip(models, data.tests, drift.T, strict=True)
    )


def _drifted(model: Model, start: float, stop: float, level: float, change: float) -> Model:
    """Return a model whose springs are stiffer by a level, and by a change as time goes on."""
    more = []
    for element in resolved(model):
        stiffness = sum(row.values[0] for row in element.effect.rows() if row.law is Law.LINEAR)
        if stiffness != 0.0:
            rate, middle = change / (stop - start), 0.5 * (start + stop)
            drift = StiffnessDrift(np.sign(stiffness) * rate, middle, abs(stiffness))
            more.append(Element(Spring(level * stiffness), element.between))
            more.append(Element(drift, element.between))
    return replace(model, elements=(*model.elements, *more))
