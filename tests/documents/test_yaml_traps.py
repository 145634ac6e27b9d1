"""Forty-odd traps of YAML: what each becomes, or where and how it is refused."""

from typing import Any

import pytest

from shakerproc.documents import Section, read_document
from shakerproc.errors import DocumentError


class Anything(Section):
    value: Any = None
    other: Any = None


def read(tmp_path, text: str | bytes) -> Anything:
    path = tmp_path / "file.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_document(path, Anything).value


READ = {
    "on is text": ("value: on", "on"),
    "off is text": ("value: off", "off"),
    "NO is text, a country": ("value: NO", "NO"),
    "yes is text": ("value: yes", "yes"),
    "y is text": ("value: y", "y"),
    "true is true": ("value: true", True),
    "TRUE is true": ("value: TRUE", True),
    "tRue is text": ("value: tRue", "tRue"),
    "a tilde is nothing": ("value: [~]", [None]),
    "nULL is text": ("value: nULL", "nULL"),
    "1e3 is a number": ("value: 1e3", 1000.0),
    "1.e+3 is a number": ("value: 1.e+3", 1000.0),
    "a leading zero is no octal": ("value: 010", 10),
    "0o17 is octal": ("value: 0o17", 15),
    "0x1F is hexadecimal": ("value: 0x1F", 31),
    "0b11 is text": ("value: 0b11", "0b11"),
    "1_000 is text": ("value: 1_000", "1_000"),
    "1,000 is text": ("value: 1,000", "1,000"),
    "12:30 is text, no base 60": ("value: 12:30", "12:30"),
    "190:20:30 is text": ("value: 190:20:30", "190:20:30"),
    "a date is text": ("value: 2026-11-21", "2026-11-21"),
    "a version is text": ("value: 1.5.2", "1.5.2"),
    ".5 is a number": ("value: .5", 0.5),
    "+5 is a number": ("value: +5", 5),
    "a quoted number is text": ("value: '5'", "5"),
    "an equals sign is text": ("value: =", "="),
    "<< as a value is text": ("value: <<", "<<"),
    "a hash inside a word is text": ("value: run#3", "run#3"),
    "a comment after a space is one": ("value: run # 3", "run"),
    "a hash in quotes is text": ("value: 'run #3'", "run #3"),
    "lines are folded": ("value: a\n  b\n", "a b"),
    "a block keeps its lines": ("value: |\n  a\n  b\n", "a\nb\n"),
    "a comma at the end is no item": ("value: [1, 2,]", [1, 2]),
    "a byte order mark is no text": (b"\xef\xbb\xbfvalue: 1", 1),
    "Windows line ends are line ends": ("value: 1\r\nother: 2\r\n", 1),
    "old Macintosh line ends are line ends": ("value: 1\rother: 2\r", 1),
    "an alias is what it names": ("other: &a [1]\nvalue: *a", [1]),
    "a tab after a colon is a space": ("value:\t1", 1),
}


@pytest.mark.parametrize(("text", "value"), READ.values(), ids=READ.keys())
def test_a_scalar_is_what_yaml_1_2_says(tmp_path, text, value):
    found = read(tmp_path, text).value
    assert found == value
    assert type(found) is type(value)


