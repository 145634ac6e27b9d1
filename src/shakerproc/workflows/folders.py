"""Folders for results, looked at before the long work."""

import os
from pathlib import Path

from shakerproc.errors import OutputError


def checked_folder(folder: Path | None) -> Path | None:
    """Return a folder for results, looked at before the long work; it need not be there yet.

    Raises
    ------
    OutputError
        If it cannot be made, or nothing can be written there.
    """
    if folder is None:
        return None
    there = next(p for p in (folder.absolute(), *folder.absolute().parents) if p.exists())
    if not there.is_dir():
        raise OutputError(f"{folder}: {there} is no folder. Choose another folder for results.")
    if not os.access(there, os.W_OK | os.X_OK):
        raise OutputError(f"{folder}: {there} may not be written. Choose another folder.")
    return folder


def check_result_folder(folder: Path, command: str) -> None:
    """Pass a folder that a command may write its results into, before the long work.

    Raises
    ------
    OutputError
        If nothing can be written there.
    ShakerprocError
        If it holds the results of another command.
    """
    # commands without results need it not
    from shakerproc.campaign.result_folder import check_owner

    checked_folder(folder)
    check_owner(folder, command)
