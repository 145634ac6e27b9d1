"""Arguments of a caller, checked: values, logs and models, machines."""

import os
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from numbers import Integral, Real
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from shakerproc.errors import ArgumentError
from shakerproc.executors import AbstractExecutor, ClusterExecutor, Limits, ProcessExecutor
from shakerproc.model_files import ModelFile, read_model_file
from shakerproc.models import Conditions, Model
from shakerproc.testlog import TestLog, read_testlog
from shakerproc.units import any_quantity

AnyPath: TypeAlias = str | PathLike[str]


def path_of(name: str, given: Any, what: str) -> Path:
    """Return the path of a file or folder.

    Raises
    ------
    ArgumentError
        If it is neither a text nor a path.
    """
    if not isinstance(given, (str, PathLike)) or not isinstance(fspath(given), str):
        raise ArgumentError(name, f"expected the path of {what}, got {argument_text(given)}")
    return Path(given)


def file_of(name: str, given: Any, what: str) -> Path:
    """Return the path of a file that is there.

    Raises
    ------
    ArgumentError
        If it is no path, or there is no such file.
    """
    path = path_of(name, given, what)
    if not path.exists():
        raise ArgumentError(name, f"no file {path}; give the path of {what}")
    if path.is_dir():
        raise ArgumentError(name, f"{path} is a folder; give the path of {what}")
    return path


def log_of(given: Any, name: str = "log") -> TestLog:
    """Return a test log.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, TestLog):
        return given
    raise ArgumentError(
        name, f"expected a test log, as read_log(path) returns it, got {argument_text(given)}"
    )


def text_of(name: str, given: Any, what: str = "a text") -> str:
    """Return a text.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, str):
        return given
    raise ArgumentError(name, f"expected {what}, got {argument_text(given)}")


def switch_of(name: str, given: Any) -> bool:
    """Return an argument that is either True or False.

    Raises
    ------
    ArgumentError
        If it is neither.
    """
    if isinstance(given, (bool, np.bool_)):
        return bool(given)
    raise ArgumentError(name, f"expected True or False, got {argument_text(given)}")


def whole_of(name: str, given: Any, least: int, most: int | None = None) -> int:
    """Return a whole number within limits.

    Raises
    ------
    ArgumentError
        If it is none, or outside.
    """
    whole = isinstance(given, Integral) and not isinstance(given, bool)
    if whole and least <= given and (most is None or given <= most):
        return int(given)
    span = f"from {least}" if most is None else f"from {least} to {most}"
    raise ArgumentError(name, f"expected a whole number {span}, got {argument_text(given)}")


def number_of(name: str, given: Any) -> float:
    """Return a finite number of at least 0.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    number = _real(name, given)
    if number >= 0.0 and isfinite(number):
        return number
    raise ArgumentError(name, f"must be a number of at least 0, not {number:g}")


def positive_of(name: str, given: Any) -> float:
    """Return a finite number above 0.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    number = _real(name, given)
    if number > 0.0 and isfinite(number):
        return number
    raise ArgumentError(name, f"must be a number above 0, not {number:g}")


def within_of(name: str, given: Any, least: float, most: float) -> float:
    """Return a number within limits, in their unit.

    Raises
    ------
    ArgumentError
        If it is none, or outside.
    """
    number = _real(name, given)
    if least <= number <= most:
        return number
    raise ArgumentError(name, f"must be from {least:g} to {most:g}, not {number:g}")


def _real(name: str, given: Any) -> float:
    if not isinstance(given, bool) and isinstance(given, Real):
        with suppress(OverflowError):
            return float(given)
    raise ArgumentError(name, f"expected a number, got {argument_text(given)}")


def list_of(name: str, given: Any, what: str) -> tuple[Any, ...]:
    """Return the items of a list; a text is none.

    Raises
    ------
    ArgumentError
        If it is no list.
    """
    if isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping)):
        return tuple(given)
    raise ArgumentError(name, f"expected a list of {what}, got {argument_text(given)}")


def choice_of(
    name: str, given: Any, known: Collection[str], what: str, *, usual: bool = True
) -> str:
    """Return one of the names that there are; the first for an empty text, if that is usual.

    Raises
    ------
    ArgumentError
        If it is none of them.
    """
    wanted = text_of(name, given, f"the name of {what}")
    if usual and not wanted and known:
        return next(iter(known))
    if wanted in known:
        return wanted
    none = what.removeprefix("an ").removeprefix("a ")
    there = ", ".join(known) or "none"
    raise ArgumentError(name, f"no {none} {given!r}; there are {there}")


def argument_text(given: object) -> str:
    """Return the given argument, for a message."""
    if isinstance(given, (str, bytes, int, float)) or given is None:
        text = repr(given)
        return text if len(text) <= 60 else f"{text[:57]}..."
    kind = type(given)
    return f"an object of the class {kind.__module__}.{kind.__qualname__}"


