"""What every command says: data to stdout, messages to stderr, JSON and tables alike."""

import os
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, NoReturn, TypeAlias

import typer

from shakerproc import files
from shakerproc.errors import OutputError

if TYPE_CHECKING:
    from rich.console import Console

_BETWEEN: Final = 3
"""Characters that a drawn column takes besides its text."""

_BARS: Final[list["Console"]] = []
"""Where a bar is being drawn: what is said meanwhile must not run into it."""

STDOUT: Final = "-"
"""The target of JSON that is stdout."""


def checked_json(target: str | None) -> str | None:
    """Return where JSON is to go, looked at before the long work.

    Raises
    ------
    OutputError
        If nothing can be written there.
    """
    if target is None:
        return None
    if target == STDOUT or _is_stdout(Path(target)):
        if stdout_is_closed():
            raise OutputError("--json -: stdout is closed. Name a file instead.")
        return STDOUT
    path = Path(target)
    if path.is_dir():
        raise OutputError(f"--json {target}: this is a folder. Name a file in it.")
    if not path.parent.is_dir():
        raise OutputError(
            f"--json {target}: there is no folder {path.parent}. Make it first, or name a file "
            "in one that is there."
        )
    if not os.access(path if files.is_special(path) else path.resolve().parent, os.W_OK):
        raise OutputError(f"--json {target}: may not be written. Name another file.")
    return target


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


def _is_stdout(path: Path) -> bool:
    """Return whether a path is another name of this program's stdout."""
    if stdout_is_closed() or not files.is_special(path):
        return False
    try:
        return os.path.samestat(path.stat(), os.fstat(1))
    except OSError:
        return False


def stdout_is_closed() -> bool:
    """Return whether whoever called the program gave it no stdout."""
    return sys.__stdout__ is None


JsonOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--json",
        metavar="FILE",
        help="Write the result as JSON to FILE, or to stdout with -.",
        callback=checked_json,
    ),
]
OutOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="FOLDER",
        file_okay=False,
        help="Folder for tables and figures.",
        callback=checked_folder,
    ),
]


def write_json(document: object, target: str | Path | None) -> None:
    """Write a document to a file, to stdout where the target is "-", or nowhere."""
    if target is None:
        return
    if str(target) == STDOUT:
        typer.echo(files.json_text(document), nl=False)
    else:
        path = Path(target)
        files.write_json(path if files.is_special(path) else path.resolve(), document)


def out_folder(folder: Path | None, default: str) -> Path:
    """Return the folder for results, made if need be."""
    chosen = Path(default) if folder is None else folder
    checked_folder(chosen)
    chosen.mkdir(parents=True, exist_ok=True)
    return chosen


def message(text: str) -> None:
    """Say something to the person, on stderr; above the bar of progress where there is one."""
    said = files.printable(text, lines=True)
    if _BARS:
        _BARS[-1].print(said, markup=False, highlight=False, soft_wrap=True)
    else:
        typer.echo(said, err=True)


def warning(text: str) -> None:
    """Say what may be wrong, on stderr."""
    message(f"warning: {text}")


def finish(status: int) -> NoReturn:
    """End the command.

    Raises
    ------
    typer.Exit
        Always, with the exit status.
    """
    raise typer.Exit(status)


def data(text: str, *, json_target: str | None = None) -> None:
    """Print a result on stdout, unless JSON has been asked for there."""
    if json_target != "-":
        typer.echo(files.printable(text, lines=True))


class Picture(str):
    """A cell of several lines that the program has drawn itself."""

    __slots__ = ()


def cell_text(value: object) -> str:
    """Return a cell for people: four digits, no control characters, nothing for nothing."""
    if value is None:
        return ""
    if isinstance(value, Picture):
        return value
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"  # noqa: PLR0124 - NaN without numpy
    return files.printable(str(value))


def print_table(
    columns: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    title: str = "",
    json_target: str | None = None,
    spare: Sequence[str] = (),
) -> None:
    """Print a table on stdout: drawn on a terminal, plain columns elsewhere.

    On a terminal that is too narrow, columns that can be spared are left out, in their order.
    """
    if json_target == "-":
        return
    cells = [[cell_text(value) for value in row] for row in rows]
    numeric = [
        all(isinstance(row[i], int | float) or row[i] is None for row in rows)
        for i in range(len(columns))
    ]
    if sys.stdout.isatty():
        kept = columns_that_fit(columns, cells, shutil.get_terminal_size().columns, spare)
        _print_rich(
            [columns[i] for i in kept],
            [[row[i] for i in kept] for row in cells],
            [numeric[i] for i in kept],
            title,
        )
    else:
        _print_plain(columns, cells, numeric, title)


def columns_that_fit(
    columns: Sequence[str], cells: Sequence[Sequence[str]], width: int, spare: Sequence[str]
) -> list[int]:
    """Return which columns to print in so many characters, empty and spare ones left out."""
    kept = list(range(len(columns)))
    widths = [max(_width(row[i]) for row in (columns, *cells)) + _BETWEEN for i in kept]
    empty = [name for i, name in enumerate(columns) if not any(row[i] for row in cells)]
    for name in (*empty, *spare):
        if sum(widths[i] for i in kept) <= width:
            break
        kept = [i for i in kept if columns[i] != name]
    return kept


def _width(cell: str) -> int:
    return max((len(line) for line in cell.splitlines()), default=0)


def _print_rich(
    columns: Sequence[str], cells: list[list[str]], numeric: list[bool], title: str
) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(file=sys.stdout, highlight=False)
    if title:  # one of the table's own would be folded to its width
        console.print(Text(title, style="italic"))
    table = Table(box=box.SIMPLE_HEAD)
    for name, is_number in zip(columns, numeric, strict=True):
        table.add_column(Text(name), justify="right" if is_number else "left")
    for row in cells:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def _print_plain(
    columns: Sequence[str], cells: list[list[str]], numeric: list[bool], title: str
) -> None:
    if title:
        typer.echo(title)
    everything = [list(columns), *cells]
    widths = [max(len(row[i]) for row in everything) for i in range(len(columns))]
    for row in everything:
        aligned = (
            cell.rjust(width) if is_number else cell.ljust(width)
            for cell, width, is_number in zip(row, widths, numeric, strict=True)
        )
        typer.echo("  ".join(aligned).rstrip())


@contextmanager
def progress(what: str, total: int) -> Iterator[Callable[[str], None]]:
    """Yield a function to call after each step; draws a bar on a terminal, else is quiet."""
    if not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
        yield lambda _text: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar, _drawn_on(bar.console):
        task = bar.add_task(what, total=total)

        def advance(text: str) -> None:
            shown = Text(files.printable(text)).plain
            bar.update(task, advance=1, description=f"{what} {shown}".strip())

        yield advance


@contextmanager
def _drawn_on(console: "Console") -> Iterator[None]:
    _BARS.append(console)
    try:
        yield
    finally:
        _BARS.remove(console)
