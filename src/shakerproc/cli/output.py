"""Output of every command: data to stdout, messages to stderr, JSON and tables alike."""

import os
import shlex
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, NoReturn, TypeAlias, final

import typer

from shakerproc import files
from shakerproc.cli import tables
from shakerproc.cli.commands import RESULTS
from shakerproc.errors import OutputError
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from rich.console import Console

    from shakerproc.data import Recording
    from shakerproc.testlog import TestLog

_BARS: Final[list["Console"]] = []
"""Where a bar is being drawn: what is said meanwhile must not run into it."""

TELL_EVERY: Final = 5.0
"""Seconds between two lines of progress where no bar is drawn [s]."""

GO_ON: Final = "what is done stands, call again to go on"
"""What is left of an interrupted batch, as its KeyboardInterrupt says it."""

STDOUT: Final = "-"
"""The target of JSON that is stdout."""

_STDOUT_HOLDS: Final = {"json": False}
"""Whether the document of this command goes to stdout, so that nothing else may."""


def checked_json(context: typer.Context, target: str | None) -> str | None:
    """Return where JSON is to go, looked at before the long work.

    Raises
    ------
    OutputError
        If nothing can be written there.
    """
    if target is None:
        return None
    if target == STDOUT or _is_stdout(Path(target)):
        _STDOUT_HOLDS["json"] = True
        context.call_on_close(_free_stdout)
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
    if path.is_file() and not _may_be_json(path):
        raise OutputError(
            f"--json {target}: this file is there, and it is no JSON that could be replaced, "
            "but a recording, a log or something else. Name another file."
        )
    return target


def _free_stdout() -> None:
    """Let stdout hold text again, after a command whose document went there."""
    _STDOUT_HOLDS["json"] = False


def _may_be_json(path: Path) -> bool:
    """Return whether a file is empty or begins as JSON does."""
    try:
        with path.open("rb") as file:
            beginning = file.read(256).lstrip()
    except OSError:
        return False
    return not beginning or beginning.startswith((b"{", b"["))


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
        rich_help_panel=RESULTS,
    ),
]
OutOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="FOLDER",
        file_okay=False,
        help="Folder for tables and figures.",
        callback=files.checked_folder,
        rich_help_panel=RESULTS,
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
    files.checked_folder(chosen)
    chosen.mkdir(parents=True, exist_ok=True)
    return chosen


@contextmanager
def results(folder: Path, command: str) -> Iterator[None]:
    """Write the results of a command in the block, in place of all those of an earlier run.

    Where the block is interrupted or fails, nothing of it stays.
    """
    from shakerproc.campaign.result_folder import check_result_folder, settle

    check_result_folder(folder, command)
    folder.mkdir(parents=True, exist_ok=True)
    with files.noted() as written:
        try:
            yield
        except BaseException:
            for path in written:
                path.unlink(missing_ok=True)
            raise
    settle(folder, written, command)


def command() -> str:
    """Return the command line, as one may type it again."""
    return shlex.join(["shakerproc", *sys.argv[1:]])


def next_step(text: str, *words: object) -> None:
    """Print the next step and its command on stderr; nothing where JSON goes to stdout."""
    if not _STDOUT_HOLDS["json"]:
        typed = shlex.join(["shakerproc", *map(str, words)]) if words else ""
        message(f"next: {': '.join(filter(None, (text, typed)))}")


def say_planned_tests(log: "TestLog") -> None:
    """Say which tests of a log are planned and take no part."""
    messages(log.left_out)


def print_if(wanted: bool, page: Path) -> None:
    """Print a report beside its page, if that is wanted."""
    if not wanted:
        page.with_suffix(".pdf").unlink(missing_ok=True)  # of an earlier page
        return
    from shakerproc.report.page.page import print_report

    message(f"PDF: {print_report(page, page.with_suffix('.pdf'))}")


def messages(texts: Iterable[str]) -> None:
    """Print texts to stderr, a line each."""
    for text in texts:
        message(text)


def message(text: str) -> None:
    """Say something to the person, on stderr; above the bar of progress where there is one."""
    said = files.printable(text, lines=True)
    if _BARS:
        _BARS[-1].print(said, markup=False, highlight=False, soft_wrap=True)
    else:
        typer.echo(said, err=True)


def warning(text: str) -> None:
    """Print a warning on stderr."""
    message(f"warning: {text}")


