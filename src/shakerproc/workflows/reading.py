"""Test logs and models, read for a notebook."""

from shakerproc.model_files import ModelFile, read_model_file
from shakerproc.testlog import TestLog, read_testlog
from shakerproc.workflows.arguments import AnyPath, file_of


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
