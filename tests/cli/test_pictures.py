"""Pictures on a terminal, and what is told of effects there."""

import os
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shakerproc.cli import braille, output
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
    picture = braille.curve([-1.0, 0.0, 1.0], [-5.0, 0.0, 5.0], 8, 4)
    assert {(15, 0), (0, 15)} <= dots(picture)
    assert len(picture.splitlines()) == 4


@given(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1),
    st.integers(1, 9),
)
def test_every_point_is_drawn_within_the_picture(points, size):
    x, y = zip(*points, strict=True)
    picture = braille.curve(x, y, size, size)
    assert [len(line) for line in picture.splitlines()] == [size] * size
    assert 1 <= len(dots(picture)) <= len(points)


def test_the_kinds_are_completed():
    assert complete_kind("cou") == ["coulomb_friction"]
    assert set(EFFECTS) < set(complete_kind(""))


def test_a_picture_in_a_table_counts_with_its_widest_line():
    cells = [["gap", output.Picture("ab\ncdef"), "x" * 20]]
    assert output.columns_that_fit(("kind", "loop", "much"), cells, 37, ("much",)) == [0, 1, 2]
    assert output.columns_that_fit(("kind", "loop", "much"), cells, 36, ("much",)) == [0, 1]


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
@pytest.mark.parametrize("words", [["effects"], ["effects", "gap"]])
def test_effects_are_drawn_on_a_terminal_and_not_in_a_pipe(words):
    import pty

    command = [sys.executable, "-m", "shakerproc", *words]
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "120", "PYTHONUTF8": "1"}
    piped = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert not any(0x2800 <= ord(character) < 0x2900 for character in piped.stdout)
    master, slave = pty.openpty()
    with subprocess.Popen(command, stdout=slave, stderr=slave, env=environment) as process:
        os.close(slave)
        shown = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:
                break
            shown += part
            if not part:
                break
        process.wait(timeout=60)
    os.close(master)
    text = shown.decode("utf-8")
    drawn = [character for character in text if 0x2801 <= ord(character) < 0x2900]
    assert len(drawn) > (5 * len(EFFECTS) if len(words) == 1 else 40)
