"""The model with what a diagnosis found: to be run free against the same tests."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import final

from shakerproc.comparison import Comparison, compare_tests, scored_alike
from shakerproc.comparison.measured import Measured
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.hypotheses.own_numbers import (
    OwnNumber,
    element_names,
    mass_name,
    modal_numbers,
    own_names,
    sharing,
    with_values,
)
from shakerproc.diagnosis.result import BeforeAfter, Diagnosis, Errors, Finding
from shakerproc.errors import SimulationError
from shakerproc.model_files.writing import within
from shakerproc.models import EFFECTS, Element, Model
from shakerproc.models.effects.base import AbstractEffect


def updated_model(model: Model, diagnosis: Diagnosis) -> Model | None:
    """Return a model with the effects that were found and its own numbers as fitted with them.

    Where no effect of the library will do, the missing force stands in as a table. None where
    the diagnosis names no model that would do: where the tests cannot tell, or there is no
    table.
    """
    if diagnosis.verdict == "outside library" and diagnosis.outside is not None:
        return model_with(model, [diagnosis.outside.element()], diagnosis.linear)
    if diagnosis.verdict in {"outside library", "cannot tell"}:
        return None
    return model_with(model, elements_of(diagnosis.effects), diagnosis.linear)


def elements_of(effects: Sequence[Finding]) -> list[Element]:
    """Return effects that were found as elements; faults of sensors are left out."""
    return [
        Element(
            effect_of(one.kind, one.parameters), (one.between[0], one.between[1]), one.scaled_by
        )
        for one in effects
        if one.kind in EFFECTS
    ]


def model_with(model: Model, added: Sequence[Element], linear: Mapping[str, Estimate]) -> Model:
    """Return a model with elements and its own numbers as fitted, as `add` writes them.

    Neither alone need be a model: a spring that pushes away stands beside a law that holds.

    Parameters
    ----------
    model : Model
        The model of the file.
    added : sequence of Element
        What was found.
    linear : mapping of str to Estimate
        The model's own numbers, by their names (see `naming`).
    """
    own = {name: replace(one, value=shortened(one)) for name, one in linear.items()}
    values = {
        OwnNumber(i, name): value for (i, name), value in fitted_values(model, own).items()
    }
    values |= {
        number: _number(own[name])
        for mass in model.masses
        for name, number in [(mass_name(mass), OwnNumber(None, mass))]
        if name in own
    }
    values |= {
        number: _number(own[name])
        for number in modal_numbers(model)
        for name in own_names(model, (number,))
        if name in own
    }
    return with_values(model, tuple(values), tuple(values.values()), added)


def fitted_values(
    model: Model, numbers: Mapping[str, Estimate]
) -> dict[tuple[int, str], float]:
    """Return the fitted numbers of a model's elements by their index and parameter [SI].

    Springs that share a joint keep their numbers where only their sum is known.
    """
    names = element_names(model.elements)
    turned = element_names([
        replace(element, between=element.between[::-1]) for element in model.elements
    ])
    known = {key: numbers.get(names[key]) or numbers.get(turned[key]) for key in names}
    return {
        (i, name): _number(estimate)
        for (i, name), estimate in known.items()
        if estimate is not None
        and getattr(model.elements[i].effect, name) is not None
        and all(known[j, name] is not None for j in sharing(model, i, name))
    }


def _number(estimate: Estimate) -> float:
    """Return the value of an estimate that is no word."""
    return float(estimate.value)


def effect_of(kind: str, numbers: Mapping[str, Estimate]) -> AbstractEffect:
    """Return the effect with these numbers, in as many digits as their intervals bear out."""
    return EFFECTS[kind].of_numbers({name: shortened(one) for name, one in numbers.items()})


def shortened(estimate: Estimate) -> float | str:
    """Return a fitted number with as many digits as its interval bears out."""
    value = estimate.value
    if isinstance(value, str):
        return value
    return within(float(value), estimate.unit, *estimate.bounds_by_tests)


@final
class Comparisons:
    """Models run free against the same tests, each once however often it is asked for.

    Parameters
    ----------
    tests : sequence of Measured
        The tests as they were read.
    tell : callable
        Called with what is being done.
    """

    def __init__(self, tests: Sequence[Measured], tell: Callable[[str], None]) -> None:
        self.tests, self._tell = tests, tell
        self._made: list[tuple[Model, Comparison]] = []
        self._pairs: list[tuple[tuple[Model, Model], tuple[Comparison, ...]]] = []

    def of(self, model: Model) -> Comparison:
        """Return the comparison of a model, with the sensors of the tests, with the tests.

        Raises
        ------
        SimulationError
            If the motion runs away.
        """
        model = self._seen(model)
        for known, found in self._made:
            if known == model:
                return found
        found = compare_tests(model, self.tests, tell=self._tell)
        self._made.append((model, found))
        return found

    def alike(self, before: Model, after: Model) -> tuple[Comparison, ...]:
        """Return the comparisons of two models, scored in the same windows (`scored_alike`).

        Raises
        ------
        SimulationError
            If the motion of one runs away.
        """
        models = self._seen(before), self._seen(after)
        for known, pair in self._pairs:
            if known == models:
                return pair
        pair = scored_alike(*map(self.of, models), tell=self._tell)
        self._pairs.append((models, pair))
        return pair

    def _seen(self, model: Model) -> Model:
        """Return a model with the sensors of the tests alone."""
        sensors = {name: model.sensors[name] for name in self.tests[0].sensors}
        return replace(model, sensors=sensors)

    def errors(self, before: Model, after: Model, without: Model, own: Errors) -> Errors:
        """Return errors as `compare` tells them of the models, with those of candidates.

        Parameters
        ----------
        before, after, without : Model
            The model of the file, what a diagnosis leads to, and that without effects.
        own : Errors
            As candidates were compared; returned where nothing drives the tests, a motion
            runs away or nothing is held out.
        """
        if before.excitation.role is None:
            return own
        alone = None
        try:
            was, now = self.alike(before, after)
            if without not in (before, after):
                bare = compare_tests(
                    self._seen(without), self.tests, windows=now.windows, tell=self._tell
                )
                alone = bare.held_out
        except SimulationError:
            return own
        pairs = [
            BeforeAfter(a, b)
            for a, b in ((was.fitted, now.fitted), (was.held_out, now.held_out))
            if a is not None and b is not None
        ]  # fmt: skip
        floor = now.held_out_noise
        if len(pairs) < 2 or floor is None:
            return own
        horizon = {test.measured.name: test.prediction.horizon_s for test in now.tests}
        return Errors(pairs[0], pairs[1], floor, horizon, alone, own)
