"""What is named where it is listed, and loaded when it is first used."""

import gc
from importlib import import_module
from typing import Any, Final

LEFT_LYING: Final = 100_000
"""New objects before garbage is sought."""


def loaded(place: str) -> Any:
    """Return what a place such as ``shakerproc.recordings.csv:read_csv`` holds."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def seek_garbage_seldom() -> None:
    """Let objects lie for longer: imports make many and no garbage.

    To look through them again and again takes a tenth of a second of every start.
    """
    gc.set_threshold(LEFT_LYING)
