"""First lines of docstrings name the quantity; a sentence of a message has at most 25 words."""

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "shakerproc"
VAGUE = re.compile(r"(?:(?:return|yield) )?(?:the same|what|the one that)\b", re.IGNORECASE)
CLAUSE = re.compile(r"\bwhat\b", re.IGNORECASE)
REWORDED_LATER = {"comparison", "diagnosis"}
"""Rooms whose clauses with "what" are still to be reworded; they may not begin with one."""

SHARE = 0.02
"""Share that is allowed; packages that were counted as models have 0 to 1 %."""

WORDS = 25
LATER_SENTENCES = {"comparison": 5, "diagnosis": 6, "forecasts": 1, "recordings": 8}
"""Longer sentences that are still to be split, by room."""

pytestmark = pytest.mark.slow  # reads every file of the program


@pytest.fixture(scope="module")
def trees():
    """Return the room and the syntax of every file of the program."""
    return [
        (path.relative_to(SOURCE).parts[0], ast.parse(path.read_text("utf-8")))
        for path in sorted(SOURCE.rglob("*.py"))
    ]


def test_at_most_two_per_cent_of_first_lines_describe_instead_of_naming(trees):
    every, vague = Counter(), Counter()
    for room, tree in trees:
        for node in ast.walk(tree):
            if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                continue
            line = (ast.get_docstring(node) or "").partition("\n")[0]
            clause = room not in REWORDED_LATER and CLAUSE.search(line)
            every[room] += bool(line)
            vague[room] += bool(VAGUE.match(line) or clause)
    assert {room for room in every if vague[room] > max(SHARE * every[room], 1)} == set()


def texts(tree):
    """Yield the strings of a file that are no docstrings, values in them as one word."""
    held = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            held.update(node.values)
    for node in ast.walk(tree):
        if node in held:
            continue
        if isinstance(node, ast.JoinedStr):
            yield "".join(getattr(part, "value", "") if isinstance(part, ast.Constant) else "X"
                          for part in node.values)  # fmt: skip
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def long_sentences(text):
    """Yield the sentences of a text that have too many words; references are none.

    Nor are whole files within a string: definitions of units, pages, templates.
    """
    if text.count("\n") > 10:
        return
    for sentence in re.split(r"(?<=[.!?])\s+", text):
        words = [word for word in sentence.split() if re.search(r"\w", word)]
        if len(words) > WORDS and not re.search(r"\b(19|20)\d\d\.$", sentence):
            yield sentence


def test_a_sentence_of_a_message_has_at_most_25_words(trees):
    found = {}
    for room, tree in trees:
        long = [sentence for text in texts(tree) for sentence in long_sentences(text)]
        found.setdefault(room, []).extend(long)
    beyond = {
        room: long for room, long in found.items() if len(long) > LATER_SENTENCES.get(room, 0)
    }
    assert beyond == {}
