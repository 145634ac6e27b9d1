"""What a caller handed over, checked: a wrong type is told what was expected."""

from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeAlias

from shakerproc.errors import ArgumentError
from shakerproc.model_files import ModelFile
from shakerproc.models import Model
from shakerproc.testlog import TestLog

AnyPath: TypeAlias = str | PathLike[str]


def path_of(name: str, given: Any, what: str) -> Path:
    """Return the path of a file or folder.

    Raises
    ------
    ArgumentError
        If it is neither a text nor a path.
    """
    if not isinstance(given, (str, PathLike)) or not isinstance(fspath(given), str):
        raise ArgumentError(name, f"expected the path of {what}, got {told(given)}")
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


def log_of(given: Any) -> TestLog:
    """Return a test log.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, TestLog):
        return given
    raise ArgumentError(
        "log", f"expected a test log, as read_log(path) returns it, got {told(given)}"
    )


@dataclass(frozen=True, slots=True, eq=False)
class GivenModel:
    """A model, and the file it is from, if it is from one.

    Attributes
    ----------
    model : Model
        The model.
    file : ModelFile, optional
        Where it stands.
    """

    model: Model
    file: ModelFile | None = None


def model_of(given: Any) -> GivenModel:
    """Return a model: as read from a file, as a result holds it, or as made in Python.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if isinstance(given, ModelFile):
        return GivenModel(given.model, given)
    if isinstance(given, Model):
        return GivenModel(given)
    raise ArgumentError(
        "model", f"expected a model, as read_model(path) returns it, got {told(given)}"
    )


def told(given: object) -> str:
    """Return what was given, for a message."""
    if isinstance(given, (str, bytes, int, float)) or given is None:
        text = repr(given)
        return text if len(text) <= 60 else f"{text[:57]}..."
    kind = type(given)
    return f"an object of the class {kind.__module__}.{kind.__qualname__}"
