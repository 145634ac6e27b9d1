"""Meaning of a YAML parser's complaint for someone who writes a test log."""

from typing import Final

import yaml

MOST_LEVELS: Final = 32
"""Lists and mappings within each other; no honest file comes near."""

_BACKSLASH: Final = r'"\" in double quotes; write / or use single quotes'
_BESIDE: Final = (
    'a key that does not belong here; does the line above lack ": " after its key, '
    "or is one of the two too far in?"
)
_QUOTE: Final = "put text with special characters in quotes"

# Part of libyaml's problem: what to say, and whether the mistake is where the context began.
_ADVICE: Final[tuple[tuple[str, str, bool], ...]] = (
    ("mapping values are not allowed", f'a second ": " in one line; {_QUOTE}', False),
    ("could not find expected ':'", 'expected ": " after the key; write key: value', True),
    (
        "did not find expected ',' or '}'",
        'expected "," or "}"; is a comma, a closing brace or a quote missing?',
        False,
    ),
    (
        "did not find expected ',' or ']'",
        'expected "," or "]"; is a comma, a closing bracket or a quote missing?',
        False,
    ),
    ("did not find expected key", "expected a key as far in as its neighbours above", False),
    ("did not find expected '-'", 'expected "- " as far in as its neighbours above', False),
    ("found unexpected end of stream", "a quote that opens here is never closed", True),
    ("found unexpected document indicator", "a quote that opens here is never closed", True),
    ("unknown escape character", _BACKSLASH, False),
    ("block sequence entries", '"- " is not allowed here; start a new line', False),
    ("mapping keys are not allowed", '"? " is not allowed here', False),
    ("did not find expected alphabetic", f'"*", "&" and "!" begin a name; {_QUOTE}', True),
    ("undefined tag handle", f'"!" begins a tag; {_QUOTE}', False),
    ("did not find URI", f'"!" begins a tag; {_QUOTE}', True),
    ("did not find expected whitespace", f'"*", "&" and "!" begin a name; {_QUOTE}', False),
    ("did not find expected <document start>", "expected the end of the file", False),
    ("tab character", "a tab; indent with spaces", False),
    # newer libyaml gives up by itself where 1000 brackets open, before we can count
    ("maximum nesting depth", f"nested deeper than {MOST_LEVELS} levels", False),
)  # fmt: skip


def advice_on(error: yaml.MarkedYAMLError, text: str) -> tuple[int, int, str]:
    """Return line and column from 1, and what is wrong there in the user's words."""
    problem = error.problem or "cannot be read"
    mark = error.problem_mark or error.context_mark
    line, column = _from_one(mark)
    before, after = _around(text, line, column)
    if "cannot start any token" in problem:
        return line, column, _on_first_character(after[:1])
    if "mapping values are not allowed" in problem and ": " not in before:
        return line, column, _BESIDE
    if "\\" in before and ("hexdecimal" in problem or "Unicode" in problem):
        return line, before.rindex("\\") + 1, _BACKSLASH
    for part, advice, at_context in _ADVICE:
        if part in problem:
            where = error.context_mark if at_context and error.context_mark else mark
            return *_from_one(where), advice + _opening(error)
    return line, column, f"not YAML: {problem}"


def _opening(error: yaml.MarkedYAMLError) -> str:
    """Return where the brace or bracket opens that is not closed."""
    if "',' or" not in (error.problem or "") or error.context_mark is None:
        return ""
    line, column = _from_one(error.context_mark)
    return f" (what opens on line {line}, column {column}, is still open)"


def _from_one(mark: yaml.Mark | None) -> tuple[int, int]:
    return (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)


def _around(text: str, line: int, column: int) -> tuple[str, str]:
    """Return a line up to a column, and the rest of it."""
    lines = text.split("\n")
    found = lines[line - 1] if line <= len(lines) else ""
    return found[: column - 1], found[column - 1 :]


def _on_first_character(found: str) -> str:
    if found == "\t":
        return "a tab; indent with spaces"
    return f'nothing may begin with "{found}"; put the text in quotes'
