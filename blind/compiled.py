"""Compiled kernels on disk; none outlives a change of any file that it may call."""

from pathlib import Path

from numba import njit

kernel = njit(cache=True, error_model="numpy")
ROOMS = ("laws", "integration")
"""Where kernels live."""


def forget_stale() -> None:
    """Delete what was compiled before a source of the kernels last changed.

    Numba looks at the file of a function only, not at the files of what that calls.
    """
    folders = [Path(__file__).parent / room for room in ROOMS]
    newest = max(path.stat().st_mtime for place in folders for path in place.glob("*.py"))
    for index in (path for place in folders for path in place.glob("__pycache__/*.nbi")):
        if index.stat().st_mtime < newest:
            index.unlink(missing_ok=True)


forget_stale()
