"""The command line: the only room that prints."""

import errno
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

# before numpy is imported: our own threads and processes fill the cores, and those of the
# matrix library would only wait for each other
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from shakerproc import __version__, files
from shakerproc.cli import output
from shakerproc.cli.commands import COMMANDS, FORMER, GroupedCommand, GroupedCommands
from shakerproc.errors import LockedError, ShakerprocError
from shakerproc.late import seek_garbage_seldom

INTERRUPTED = 130
"""Exit status after Ctrl-C."""

EPILOG = (
    "Exit status: 0 done, 1 unusable input or some runs failed, 2 wrong usage, "
    "75 the folder is locked by another shakerproc, 130 interrupted. Tables fit the terminal; "
    "in a pipe or a file they are as wide as they need, or as COLUMNS says."
)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"shakerproc {__version__}")
        output.finish(0)


def _about(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version."
        ),
    ] = False,
) -> None:
    """From shaker recordings to the physical effect that the model left out."""


def build_app(names: Iterable[str] = (*COMMANDS, *FORMER)) -> typer.Typer:
    """Return the command-line application with these commands registered, by default all."""
    app = typer.Typer(
        cls=GroupedCommands,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # else "[Hz]" vanishes from the help
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
        epilog=EPILOG,
    )
    app.callback()(_about)
    for name in names:
        command = COMMANDS[name]
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
        else:
            app.command(name, cls=GroupedCommand, hidden=name in FORMER)(command)
    return app


def main() -> None:
    """Run the command line and exit with the status that docs/cli.md lists."""
    seek_garbage_seldom()
    _fill_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # an old Windows code page has no omega
    with files.noted() as written:
        _run(written)


def _run(written: "list[Path]") -> None:
    """Run the command line; `written` are the files that it has written so far."""
    try:
        known = sys.argv[1:2] if sys.argv[1:2] and sys.argv[1] in COMMANDS else None
        (build_app(known) if known else build_app())()
    except SystemExit as left:
        if left.code == INTERRUPTED:  # typer says nothing of it
            output.message(_stopped(left, written))
        raise
    except LockedError as error:
        _fail(f"{error}", 75)
    except ShakerprocError as error:
        _fail(f"{error}", 1)
    except OSError as error:
        full = error.errno in {errno.ENOSPC, errno.EDQUOT}
        hint = "; free some and call again, what is finished stands" if full else ""
        _fail(f"{error.filename or 'the system'}: {error.strerror or error}{hint}", 1)
    except MemoryError:
        _fail("not enough memory; process fewer channels, or set --memory-limit", 1)
    except KeyboardInterrupt as stopped:
        output.message(_stopped(stopped, written))
        sys.exit(INTERRUPTED)


def _stopped(error: BaseException | None, written: "list[Path]") -> str:
    """Return the message of an interrupted program: the finished part of its work."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    remaining = [path for path in written if path.exists()]
    kept = f"{remaining[0]} and all that was written before is whole" if remaining else ""
    reason = str(error) if error is not None else ""
    return f"stopped by the user; {reason or kept or 'nothing was written'}"


def _fill_closed_streams() -> None:
    """Replace a stream that the caller closed by one that discards its text.

    Its number would go to the next file that is opened, which others would then print into.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def _fail(text: str, status: int) -> None:
    one_line = " ".join(text.splitlines())
    output.message(f"error: {one_line}")
    sys.exit(status)