# The mark § stands where the message has to point to, and is taken out before reading.
REFUSED = {
    "duplicate key": ("value: 1\n§value: 2", 'duplicate key "value", first on line 1'),
    "duplicate key deep inside": ("value: {a: 1, b: 2, §a: 3}", 'duplicate key "a"'),
    "tab as indentation": ("value:\n§\ta: 1", "a tab; indent with spaces"),
    "tab after spaces": ("value:\n  §\ta: 1", "a tab; indent with spaces"),
    "text after a hash": ("value: §run #3", 'only "run" is read; put the text in quotes'),
    "a second colon": ("value: a§: b", 'a second ": " in one line'),
    "merge key": ("other: &a {b: 1}\nvalue: {§<<: *a}", "merge keys"),
    "python tag": ("value: §!!python/object/apply:os.system [ls]", "tags are not read"),
    "tag of a string": ("value: §!!str 5", "tags are not read"),
    "own tag": ("value: §!mine 5", "tags are not read"),
    "infinity": ("value: §.inf", "expected a finite number, got .inf"),
    "not a number": ("value: §.NaN", "expected a finite number, got .NaN"),
    "too large": ("value: §1e999", "expected a finite number, got 1e999"),
    "endless digits": ("value: §" + "9" * 5000, "a number of at most 100 digits"),
    "second document": ("value: 1\n§---\nvalue: 2", "expected one document"),
    "directive": ("§%YAML 1.1\n---\nvalue: 1", 'may not begin with "%"'),
    "open quote": ('value: §"a\nother: 1\n', "a quote that opens here is never closed"),
    "backslash in quotes": (r'value: "C:§\Users"', "write / or use single quotes"),
    "at sign": ("value: §@a", 'nothing may begin with "@"'),
    "backtick": ("value: §`a", 'nothing may begin with "`"'),
    "unknown alias": ("value: §*a", 'no anchor "&a"; put text with \\* in quotes'),
    "alias of what holds it": ("value: &a [1, §*a]", "stands inside what it names"),
    "list as a key": ("value: {§[1, 2]: 3}", "expected a key that is text, got a list"),
    "nothing as a key": ("value: {§~: 3}", "expected a key that is text, got nothing"),
    "true as a key": ("value: {§true: 3}", "expected a key that is text, got true"),
    "number with a point as a key": ("value: {§1.5: 3}", "expected a key that is text"),
    "alias as a key": ("other: &a b\nvalue: {§*a : 3}", "got an alias"),
    "no space after the colon": ("value:1\nother§: 2", 'does the line above lack ": "'),
    "no space after the colon in braces": (
        "{§value:1}",
        "put a space after the colon: value: 1",
    ),
    "less indentation": ("value:\n  a: 1\n §b: 2", "as far in as its neighbours above"),
    "more indentation": ("value:\n  a: 1\n   b§: 2", "or is one of the two too far in"),
    "dash out of line": ("value:\n  - 1\n §- 2", "as far in as its neighbours above"),
    "open brace": ("value: {a: 1\nother§: 2", 'expected "," or "}"'),
    "open brace at the end": ("value: {a: 1§", 'expected "," or "}"'),
    "open bracket": ("value: [1, 2\nother§: 2", 'expected "," or "\\]"'),
    "nothing after a key": ("other: 1\nvalue:§", "expected a value after value:, got nothing"),
    "a tilde after a key": ("value: §~", "expected a value after value:, got nothing"),
    "nothing in the file": ("§", "got an empty file"),
    "only comments": ("§# nothing", "got an empty file"),
    "a list as the file": ("§- 1", "expected a mapping"),
    "text as the file": ("§value", "expected a mapping"),
    "control character": ("value: a§\x07b", "the control character 0x07"),
    "unprintable key": ('"§\\e[2J": 1'.replace('"§', '§"'), r'unknown key "\\x1b\[2J"'),
    "UTF-16": (b"\xa7" + "value: 1".encode("utf-16"), "got UTF-16; save it as UTF-8"),
    "a recording": (b"\xa7TDSm\x0e\x00\x00\x00\x93", "got binary data; is this another file"),
    "Latin 1": ("value: 5 §µm".encode("latin-1"), "got the byte 0xb5; save it as UTF-8"),
    "unknown key": ("§valeu: 1", 'did you mean "value"'),
    "a space that does not break": ("§\u00a0value: 1", 'did you mean "value"'),
}


@pytest.mark.parametrize(("marked", "match"), REFUSED.values(), ids=REFUSED.keys())
def test_what_could_mean_something_else_is_refused_at_its_place(tmp_path, marked, match):
    mark = "§" if isinstance(marked, str) else b"\xa7"
    before, _, after = marked.partition(mark)
    newline = "\n" if isinstance(marked, str) else b"\n"
    text = before + after
    line = before.count(newline) + 1
    column = len(before) - (before.rfind(newline) + 1) + 1
    with pytest.raises(DocumentError, match=match) as caught:
        read(tmp_path, text)
    assert (caught.value.line, caught.value.column) == (line, column)
    assert str(caught.value).startswith(f"{tmp_path / 'file.yaml'}:{line}:{column}: ")
    assert str(caught.value).isprintable()
    assert caught.value.path == tmp_path / "file.yaml"


@pytest.mark.parametrize("end", ["\x85", "\u2028", "\u2029"])
@pytest.mark.parametrize(
    "text", ['value: "a{}b"   # c\n', "value: a{}b # c\n", "# x{}other: 1\nvalue: a b\n"]
)
def test_line_separators_of_other_programs_are_spaces_and_count_no_lines(tmp_path, end, text):
    """YAML 1.2, section 5.4: none of them ends a line; an editor counts none either."""
    found = read(tmp_path, text.format(end))
    assert (found.value, found.other) == ("a b", None)
    with pytest.raises(DocumentError, match="othr") as caught:
        read(tmp_path, text.format(end) + "\nothr: 1")
    assert caught.value.line == text.count("\n") + 2


def test_there_are_forty_traps_and_more():
    assert len(READ) + len(REFUSED) > 80
