"""Objects named where they are listed, and loaded when they are first used."""

import gc
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final

LEFT_LYING: Final = 100_000
"""New objects before garbage is sought."""


def loaded(place: str) -> Any:
    """Return the object at a place such as ``shakerproc.recordings.csv:read_csv``."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def without(package: str, what: str, extra: str, instead: str) -> str:
    """Return the remedy where the package of a format is missing; empty where it is there.

    Parameters
    ----------
    package : str
        The module that reads it.
    what : str
        The format.
    extra : str
        The extra of shakerproc that brings the package.
    instead : str
        What else can be done.
    """
    if find_spec(package) is not None:
        return ""
    return f"{what} needs {package}: pip install 'shakerproc[{extra}]', or {instead}"


def without_parquet() -> str:
    """Return the remedy where Parquet cannot be read and written; empty where it can."""
    return without("pyarrow", "Parquet", "parquet", "use CSV")


def without_xlsx() -> str:
    """Return the remedy where XLSX cannot be read; empty where it can."""
    return without("openpyxl", "XLSX", "xlsx", "save it as CSV")


def seek_garbage_seldom() -> None:
    """Let objects lie for longer: imports make many and no garbage.

    To look through them again and again takes a tenth of a second of every start.
    """
    gc.set_threshold(LEFT_LYING)