@final
class Once:
    """Messages that are given only once: before the long work, not again with its results."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def warning(self, text: str) -> None:
        """Print a warning on stderr."""
        if text not in self._said:
            self._said.add(text)
            warning(text)

    def message(self, text: str) -> None:
        """Say something to the user, on stderr."""
        if text not in self._said:
            self._said.add(text)
            message(text)


def finish(status: int) -> NoReturn:
    """End the command.

    Raises
    ------
    typer.Exit
        Always, with the exit status.
    """
    raise typer.Exit(status)


def data(text: str) -> None:
    """Print a result on stdout, unless JSON has been asked for there."""
    if not _STDOUT_HOLDS["json"]:
        typer.echo(files.printable(text, lines=True))


def cell_text(value: object) -> str:
    """Return a cell for people: four digits, no control characters, nothing for nothing."""
    if value is None:
        return ""
    if isinstance(value, tables.Picture):
        return value
    if isinstance(value, float):
        return "" if value != value else numeral(value, 4)  # noqa: PLR0124 - NaN without numpy
    return files.printable(str(value))


def print_table(
    columns: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    title: str = "",
    spare: Sequence[str] = (),
    elsewhere: str = "--json -",
) -> None:
    """Print a table on stdout, as wide as `table_width` allows.

    Parameters
    ----------
    columns : sequence of str
        Headers.
    rows : sequence of sequence
        Cells, of which numbers get four digits.
    title : str
        Line above it.
    spare : sequence of str
        Columns to leave out first where there is too little room.
    elsewhere : str
        Where all columns are, told where some are left out.
    """
    if _STDOUT_HOLDS["json"]:
        return
    cells = [[cell_text(value) for value in row] for row in rows]
    numeric = [
        all(isinstance(row[i], int | float) or row[i] is None for row in rows)
        for i in range(len(columns))
    ]
    layout = tables.fitted(columns, cells, numeric, table_width(), spare)
    if title:
        typer.echo(title)
    head = tables.lines_of(columns, layout, numeric, bottom=True)
    if sys.stdout.isatty():
        line = "─" if (sys.stdout.encoding or "").lower().startswith("utf") else "-"
        rule = line * (sum(layout.widths) + tables.BETWEEN * (len(layout.widths) - 1))
        bold = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
        head = [*(typer.style(text, bold=True) if bold else text for text in head), rule]
    for text in head:
        typer.echo(text)
    for row in cells:
        for text in tables.lines_of(row, layout, numeric):
            typer.echo(text)
    omission = layout.omission_text(elsewhere)
    if omission:
        typer.echo(omission)


def table_width() -> int | None:
    """Return how many characters a line of a table may take; None for as many as it needs.

    On a terminal its width; in a pipe or a file what COLUMNS says, and any number where it says
    nothing.
    """
    if sys.stdout.isatty():
        return shutil.get_terminal_size().columns
    said = os.environ.get("COLUMNS", "")
    return int(said) if said.isdecimal() and int(said) > 0 else None


@contextmanager
def progress(what: str, total: int) -> Iterator[Callable[[str], None]]:
    """Yield a function to call after each step; draws a bar on a terminal, else lines.

    A line comes where `TELL_EVERY` has passed since the last, so that a quick command has none.
    """
    if not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
        sentences = [time.monotonic()]

        def say(text: str) -> None:
            if time.monotonic() - sentences[0] >= TELL_EVERY:
                sentences[0] = time.monotonic()
                message(f"{what}: {text}")

        yield say
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


def writer_of(path: Path, *, modes: bool = False) -> "Callable[[Path, Recording], None]":
    """Return what writes a recording in the format of a new file.

    Parameters
    ----------
    path : Path
        The new file.
    modes : bool
        Whether the command writes modes, too, so that a refusal names their formats.

    Raises
    ------
    typer.BadParameter
        If nothing does.
    """
    from shakerproc.recordings import WRITERS

    write = WRITERS.get(path.suffix.lower())
    if write is None:
        formats = ", ".join(WRITERS)
        if modes:
            from shakerproc.exchange.modes import WRITERS as MODE_WRITERS
            from shakerproc.model_files.schema import YAML

            formats = (
                f"recordings as {formats} and modes as {', '.join((*YAML, *MODE_WRITERS))}"
            )
        raise typer.BadParameter(
            f"no format {path.suffix or path.name!r}; shakerproc writes {formats}",
            param_hint="OUT",
        )
    return write


def tell_written(path: Path, recording: "Recording") -> None:
    """Say on stderr which recording was written, and its notes."""
    for note in recording.notes:
        message(f"note: {note}")
    if recording.incomplete:
        warning(f"{(recording.path or path).name} is incomplete, and so is {path.name}")
    message(
        f"{path}: {len(recording.channels)} channels, {recording.n_samples} samples at "
        f"{recording.sample_rate:.9g} Hz"
    )


def tell_faults(recording: "Recording", role: str | None, start: float, stop: float) -> None:
    """Print the faults in channels of a role, from `start` to `stop` [s]."""
    from shakerproc.recordings import health, within

    driving = {"", *(c.name for c in recording.channels if c.role == role)}
    for flag in within(health(recording), start, stop):
        if flag.channel in driving:
            warning(flag.line)
