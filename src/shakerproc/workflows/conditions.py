"""A model under the conditions of the tests of a log, such as the voltage of a damper."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias, final

from shakerproc.data import ChannelUse
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import Conditions, read_model
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.runs.opening import open_path
from shakerproc.testlog import Expectation, Test

Groups: TypeAlias = Sequence[tuple[Model, Sequence[int | str]]]
"""Models, and the ids of the tests that each is of."""


def models_of_tests(
    path: Path, tests: Iterable[Test], tell: Callable[[str], None] | None = None
) -> Mapping[int | str, Model]:
    """Return the model of a file under the conditions of each test, by the id of the test.

    Tests under the same conditions have the same model, which is read once where the log
    states them.

    Parameters
    ----------
    path : Path
        The model file.
    tests : iterable of Test
        The tests.
    tell : callable, optional
        Told of conditions that recordings hold; without it they count as not known.

    Raises
    ------
    DocumentError
        If the file is no model, or a test lacks a condition that scales one of its effects.
    ShakerprocError
        If a recording with a condition cannot be used.
    """
    stated: dict[frozenset[tuple[str, str]], Model] = {}
    found: dict[int | str, Model] = {}
    for test in tests:
        under = frozenset(test.conditions.items())
        if tell is not None and test.measured_conditions:
            read = read_model(path, Conditions(_Known(test, tell), f"test {test.id}"))
        elif under in stated:
            read = stated[under]
        else:
            read = read_model(path, Conditions(test.conditions, f"test {test.id}"))
            stated[under] = read
        found[test.id] = next((one for one in found.values() if one == read), read)
    return found


@final
class _Known(Mapping[str, str]):
    """Conditions of a test: as the log states them, else means of channels, read when asked."""

    def __init__(self, test: Test, tell: Callable[[str], None]) -> None:
        self._test, self._tell = test, tell
        self._uses = {use.name or str(use.key): use for use in test.measured_conditions}
        self._read: dict[str, str] = {}

    def __iter__(self) -> Iterator[str]:
        return iter({**self._test.conditions, **self._uses})

    def __len__(self) -> int:
        return len({**self._test.conditions, **self._uses})

    def __getitem__(self, name: str) -> str:
        if name in self._test.conditions:
            return self._test.conditions[name]
        if name not in self._read:
            self._read[name] = self._mean(name, self._uses[name])
        return self._read[name]

    def _mean(self, name: str, use: ChannelUse) -> str:
        """Return the mean of a channel over the recording, and tell how it varies."""
        test = replace(self._test, channels=(use,), beside=(), expect=Expectation())
        with open_path(test.require_recording(), test) as recording:
            samples, unit = recording.samples()[0], recording.channels[0].unit
        mean, spread = float(samples.mean()), float(samples.std())
        self._tell(
            f"test {test.id}: {name} {numeral(mean)} {unit}, varying by {numeral(spread, 2)} "
            f"{unit} rms; the mean scales the model"
        )
        return f"{mean:.9g} {unit}"


def groups_of(models: Mapping[int | str, Model]) -> Groups:
    """Return each model once, in the order of the tests, with the ids of its tests."""
    found: dict[int, tuple[Model, list[int | str]]] = {}
    for one, model in models.items():
        found.setdefault(id(model), (model, []))[1].append(one)
    return tuple(found.values())


def alone(models: Mapping[int | str, Model], wanted: str) -> Model:
    """Return the one model of all tests.

    Parameters
    ----------
    models : mapping of int or str to Model
        By the ids of tests.
    wanted : str
        What takes no more than one, for the message.

    Raises
    ------
    DiagnosisError
        If the tests are under several conditions.
    """
    groups = groups_of(models)
    if len(groups) > 1:
        told = "; ".join("test " + ", ".join(map(str, ids)) for _, ids in groups)
        raise DiagnosisError(
            f"{groups[0][0].title}: conditions scale the model, and {wanted} takes tests under "
            f"one. There are {len(groups)}: {told}. Set the others discarded in a copy of the "
            "log."
        )
    return groups[0][0]
