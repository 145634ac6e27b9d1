"""Files as they leave the program: whole or not at all, and inert whatever their text says."""

import csv
import dataclasses
import errno
import io
import json
import math
import os
import secrets
import shutil
import stat
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any, Final

from shakerproc.errors import OutputError

TEMPORARY_PREFIX: Final = ".shakerproc-"
"""How the name of a file begins while it is being written."""

_REPLACE_TRIES: Final = 25
_REPLACE_PAUSE: Final = 0.1  # [s]; 2.5 s in all, as long as a virus scanner holds a handle
_HANDLES: Final = ("/dev/fd/", "/dev/std", "/proc/")
_FORMULA_STARTS: Final = ("=", "+", "-", "@", "\t", "\r")


_NOTED: Final[ContextVar[list[Path] | None]] = ContextVar("noted", default=None)


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


@contextmanager
def noted() -> Iterator[list[Path]]:
    """Yield a list that every file is added to which is written within the block."""
    written: list[Path] = []
    token = _NOTED.set(written)
    try:
        yield written
    finally:
        _NOTED.reset(token)


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` that takes its name once the block has succeeded.

    The file is flushed to the disk before it is renamed, so that after a crash, a full disk
    or ``kill -9`` either the old file or the whole new one stands under the name.

    Raises
    ------
    OSError
        If it cannot be written, with the name that it should have had.
    """
    if is_special(path):
        raise OSError(errno.EINVAL, "is no regular file, and cannot become one", str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{TEMPORARY_PREFIX}{secrets.token_hex(6)}{path.suffix}")
    try:
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        _replace(temporary, path)
        written = _NOTED.get()
        if written is not None:
            written.append(path)
    except OSError as error:  # such as a full disk, which does not say of which file
        if error.errno is None or error.filename not in {None, str(temporary)}:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder in another one, which goes with the block.

    What is written there moves to its place with `move_into` once all of it is there, so that
    results of one run stand beside each other, or none of them.
    """
    temporary = folder / f"{TEMPORARY_PREFIX}{secrets.token_hex(6)}"
    temporary.mkdir(parents=True)
    try:
        yield temporary
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        with suppress(OSError):  # others are in it
            folder.rmdir()


def move_into(folder: Path, temporary: Path) -> list[Path]:
    """Move every file of a temporary folder to its place in another one; return the files."""
    moved = []
    for path in sorted(p for p in temporary.rglob("*") if p.is_file()):
        moved.append(folder / path.relative_to(temporary))
        moved[-1].parent.mkdir(parents=True, exist_ok=True)
        _replace(path, moved[-1])
    return moved


def _replace(source: Path, target: Path) -> None:
    """Rename, trying again for a bounded time while another program holds the target open."""
    for _ in range(_REPLACE_TRIES - 1):
        try:
            source.replace(target)
        except PermissionError:
            time.sleep(_REPLACE_PAUSE)
        else:
            return
    source.replace(target)


def is_special(path: Path) -> bool:
    """Return whether a path is written into and never replaced: a device, a pipe, a handle.

    A name of a handle, such as ``/dev/stdout``, is one even where it leads to a regular file,
    which somebody else has open. Other files below ``/dev``, such as those in ``/dev/shm``, are
    files like any other, and so is what a folder ``dev`` of a drive of Windows holds.
    """
    if os.path.abspath(path).startswith(_HANDLES):  # noqa: PTH100 links are left as they are
        return True
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except OSError:
        return False


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file completely or not at all; a pipe or a device directly.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    if is_special(path):
        try:
            with path.open("ab") as file:
                file.write(content)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(path)) from error
        return
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


def write_text(path: Path, content: str) -> None:
    """Write a UTF-8 file with plain line ends, whole or not at all."""
    write_bytes(path, content.encode("utf-8", errors="backslashreplace"))


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files of killed writers below a folder."""
    for leftover in sorted(folder.rglob(f"{TEMPORARY_PREFIX}*")):
        if leftover.is_dir() and not leftover.is_symlink():
            shutil.rmtree(leftover, ignore_errors=True)
        else:
            leftover.unlink(missing_ok=True)


def json_text(document: object) -> str:
    """Return a document as strict JSON: numbers that are not finite become null.

    Keys stand on lines of their own, lists of numbers on one.
    """
    return _laid_out(_plain(document), "\n") + "\n"


def _laid_out(value: Any, end: str) -> str:
    """Return plain data as JSON; `end` is the line end with the indentation of the value."""
    inner = end + " "
    if isinstance(value, dict) and value:
        lines = [f"{_scalar(key)}: {_laid_out(item, inner)}" for key, item in value.items()]
        return "{" + inner + f",{inner}".join(lines) + end + "}"
    if isinstance(value, list) and any(isinstance(item, dict | list | str) for item in value):
        return "[" + inner + f",{inner}".join(_laid_out(i, inner) for i in value) + end + "]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def write_json(path: Path, document: object) -> None:
    """Write a document as strict JSON, whole or not at all."""
    write_text(path, json_text(document))


def _plain(value: Any) -> Any:  # noqa: PLR0911 - the kinds of JSON, one line each
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, date):
        return value.isoformat()
    if hasattr(value, "tolist"):  # numpy arrays and scalars, without importing numpy
        return _plain(value.tolist())
    if isinstance(value, complex):
        return {"real": _plain(value.real), "imag": _plain(value.imag)}
    if isinstance(value, Sequence | set | frozenset):
        items = [_plain(item) for item in value]  # a set in one order, whatever the process
        return items if isinstance(value, Sequence) else sorted(items, key=str)
    if isinstance(value, Path):
        return value.as_posix()
    raise TypeError(f"no JSON for {type(value).__name__}")


def csv_cell(value: object) -> str:
    """Return one cell of a CSV: numbers exactly, text so that no spreadsheet runs it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | Path):
        text = printable(str(value))
        return f"'{text}" if text.startswith(_FORMULA_STARTS) else text
    number = value.item() if hasattr(value, "item") else value
    if isinstance(number, float):
        return "" if math.isnan(number) else repr(number)
    return str(number) if isinstance(number, int) else csv_cell(str(number))


def csv_text(columns: Mapping[str, Any]) -> str:
    """Return columns of equal length as CSV, header first.

    Raises
    ------
    ValueError
        If the columns differ in length.
    """
    lengths = {len(values) for values in columns.values()}
    if len(lengths) > 1:
        raise ValueError(f"columns differ in length: {sorted(lengths)}")
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow([csv_cell(name) for name in columns])
    writer.writerows(zip(*map(_cells, columns.values()), strict=True))
    return buffer.getvalue()


def _cells(column: Any) -> list[str]:
    """Return a column as cells; of an array of numbers sooner than one by one."""
    values = column.tolist() if hasattr(column, "tolist") else column
    if getattr(getattr(column, "dtype", None), "kind", "") == "f":
        return ["" if value != value else repr(value) for value in values]  # noqa: PLR0124
    return [csv_cell(value) for value in values]


def write_csv(path: Path, columns: Mapping[str, Any]) -> None:
    """Write columns of equal length as CSV, whole or not at all."""
    write_text(path, csv_text(columns))


def printable(text: str, *, lines: bool = False) -> str:
    r"""Return text without control, bidirectional or other invisible characters.

    What a terminal would obey becomes a visible ``\x1b``; line ends stay where `lines` is set.
    """
    kept = " \xa0\n" if lines else " \xa0"
    return "".join(
        c if c.isprintable() or c in kept else c.encode("unicode_escape").decode() for c in text
    )


def now() -> datetime:
    """Return the time, or SOURCE_DATE_EPOCH where it is set, so that outputs can be equal."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    return datetime.fromtimestamp(int(epoch), UTC) if epoch.isdigit() else datetime.now(UTC)
