"""Errors of the models of a diagnosis by `compare`, with which a verdict is given."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import final

from shakerproc.comparison import Comparison, compare_tests, scored_alike
from shakerproc.comparison.measured import Measured
from shakerproc.diagnosis.result import Errors, Pair
from shakerproc.errors import SimulationError
from shakerproc.models import Model


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
            Pair(a, b) for a, b in ((was.fitted, now.fitted), (was.held_out, now.held_out))
            if a is not None and b is not None
        ]  # fmt: skip
        floor = now.held_out_noise
        if len(pairs) < 2 or floor is None:
            return own
        horizon = {test.measured.name: test.prediction.horizon_s for test in now.tests}
        return Errors(pairs[0], pairs[1], floor, horizon, alone, own)
