"""Tables on the terminal: they fit, nothing is cut, and what is left out is told."""

import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.cli.terminal import shown_on_terminal
from tests.small_campaign import write_campaign

from shakerproc.cli import output, tables

COMPARED = (
    "test", "level", "sensor", "error", "noise", "PSD", "H1", "peak [Hz]", "model [Hz]",
    "gain", "model gain",
)  # fmt: skip
ROWS = [
    ("1", "0.02 g²/Hz", "ch3", 0.81234, 0.00231, 0.7621, 1.2345e-05, 366.7, 250.1, 21.03, 20.1),
    ("15 (held out)", "0.04 g^2/Hz", "ch4", 0.76543, 0.00123, 0.5, 0.8, 315.2, 250.0, 1.5, 9.0),
]  # fmt: skip
words = st.text(st.sampled_from("abcdefgh ijkl_-é²"), max_size=60)
cells = words | st.floats(-1e300, 1e300) | st.integers(-(10**6), 10**6) | st.none()


def printed(columns, rows, width, spare=()):
    """The lines of a table of so many characters, and the line about what is left out."""
    texts = [[output.cell_text(value) for value in row] for row in rows]
    numeric = [
        all(isinstance(row[i], int | float) or row[i] is None for row in rows)
        for i in range(len(columns))
    ]
    layout = tables.fitted(columns, texts, numeric, width, spare)
    lines = [
        line for row in (columns, *texts) for line in tables.lines_of(row, layout, numeric)
    ]
    return layout, lines, texts


def numbers_in(rows, kept):
    return {
        output.cell_text(row[i])
        for row in rows
        for i in kept
        if isinstance(row[i], float | int)
    }


@pytest.mark.parametrize("width", [80, 100, 120])
def test_the_errors_of_compare_are_printed_whole(width):
    layout, lines, _ = printed(COMPARED, ROWS, width, ("gain", "model gain"))
    assert all(len(line) <= width for line in lines)
    assert {"0.8123", "0.7621", "1.234e-05", "0.00231"} <= set(" ".join(lines).split())
    assert "\u2026" not in " ".join(lines)
    assert len(layout.kept) + len(layout.left_out) == len(COMPARED)


@given(
    st.integers(1, 6).flatmap(
        lambda n: st.tuples(
            st.lists(words.filter(str.strip), min_size=n, max_size=n),
            st.lists(st.lists(cells, min_size=n, max_size=n), min_size=1, max_size=5),
        )
    ),
    st.integers(10, 140),
)
def test_a_table_fits_or_says_what_is_left_out_and_never_cuts_a_number(table, width):
    columns, rows = table
    layout, lines, texts = printed(columns, rows, width)
    assert len(layout.kept) + len(layout.left_out) + len(layout.empty) == len(columns)
    assert bool(layout.omission_text("x")) is (len(layout.kept) < len(columns))
    if len(layout.kept) > 1:
        assert max(map(len, lines)) <= width
    shown = set(" ".join(lines).split())
    for i in layout.kept:
        if all(isinstance(row[i], float | int) or row[i] is None for row in rows):
            assert {texts[k][i] for k in range(len(rows)) if texts[k][i]} <= shown
    for i, room in zip(layout.kept, layout.widths, strict=True):
        for row in texts:  # a text is all there, in order
            assert "".join("".join(tables.wrapped(row[i], room)).split()) == "".join(
                row[i].split()
            )


def test_where_there_is_room_nothing_is_folded():
    _, lines, _ = printed(("a", "b"), [["two words", 1.5]], None)
    assert lines == ["a            b", "two words  1.5"]


def test_empty_columns_go_first_then_the_spared_then_the_last():
    columns = ("test", "orientation", "omega_e [Hz]", "note")
    rows = [["1", "out-of-plane", 366.3, ""], ["2", "in-plane", 315.5, ""]]
    kept = [printed(columns, rows, n, ["orientation"])[0] for n in (80, 36, 30, 16, 5)]
    assert [layout.kept for layout in kept] == [
        (0, 1, 2, 3), (0, 1, 2), (0, 1, 2), (0, 2), (0,)
    ]  # fmt: skip
    assert kept[3].omission_text("runs.csv") == (
        "columns left out: orientation, note (empty); widen the terminal or see runs.csv"
    )


def test_wide_letters_take_two_places():
    layout, lines, _ = printed(("\u8a66\u9a13", "b"), [["\u8a66", 1]], None)
    assert layout.widths[0] == 4
    assert lines[1] == "\u8a66    1"


LONG = "a_recording_of_which_the_name_is_longer_than_the_terminal_is_wide_and_still_counts"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Three tests, one of a long name with a channel of a long name."""
    log = write_campaign(tmp_path_factory.mktemp("campaign"), 3)
    text = log.read_text().replace("id: 1,", f"id: {LONG[:60]},").replace("ch4", LONG[:44])
    log.write_text(text)
    return log


def on_terminal(width, *words):
    text = shown_on_terminal(
        [sys.executable, "-m", "shakerproc", *map(str, words)],
        COLUMNS=str(width),
        NO_COLOR="1",
        TERM="dumb",
    )
    return [line.rstrip("\r") for line in text.split("\n")]


def table_of(lines):
    """The lines of the first table: what stands above and below its rule."""
    rule = next(i for i, line in enumerate(lines) if line and set(line) == {"─"})
    end = next(
        i for i in range(rule, len(lines)) if re.match(r"\d+ processed|columns", lines[i])
    )
    return lines[max(0, rule - 3) : end]


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_batch_fits_the_terminal_with_long_names(campaign):
    lines = on_terminal(80, "batch", campaign, "--no-figures", "--workers", "1")
    table = table_of(lines)
    assert max(map(len, table)) <= 80
    assert not any("\u2026" in line for line in lines)
    said = [line for line in lines if line.startswith("columns left out")]
    wanted = {"orientation", "coherence", "frequency", "Q"}
    known = " ".join([*table, *said])
    assert all(word in known for word in wanted), known
    shown = [word for line in table for word in line.split()]
    assert sum(bool(re.fullmatch(r"\d{3}\.\d", word)) for word in shown) >= 3


def test_a_pipe_has_the_width_that_columns_says_and_else_all_it_needs(monkeypatch, capsys):
    row = [["one two three four five six seven", 1.0]]
    monkeypatch.delenv("COLUMNS", raising=False)
    output.print_table(("words", "number"), row)
    assert (
        capsys.readouterr().out.splitlines()[1] == "one two three four five six seven       1"
    )
    monkeypatch.setenv("COLUMNS", "20")
    output.print_table(("words", "number"), row)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 20
    assert len(lines) > 3
