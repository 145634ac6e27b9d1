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

if TYPE_CHECKING:
    from rich.console import Console

_BETWEEN: Final = 3
"""Characters that a drawn column takes besides its text."""

_BARS: Final[list["Console"]] = []
"""Where a bar is being drawn: what is said meanwhile must not run into it."""

JsonOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--json", metavar="FILE", help="Write the result as JSON to FILE, or to stdout with -."
    ),
]
OutOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="FOLDER", file_okay=False, help="Folder for tables and figures."
    ),
]


def write_json(document: object, target: str | Path | None) -> None:
    """Write a document to a file, to stdout where the target is "-", or nowhere."""
    if target is None:
        return
    if str(target) == "-":
        typer.echo(files.json_text(document), nl=False)
    else:
        files.write_json(Path(target), document)


def out_folder(folder: Path | None, default: str) -> Path:
    """Return the folder for results, made if need be."""
    chosen = Path(default) if folder is None else folder
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