def read_log(path: AnyPath) -> TestLog:
    """Return the test log that a YAML file describes.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    TestLog
        Its tests in order (``log.tests``), those that were run (``log.active``), and one of
        them by its id (``log.find(3)``).

    Raises
    ------
    ArgumentError
        If `path` is no path of a file.
    DocumentError
        If the file is not strict YAML, or something in it is unknown, missing or without
        unit; with line and column.
    """
    return read_testlog(file_of("path", path, "a test log"))


def read_model(path: AnyPath, *, conditions: Mapping[str, str] | None = None) -> ModelFile:
    """Return the model that a YAML file describes.

    Parameters
    ----------
    path : path
        The file.
    conditions : mapping of str to str, optional
        Quantities that scale effects, with their units, such as ``{"voltage": "2 V"}``: the
        model is that under these, whatever tests say.

    Returns
    -------
    ModelFile
        The model (``.model``) and the file, whose comments a new model keeps.

    Raises
    ------
    ArgumentError
        If `path` is no path of a file, or a condition no quantity.
    DocumentError
        If the file is not strict YAML, or something in it is unknown, missing, without unit or
        not physical; with line and column.
    ModelError
        If a condition that scales an effect is missing, or of another unit.
    """
    model_file = read_model_file(file_of("path", path, "a model"))
    if conditions is None:
        return model_file
    under = _conditions(conditions)
    return replace(model_file, model=model_file.model.under(under), conditions=under)


def _conditions(given: Any) -> Conditions:
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        wanted = 'expected names with quantities, such as {"voltage": "2 V"}'
        raise ArgumentError("conditions", f"{wanted}, got {argument_text(given)}")
    for name, written in given.items():
        try:
            any_quantity(written)
        except ValueError as error:
            raise ArgumentError("conditions", f"{name}: {error}") from error
    return Conditions(given, "conditions")


@dataclass(frozen=True, slots=True, eq=False)
class GivenModel:
    """A model, and the file it is from, if it is from one.

    Attributes
    ----------
    model : Model
        The model.
    file : ModelFile, optional
        Where it stands, as it is.
    """

    model: Model
    file: ModelFile | None = None


def model_of(given: Any, name: str = "model") -> GivenModel:
    """Return a model: as read from a file, as a result holds it, or as made in Python.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, ModelFile):
        as_written = given if given.conditions is None else None
        return GivenModel(given.model, as_written)
    if isinstance(given, Model):
        return GivenModel(given)
    raise ArgumentError(
        name, f"expected a model, as read_model(path) returns it, got {argument_text(given)}"
    )


LONG: Final = 7 * 86400.0
"""How long a part of a study or a diagnosis may take on a cluster [s]."""

MUCH: Final = 1e12
"""What it may allocate there [byte]."""


@dataclass(frozen=True, slots=True)
class Machines:
    """Where the tests of a log are processed.

    Attributes
    ----------
    workers : int, optional
        Processes at a time; by default one for each processor. A cluster has its own number.
    time_limit : float
        Longest time for one test [s].
    memory_limit : float
        Most that one test may allocate [byte].
    scheduler : str, optional
        Address of a dask scheduler; this machine alone where there is none.
    recordings : str, optional
        Folder or URL of the recordings as the workers see it; by default the log's folder.
    """

    workers: int | None = None
    time_limit: float = 600.0
    memory_limit: float = 4e9
    scheduler: str | None = None
    recordings: str | None = None

    def executor(self, prepare: Callable[[], None] | None = None) -> AbstractExecutor:
        """Return the executor that runs the tests."""
        limits = Limits(self.time_limit, self.memory_limit)
        if self.scheduler is not None:
            quiet_cluster()
            return ClusterExecutor(self.scheduler, limits, prepare)
        return ProcessExecutor(self.workers or os.cpu_count() or 1, limits, prepare)

    def source(self, log: TestLog) -> str:
        """Return where the recordings are, as the workers see it."""
        return str(log.folder) if self.recordings is None else self.recordings


def quiet_cluster() -> None:
    """Keep dask's log of arriving and leaving workers from the terminal."""
    try:
        import dask
    except ImportError:
        return  # the executor will say so
    dask.config.set({"logging": {"distributed": "critical", "distributed.client": "critical"}})


def pairs(at: Iterable[str]) -> dict[str, str]:
    """Return the places of names, of ``NAME=PLACE``.

    Raises
    ------
    ArgumentError
        If one is no pair of names.
    """
    texts = {}
    for one in at:
        name, _, place = one.partition("=")
        if not name.strip() or not place.strip():
            raise ArgumentError("at", f"expected NAME=PLACE, got {one!r}")
        texts[name.strip()] = place.strip()
    return texts
