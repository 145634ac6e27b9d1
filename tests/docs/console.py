"""The console blocks of a page: their commands are run, and what they print is compared."""

import math
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from tests.in_process import completed

from shakerproc.cli import output

TOLERANCE = 1e-3
"""How far a number on a page may lie from what a command prints (on another machine) [-]: at
most one in the last of the four digits that are printed."""

_BLOCK = re.compile(
    r"^(?:<!-- (?P<what>file): (?P<path>\S+) -->\n)?"
    r"```(?P<kind>\w+)\n(?P<body>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Command:
    """A command and what it prints."""

    line: str
    expected: tuple[str, ...]
    status: int = 0


def blocks(text):
    """Yield ("file", path, body) and ("console", "", commands), in the order of the page."""
    for found in _BLOCK.finditer(text):
        if found["what"]:
            yield found["what"], found["path"], found["body"]
        elif found["kind"] == "console":
            yield "console", "", list(commands(found["body"]))


def commands(body):
    """Yield the commands of a console block."""
    for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
        lines = part.rstrip("\n").split("\n")
        while lines[0].endswith("\\"):
            lines[0:2] = [lines[0][:-1] + lines[1].lstrip()]
        status = re.search(r"  # exit status (\d)$", lines[0])
        line = lines[0][: status.start()] if status else lines[0]
        yield Command(line, tuple(lines[1:]), int(status[1]) if status else 0)


def run(command, folder):
    """Run a command as the page shows it; return its status and all that it printed."""
    words = shlex.split(command.line)
    if words[0] == "shakerproc":
        with mock.patch.object(output, "TELL_EVERY", math.inf):  # no page shows progress
            done = completed(*words[1:], cwd=folder, env={"NO_COLOR": "1"}, merged=True)
        return done.returncode, done.stdout
    if words[0] == "python":
        words[:1] = [sys.executable]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}
    done = subprocess.run(
        words,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        timeout=500,
        check=False,
        env=environment,
    )
    return done.returncode, done.stdout


def disagreement(expected, printed):
    """Return the first line of a page that was not printed in its place, or None.

    A line of three dots stands for any lines; numbers may differ by `TOLERANCE`. What is said
    of compiling is left out: only a first run says it.
    """
    lines = [
        line.rstrip() for line in printed.splitlines() if not line.startswith("compiling ")
    ]
    at, loose = 0, False
    for wanted in expected:
        if wanted.strip() == "...":
            loose = True
            continue
        found = next((i for i in range(at, len(lines)) if alike(wanted, lines[i])), None)
        if found is None or (not loose and found != at):
            return wanted
        at, loose = found + 1, False
    if not loose and at != len(lines):
        return f"nothing more, but there is {lines[at]!r}"
    return None


def alike(wanted, found):
    """Return whether two lines say the same: words equal, numbers near."""
    if _NUMBER.sub("#", " ".join(wanted.split())) != _NUMBER.sub("#", " ".join(found.split())):
        return False
    return all(map(near, _NUMBER.findall(wanted), _NUMBER.findall(found)))


def near(shown, printed):
    """Return whether two numbers differ by `TOLERANCE`, or by one in the last place shown.

    One in the last place is what rounding alone can do to 1.249 and 1.251. Whole numbers are
    counts: of them only `TOLERANCE` is forgiven.
    """
    digits, _, power = shown.partition("e")
    _, point, places = digits.partition(".")
    last = 1.01 * 10.0 ** (int(power or 0) - len(places)) if point else 0.0
    return abs(float(shown) - float(printed)) <= max(TOLERANCE * abs(float(shown)), last)


def play(page, folder):
    """Run a page in a folder: write its files, run its commands.

    Returns
    -------
    list of str
        What did not come out as the page says.
    """
    wrong = []
    for what, path, content in blocks(Path(page).read_text(encoding="utf-8")):
        if what == "file":
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(content, encoding="utf-8")
        elif what == "console":
            for command in content:
                status, printed = run(command, folder)
                if status != command.status:
                    wrong.append(f"$ {command.line}: exit status {status}\n{printed}")
                elif missing := disagreement(command.expected, printed):
                    wrong.append(
                        f"$ {command.line}: the page has\n{missing}\nprinted:\n{printed}"
                    )
    return wrong
