"""A model under the conditions of the tests of a log, such as the voltage of a damper."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from shakerproc.errors import DiagnosisError
from shakerproc.model_files import Conditions, read_model
from shakerproc.models import Model
from shakerproc.testlog import Test

Groups: TypeAlias = Sequence[tuple[Model, Sequence[int | str]]]
"""Models, and the ids of the tests that each is of."""


def models_of_tests(path: Path, tests: Iterable[Test]) -> Mapping[int | str, Model]:
    """Return the model of a file under the conditions of each test, by the id of the test.

    Tests under the same conditions have the same model.

    Raises
    ------
    DocumentError
        If the file is no model, or a test lacks a condition that scales one of its effects.
    """
    known: dict[frozenset[tuple[str, str]], Model] = {}
    found: dict[int | str, Model] = {}
    for test in tests:
        said = frozenset(test.conditions.items())
        if said not in known:
            read = read_model(path, Conditions(test.conditions, f"test {test.id}"))
            known[said] = next((one for one in known.values() if one == read), read)
        found[test.id] = known[said]
    return found


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
