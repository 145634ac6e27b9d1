"""Reciprocity: a linear structure answers alike where force and motion change places."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.analysis import Reciprocal, TestModes
from shakerproc.runs.roles import Place, sense_of

COHERENT: Final = 0.9
"""Coherence below which a line takes no part [-]: noise and leakage are not reciprocal."""

FEWEST: Final = 8
"""Lines that two functions are compared with each other by, at least [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Function:
    """A response function and the places of its two ends."""

    name: str
    units: tuple[str, str]
    frequency: FloatArray
    values: ComplexArray
    coherence: FloatArray
    response: Place
    force: Place


def reciprocals_of(tests: Sequence[TestModes]) -> tuple[Reciprocal, ...]:
    """Return every pair of functions between two places, there and back.

    Within one test of several forces, and between tests, as of a hammer that roves.
    """
    functions = [one for test in tests for one in _functions(test)]
    pairs = (
        _pair(first, second, sense)
        for i, first in enumerate(functions)
        for second in functions[i + 1 :]
        if (sense := _exchanged(first, second))
    )
    return tuple(pair for pair in pairs if pair.frequency.size >= FEWEST)


def _functions(test: TestModes) -> Iterator[_Function]:
    """Yield the functions of a test between two places that are known and differ."""
    if test.functions is None:
        return
    for k, force in enumerate(test.input_places):
        for i, response in enumerate(zip(test.positions, test.directions, strict=True)):
            if None in (force[0], response[0]) or sense_of(force, response):
                continue
            name = f"test {test.name}, {test.sensors[i].name} / {test.inputs[k]}"
            yield _Function(
                name, (test.sensors[i].unit, test.input_units[k]), test.functions.frequency,
                test.functions.measured[i, k], test.functions.coherence[i], response, force,
            )  # fmt: skip


def _exchanged(first: _Function, second: _Function) -> float:
    """Return 1 or -1 where two functions have exchanged ends, 0 where they have not."""
    if first.units != second.units:
        return 0.0
    return sense_of(first.response, second.force) * sense_of(second.response, first.force)


def _pair(first: _Function, second: _Function, sense: float) -> Reciprocal:
    inside = (first.frequency >= second.frequency[0]) & (
        first.frequency <= second.frequency[-1]
    )
    there = np.interp(first.frequency, second.frequency, second.coherence)
    inside &= (first.coherence > COHERENT) & (there > COHERENT)
    frequency, one = first.frequency[inside], first.values[inside]
    other = sense * np.interp(frequency, second.frequency, second.values)
    size, other_size = (float(np.sqrt(np.sum(np.abs(row) ** 2))) for row in (one, other))
    both = size * other_size
    return Reciprocal(
        (first.name, second.name),
        first.units,
        frequency,
        np.stack([one, other]),
        float(np.vdot(one, other).real) / both if both > 0.0 else 0.0,
        other_size / size if size > 0.0 else 0.0,
    )
