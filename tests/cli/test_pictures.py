"""Pictures on a terminal, and what is told of effects there."""

import os
import re
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.cli.terminal import shown_on_terminal

from shakerproc.cli import tables
from shakerproc.cli.commands import effects
from shakerproc.cli.commands.effects import complete_kind
from shakerproc.models import EFFECTS


def dots(picture):
    """Places of the dots, from the upper left, by the definition of the characters."""
    places = set()
    bits = {
        0: (0, 0),
        1: (1, 0),
        2: (2, 0),
        3: (0, 1),
        4: (1, 1),
        5: (2, 1),
        6: (3, 0),
        7: (3, 1),
    }
    for i, line in enumerate(picture.splitlines()):
        for j, character in enumerate(line):
            for bit, (down, across) in bits.items():
                if (ord(character) - 0x2800) >> bit & 1:
                    places.add((4 * i + down, 2 * j + across))
    return places


def test_a_straight_line_runs_from_corner_to_corner():
    picture = effects.curve([-1.0, 0.0, 1.0], [-5.0, 0.0, 5.0], 8, 4)
    assert {(15, 0), (0, 15)} <= dots(picture)
    assert len(picture.splitlines()) == 4


@given(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1),
    st.integers(1, 9),
)
def test_every_point_is_drawn_within_the_picture(points, size):
    x, y = zip(*points, strict=True)
    picture = effects.curve(x, y, size, size)
    assert [len(line) for line in picture.splitlines()] == [size] * size
    assert 1 <= len(dots(picture)) <= len(points)


def test_the_kinds_are_completed():
    assert complete_kind("cou") == ["coulomb_friction"]
    assert set(EFFECTS) < set(complete_kind(""))


def test_a_picture_in_a_table_counts_with_its_widest_line():
    cells = [["gap", tables.Picture("ab\ncdef gh"), "xx"]]
    fits = [
        tables.fitted(("kind", "loop", "much"), cells, [False] * 3, width, ("much",)).kept
        for width in (19, 18)
    ]
    assert fits == [(0, 1, 2), (0, 1)]


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
@pytest.mark.parametrize("words", [["effects"], ["effects", "gap"]])
def test_effects_are_drawn_on_a_terminal_and_not_in_a_pipe(words):
    command = [sys.executable, "-m", "shakerproc", *words]
    environment = {**os.environ, "PYTHONUTF8": "1"}
    piped = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert not any(0x2800 <= ord(character) < 0x2900 for character in piped.stdout)
    text = shown_on_terminal(command)
    drawn = [character for character in text if 0x2801 <= ord(character) < 0x2900]
    assert len(drawn) > (5 * len(EFFECTS) if len(words) == 1 else 40)


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_what_is_said_meanwhile_does_not_run_into_the_bar():
    code = (
        "import time\n"
        "from shakerproc.cli import output\n"
        "with output.progress('work', 2) as advance:\n"
        "    advance('one'); time.sleep(0.5)\n"
        "    output.message('note [bold]' + 'x' * 150); advance('two')\n"
        "output.message('after')\n"
    )
    shown = shown_on_terminal([sys.executable, "-c", code])
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown)
    lines = [line for part in plain.split("\n") for line in part.split("\r")]
    assert "note [bold]" + "x" * 150 in lines
    assert "after" in lines
    assert any(line.startswith("work one") and "1/2" in line for line in lines)
    piped = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert piped.stdout == ""
    assert piped.stderr.splitlines() == ["note [bold]" + "x" * 150, "after"]
