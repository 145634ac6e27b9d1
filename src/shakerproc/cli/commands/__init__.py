"""The commands, one in each file, their mapping, and help in which they stand in groups.

A command is loaded when it is asked for. That must stay light: heavy packages are imported
inside its function.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeAlias, cast, final

import typer.core

from shakerproc.late import loaded

Command: TypeAlias = Callable[..., None] | typer.Typer

_NAMES: Final = (
    "demo", "init", "inspect", "process", "batch", "watch", "check", "compare", "diagnose",
    "add", "effects", "simulate", "response", "study", "plan", "forecast", "modal", "stiffness",
    "coupon", "nastran", "convert", "doctor",
)  # fmt: skip
"""In the order of the help; each is also the name of its file, and of its function there."""

FORMER: Final = MappingProxyType({"modes": "coupon"})
"""Former names that still work in this version, and what each is called now."""

READING: Final = "Reading the recording"
TEST: Final = "The test"
CROP: Final = "The part that is used"
SPECTRA: Final = "Spectra"
TRENDS: Final = "Trends"
EVIDENCE: Final = "Further evidence"
MACHINES: Final = "Where it runs"
RESULTS: Final = "Results"
MODES: Final = "Modes"
"""Groups of options; an option without one stands first, under Options."""

GROUPS: Final[Mapping[str, Sequence[str]]] = {
    "Begin": ("demo", "init", "doctor"),
    "Recordings": ("inspect", "process", "convert"),
    "A campaign": ("batch", "watch", "check", "modal"),
    "The model": ("compare", "diagnose", "add", "simulate", "response", "study", "effects"),
    "Before the test": ("plan", "forecast"),
    "Coupons and other programs": ("coupon", "stiffness", "nastran"),
}
"""Groups of commands, in the order of the help."""

Row = tuple[str, str]


@final
class _Commands(Mapping[str, Command]):
    """Every command by its name, loaded when it is asked for."""

    def __getitem__(self, name: str) -> Command:
        if name in FORMER:
            return _under_former_name(self[FORMER[name]], name)
        if name not in _NAMES:
            raise KeyError(name)
        command: Command = loaded(f"{__name__}.{name}:{name}")
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)

    def __contains__(self, name: object) -> bool:
        return name in _NAMES or name in FORMER


def _under_former_name(command: Any, name: str) -> Command:
    """Return a command under its former name, with a note of the present one."""

    @wraps(command)
    def renamed(*args: Any, **options: Any) -> None:
        from shakerproc.cli import output

        output.warning(
            f"`shakerproc {name}` is called `shakerproc {FORMER[name]}` now. The former name "
            "works in this version only."
        )
        command(*args, **options)

    return renamed


COMMANDS: Final = _Commands()
"""Every command by its name."""


class GroupedCommand(typer.core.TyperCommand):
    """A command whose options stand in groups in its help."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options without a group, then each group in their order."""
        arguments: list[Row] = []
        options: dict[str, list[Row]] = {}
        for param in self.get_params(ctx):
            row = param.get_help_record(ctx)
            if row is None:
                continue
            if param.param_type_name == "argument":
                arguments.append(row)
            else:
                panel = getattr(param, "rich_help_panel", None) or "Options"
                options.setdefault(panel, []).append(row)
        plain = options.pop("Options", [])
        _write(formatter, {"Arguments": arguments, "Options": plain, **options})


UsageError: Final = cast("type[Exception]", typer.BadParameter.__base__)
"""Wrong usage, of the click that typer carries with it or of the one that it imports."""


@contextmanager
def _wrong_usage_in_one_line() -> Iterator[None]:
    """Let wrong usage be told in one line, as unusable input is, and not in typer's four."""
    try:
        yield
    except UsageError as raised:
        error: Any = raised
        if error.ctx is None or error.message != error.ctx.get_help():  # asked without a word
            error.show = partial(_tell_usage, error)
        raise


def _tell_usage(error: Any, file: object = None) -> None:  # noqa: ARG001 - as click calls it
    """Print the wrong word, the likely right one, and where the usage is described."""
    from shakerproc.cli import output

    text = " ".join(error.format_message().splitlines()).rstrip(".")
    if hasattr(error.__cause__, "errors"):  # pydantic says what it wants, not what it got
        text += f", not '{error.__cause__.errors()[0]['input']}'"
    absent = re.fullmatch(r"\w+ '(.+)' does not exist\.?", error.message)
    text += _hint(Path(absent[1])) if absent else "" if text.endswith("?") else "."
    place = error.ctx.command_path if error.ctx is not None else "shakerproc"
    output.message(f"error: {text} See `{place} -h`.")


def _hint(path: Path) -> str:
    """Return the end of a sentence on a path that does not exist: a name that may be meant."""
    from shakerproc.units import near_miss

    if not path.parent.is_dir():
        return f": there is no folder '{path.parent}'."
    meant = near_miss(path.name, [other.name for other in path.parent.iterdir()])
    return f". Did you mean '{path.with_name(meant)}'?" if meant else "."


class GroupedCommands(typer.core.TyperGroup):
    """The commands of the program, in groups in its help."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the arguments before the command."""
        with _wrong_usage_in_one_line():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Read the arguments of the command, and run it."""
        with _wrong_usage_in_one_line():
            return super().invoke(ctx)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands of each group, with their first lines."""
        width = formatter.width - 6 - max(map(len, self.commands), default=0)
        rows = {}
        for group, names in GROUPS.items():
            commands = ((name, self.get_command(ctx, name)) for name in names)
            rows[group] = [
                (name, command.get_short_help_str(width))
                for name, command in commands
                if command is not None
            ]
        _write(formatter, rows)


def _write(formatter: Any, sections: Mapping[str, Sequence[Row]]) -> None:
    """Write the sections that hold something, their second columns below each other."""
    first = max((len(row[0]) for rows in sections.values() for row in rows), default=0)
    for title, rows in sections.items():
        if rows:
            with formatter.section(title):
                formatter.write_dl([(f"{name:{min(first, 30)}}", text) for name, text in rows])
