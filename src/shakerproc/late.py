"""What is named where it is listed, and loaded when it is first used."""

from importlib import import_module
from typing import Any


def loaded(place: str) -> Any:
    """Return what a place such as ``shakerproc.recordings.csv:read_csv`` holds."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
