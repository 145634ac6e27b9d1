"""Recordings that lie elsewhere: on a shared path, or behind a URL that fsspec knows."""

from pathlib import Path, PurePosixPath
from typing import Any

from shakerproc.errors import RecordingError


def is_url(source: str) -> bool:
    """Return whether a place is a URL and no folder."""
    return "://" in source


def fetch(source: str, relative: str, folder: Path) -> Path:
    """Return where a recording lies on this machine, brought there where it is behind a URL.

    Parameters
    ----------
    source : str
        Folder or URL of the recordings.
    relative : str
        Path of the recording below it, as the log has it.
    folder : Path
        Where to put it if it has to be fetched.

    Raises
    ------
    RecordingError
        If it is not there, or cannot be fetched.
    """
    if not is_url(source):
        return _on_path(Path(source), relative)
    path = folder.joinpath(*PurePosixPath(relative).parts)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        file_system, root = _opened(source)
        file_system.get_file(f"{root.rstrip('/')}/{relative}", str(path))
    except FileNotFoundError as error:
        raise RecordingError(
            f"{relative}: no such recording at {source}; put it there, or correct --recordings."
        ) from error
    except RecordingError:
        raise
    except Exception as error:
        cause = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise RecordingError(f"{relative}: cannot be fetched from {source}: {cause}") from error
    return path


def _on_path(folder: Path, relative: str) -> Path:
    path = folder / relative
    if not path.is_file():
        raise RecordingError(
            f"{relative}: this machine sees no {path}; put the recordings on a path that every "
            "worker sees, or say where they are with --recordings."
        )
    if not path.resolve().is_relative_to(folder.resolve()):
        raise RecordingError(
            f"{relative}: a link to outside {folder}; put the file itself there."
        )
    return path


def _opened(source: str) -> tuple[Any, str]:
    """Return the file system of a URL and the path on it.

    Raises
    ------
    RecordingError
        If fsspec, or what it needs for this kind of URL, is not installed.
    """
    kind = source.partition("://")[0]
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise RecordingError(
            f"{source}: needs fsspec, which is not installed; "
            'install it with: pip install "shakerproc[cluster]"'
        ) from error
    try:
        file_system, root = url_to_fs(source)
    except (ImportError, ValueError) as error:
        raise RecordingError(
            f"{source}: fsspec cannot open {kind}:// here: {' '.join(str(error).split())}"
        ) from error
    return file_system, str(root)
