"""Write docs/cli.md from the help of the commands: python docs/make_cli_page.py [--check]."""

import sys
from pathlib import Path

import typer

PAGE = Path(__file__).with_name("cli.md")
STATUS = """\
| status | meaning |
| --- | --- |
| 0 | done |
| 1 | unusable input, or some runs failed: one line on stderr for each |
| 2 | wrong usage, or no such path: one line on stderr, with the name that may be meant |
| 75 | another shakerproc works in the folder |
| 130 | interrupted |
"""


def help_of(*command: str) -> str:
    """Return the help of a command as a terminal of 96 columns shows it."""
    from typer.testing import CliRunner

    from shakerproc.cli import build_app

    environment = {"COLUMNS": "96", "NO_COLOR": "1"}
    shown = CliRunner().invoke(
        build_app(), [*command, "--help"], env=environment, prog_name="shakerproc"
    )
    return "\n".join(line.rstrip() for line in shown.stdout.strip().splitlines())


def page() -> str:
    """Return the whole page."""
    from shakerproc.cli.commands import COMMANDS

    parts = [
        "# The commands",
        "Made from `--help` by `python docs/make_cli_page.py`; a test compares.\n\n"
        "Data go to stdout, messages to stderr. `--json -` puts JSON on stdout and nothing "
        "else. Progress is drawn on a terminal only; `NO_COLOR` is obeyed. Tables fit the "
        "terminal: what has no room is wrapped, and a line names the columns that are left "
        "out. In a pipe or a file they are as wide as they need, or as `COLUMNS` says.",
        "`shakerproc --install-completion` lets the Tab key complete commands and options in "
        "bash, zsh, fish and PowerShell, from the next shell on.",
        STATUS.strip(),
        f"```text\n{help_of()}\n```",
    ]
    for name, command in COMMANDS.items():
        words = [(name,)]
        if isinstance(command, typer.Typer):
            words += [(name, str(inner.name)) for inner in command.registered_commands]
        parts += [f"## {' '.join(w)}\n\n```text\n{help_of(*w)}\n```" for w in words]
    return "\n\n".join(parts) + "\n"


def main() -> None:
    """Write the page, or with --check say whether it is up to date."""
    text = page()
    if "--check" not in sys.argv:
        PAGE.write_text(text, encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != text:
        sys.exit("docs/cli.md is not what --help says; run python docs/make_cli_page.py")


if __name__ == "__main__":
    main()
