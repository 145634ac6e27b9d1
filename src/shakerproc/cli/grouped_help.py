"""Help whose commands and options stand in groups, as plain text."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import typer.core

READING: Final = "Reading the recording"
TEST: Final = "The test"
CROP: Final = "The part that is used"
SPECTRA: Final = "Spectra"
TRENDS: Final = "Trends"
EVIDENCE: Final = "Further evidence"
MACHINES: Final = "Where it runs"
RESULTS: Final = "Results"
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


class GroupedCommands(typer.core.TyperGroup):
    """The commands of the program, in groups in its help."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands of each group, with their first lines."""
        width = formatter.width - 6 - max(map(len, self.commands), default=0)
        rows = {}
        for group, names in GROUPS.items():
            found = ((name, self.get_command(ctx, name)) for name in names)
            rows[group] = [
                (name, command.get_short_help_str(width))
                for name, command in found
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
