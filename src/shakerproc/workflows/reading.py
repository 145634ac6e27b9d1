"""Test logs and models of a caller: read from files, handed over, or made in Python."""

from dataclasses import dataclass
from typing import Any

from shakerproc.errors import ArgumentError
from shakerproc.model_files import ModelFile, read_model_file
from shakerproc.models import Model
from shakerproc.testlog import TestLog, read_testlog
from shakerproc.workflows.arguments import AnyPath, file_of, told


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


def read_model(path: AnyPath) -> ModelFile:
    """Return the model that a YAML file describes.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    ModelFile
        The model (``.model``) and the file, whose comments a new model keeps.

    Raises
    ------
    ArgumentError
        If `path` is no path of a file.
    DocumentError
        If the file is not strict YAML, or something in it is unknown, missing, without unit or
        not physical; with line and column.
    """
    return read_model_file(file_of("path", path, "a model"))


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


def model_of(given: Any, name: str = "model") -> GivenModel:
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
        name, f"expected a model, as read_model(path) returns it, got {told(given)}"
    )
