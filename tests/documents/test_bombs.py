"""Files made to hurt: each is refused in one line, in half a second, in 100 MB."""

import subprocess
import sys
from pathlib import Path

import pytest

from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

BOMBS = {
    "billion laughs": (
        "a0: &a0 [lol]\n"
        + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)),
        "more than 100000 values",
    ),
    "quadratic blow-up": (
        "a: &a [" + "1, " * 2000 + "1]\nvalue: [" + "*a, " * 999 + "*a]\n",
        "more than 100000 values",
    ),
    "200,000 levels of brackets": ("[" * 200_000, "nested deeper than 32 levels"),
    "levels of dashes": ("- " * 50_000 + "a", "nested deeper than 32 levels"),
    "levels of aliases": (
        "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 60)),
        "nested deeper than 32 levels",
    ),
    "half a million items": ("value:\n" + "- a\n" * 499_000, "more than 100000 values"),
    "aliases without end": (
        "a: &a b\nvalue: [" + "*a, " * 5_000 + "*a]",
        "more than 1000 alias",
    ),
    "300 MB": (None, "expected at most 2 MB"),
    "tag directives": ("".join(f"%TAG !{i}! x\n" for i in range(100_000)), 'begin with "%"'),
    "a number of a million digits": ("value: " + "9" * 1_000_000, "at most 100 digits"),
    "anchors without end": (
        "value:\n" + "".join(f"- &a{i} x\n" for i in range(130_000)),
        "more than 100000 values|at most 2 MB",
    ),
    "a key of a million letters": (
        "a" * 1_000_000 + ": 1",
        "does not belong here",
    ),
    "a million colons": ("value: " + "a: " * 600_000, 'a second ": "'),
    "hashes without end": ("value: 1\n" + "x #y" * 480_000, "after the key|a comment"),
    "quotes without end": ("value: " + "'" * 1_000_001, "never closed"),
    "question marks": ("? " * 50_000, "nested deeper|a key that is text|not allowed"),
    "comments without end": ("#\n" * 990_000, "an empty file"),
}

PROGRAM = """
import os, resource, sys, time
from pathlib import Path
from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3

for path in sys.argv[1:]:
    if os.fork() == 0:
        before, start = peak(), time.process_time()
        try:
            read_testlog(Path(path))
        except DocumentError as error:
            print(time.process_time() - start, peak() - before, str(error), flush=True)
        os._exit(0)
    os.wait()
"""


def write(path, text):
    if text is not None:
        path.write_text(text)
        return
    with path.open("wb") as file:
        file.truncate(300_000_000)  # sparse: takes no room on the disk


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows neither forks nor tells the peak")
def test_bombs_are_refused_in_seconds_and_100_mb(tmp_path):
    """What is not bounded takes half a minute; `python -m tests.documents` times what is."""
    paths = [str(tmp_path / f"{number}.yaml") for number in range(len(BOMBS))]
    for path, (text, _) in zip(paths, BOMBS.values(), strict=True):
        write(Path(path), text)
    command = [sys.executable, "-c", PROGRAM, *paths]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == len(BOMBS)
    for (name, (_, match)), line in zip(BOMBS.items(), lines, strict=True):
        seconds, megabytes, message = line.split(" ", 2)
        assert len(message) < 500, name
        assert any(part in message for part in match.split("|")), (name, message)
        assert float(seconds) < 5.0, (name, seconds)
        assert float(megabytes) < 100.0, (name, megabytes)


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/random"])
def test_a_device_is_not_read(device):
    if not Path(device).exists():
        pytest.skip(f"this system has no {device}")
    with pytest.raises(DocumentError, match="expected a YAML file, got a folder or a device"):
        read_testlog(Path(device))
