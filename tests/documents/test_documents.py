"""Documents: places for later errors, several mistakes at once, schemas of every shape."""

import json
from typing import Annotated, Literal

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import Field, field_validator, model_validator

from shakerproc.documents import FromList, Section, misplaced, read_document
from shakerproc.documents.tree import MOST_ITEMS, read_tree
from shakerproc.errors import DocumentError
from shakerproc.units import in_unit


class Circle(Section):
    kind: Literal["circle"]
    radius: Annotated[float, in_unit("m")]


class Square(Section):
    kind: Literal["square"]
    side: Annotated[float, in_unit("m")]


class Drawing(Section):
    title: str = ""
    count: Annotated[int, Field(ge=1, le=9)] = 1
    share: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.5
    shown: bool = True
    between: Annotated[tuple[str, str], FromList] = ("a", "b")
    names: dict[str, str | float] = Field(default_factory=dict)
    shapes: list[Annotated[Circle | Square, Field(discriminator="kind")]] = Field(
        default_factory=list
    )
    low: float = 0.0
    high: float = 1.0

    @field_validator("title")
    @classmethod
    def _no_shouting(cls, title: str) -> str:
        if title.isupper():
            raise ValueError("expected a title in small letters")
        return title

    @model_validator(mode="after")
    def _low_below_high(self) -> "Drawing":
        if self.low >= self.high:
            raise misplaced("expected more than low", "high")
        return self


def read(tmp_path, text):
    path = tmp_path / "drawing.yaml"
    path.write_text(text)
    return read_document(path, Drawing)


def refused(tmp_path, marked):
    """Return the error about a text in which § marks the place it has to name."""
    before, _, after = marked.partition("§")
    with pytest.raises(DocumentError) as caught:
        read(tmp_path, before + after)
    line = before.count("\n") + 1
    column = len(before) - (before.rfind("\n") + 1) + 1
    assert (caught.value.line, caught.value.column) == (line, column), str(caught.value)
    return caught.value.says


@pytest.mark.parametrize(
    ("marked", "says"),
    [
        ("title: §5", "title: expected text, got 5; put it in quotes"),
        ("title: §[a]", "title: expected text, got a list"),
        ("title: §LOUD", "title: expected a title in small letters"),
        ("count: §1.5", "count: expected a whole number, got 1.5"),
        ("count: §'3'", 'count: expected a whole number, got "3"'),
        ("count: §true", "count: expected a whole number, got true"),
        ("count: §0", "count: expected a number of at least 1, got 0"),
        ("count: §10", "count: expected a number of at most 9, got 10"),
        ("share: §0", "share: expected a number above 0, got 0"),
        ("share: §1", "share: expected a number below 1, got 1"),
        ("share: §much", 'share: expected a number, got "much"'),
        ("shown: §yes", 'shown: expected true or false, got "yes"; did you mean true?'),
        ("shown: §off", 'shown: expected true or false, got "off"; did you mean false?'),
        ("shown: §1", "shown: expected true or false, got 1"),
        ("between: §base", 'between: expected a list, got "base"'),
        ("between: §[base]", "between: expected 2 values at least, got 1"),
        ("between: [base, §5]", "between.2: expected text, got 5; put it in quotes"),
        ("names: §[a]", "names: expected a mapping (key: value), got a list"),
        ("names: {a: §[1]}", "names.a: expected text or a number, got a list"),
        ("shapes:\n  - §{radius: 1 m}", 'shapes.1: expected the key "kind", which is missing'),
        (
            "shapes:\n  - §{kind: cirle, radius: 1 m}",
            'shapes.1: expected "circle", "square", got "cirle"; did you mean "circle"?',
        ),
        (
            "shapes:\n  - §{kind: circle}",
            'shapes.1: expected the key "radius", which is missing',
        ),
        (
            "shapes:\n  - {kind: circle, §side: 1 m}",
            'shapes.1: unknown key "side"; the keys here are kind, radius',
        ),
        ("shapes:\n  - §circle", "shapes.1: "),
        ("low: 1\nhigh: §0.5", "high: expected more than low"),
        ("§colour: red", 'unknown key "colour"; the keys here are between, count'),
        ("§titel: red", 'unknown key "titel"; did you mean "title"?'),
        ("§5: red", "unknown key 5; the keys here are "),
    ],
)
def test_each_mistake_is_told_at_its_place(tmp_path, marked, says):
    assert refused(tmp_path, marked).startswith(says)


def test_the_first_of_several_mistakes_is_told_with_their_number(tmp_path):
    says = refused(tmp_path, "shown: §yes\ncount: 0\ntitle: 5\n")
    assert says.endswith("did you mean true? (and 2 more below)")


class Part(Section):
    mass: Annotated[float, in_unit("kg")]


class Whole(Section):
    parts: dict[str, str | Part]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("parts:\n  a: {mass: 3}\n", "2:13: parts.a.mass: expected a number with a unit of kg"),
        ("parts:\n  a: 3\n", "2:6: parts.a: expected text or a mapping (key: value), got 3"),
    ],
)
def test_a_mistake_where_a_name_or_a_mapping_may_stand_is_told_where_it_is(
    tmp_path, text, says
):
    path = tmp_path / "whole.yaml"
    path.write_text(text)
    with pytest.raises(DocumentError) as caught:
        read_document(path, Whole)
    assert says in str(caught.value)


def test_an_error_found_later_names_the_place(tmp_path):
    document = read(tmp_path, "title: a\nshapes:\n  - {kind: circle, radius: 1 m}\n")
    error = document.error(("shapes", 0, "radius"), "expected less")
    assert str(error) == f"{tmp_path / 'drawing.yaml'}:3:28: shapes.1.radius: expected less"
    at_key = document.error(("shapes", 0, "radius"), "expected less", at_key=True)
    assert (at_key.line, at_key.column) == (3, 20)
    absent = document.error(("shapes", 0, "colour"), "expected a colour")
    assert str(absent).endswith(":3:5: shapes.1: expected a colour")
    assert document.error((), "expected more").line == 1
    assert document.line(("shapes", 0)) == 3


def test_a_missing_file_and_a_folder_are_told(tmp_path):
    with pytest.raises(DocumentError, match=r"none\.yaml:1:1: cannot be read: No such file"):
        read_document(tmp_path / "none.yaml", Drawing)
    with pytest.raises(DocumentError, match="got a folder or a device"):
        read_document(tmp_path, Drawing)


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**18), 10**18),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(
        st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Co", "Cn")), max_size=9
    ),
)
keys = st.text(st.characters(codec="ascii", categories=("L", "N")), min_size=1, max_size=9)
documents = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=4),
    max_leaves=20,
)


@settings(deadline=None)
@given(documents, st.booleans())
def test_what_a_writer_writes_is_read_back(tmp_path_factory, document, flow):
    # json is a subset of YAML 1.2, and json.dumps shares no code with this reader
    text = json.dumps(document, ensure_ascii=False, indent=None if flow else 2)
    assert read_tree(tmp_path_factory.getbasetemp() / "a.yaml", text)[0] == document


@settings(deadline=None)
@given(st.dictionaries(keys, st.text("ab 'é:#-{}[],&*!|>%@`\"\\", max_size=12), max_size=6))
def test_quoted_text_of_another_writer_is_read_back(tmp_path_factory, document):
    text = yaml.safe_dump(document, default_style='"', allow_unicode=True, width=10**6)
    found = read_tree(tmp_path_factory.getbasetemp() / "a.yaml", text)[0]
    assert (found or {}) == document


@settings(deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_read_or_refused_with_a_place(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(text, encoding="utf-8", newline="")
    error = None
    try:
        read_document(path, Drawing)
    except DocumentError as found:
        error = found
    if error is not None:
        assert 1 <= error.line <= text.count("\n") + text.count("\r") + 2
        assert error.column >= 1
        assert str(error).isprintable()


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "bytes.yaml"
    path.write_bytes(content)
    try:
        found = read_document(path, Drawing).value.count
    except DocumentError:
        found = 1
    assert found == 1 or b"count" in content


def test_five_thousand_rows_are_far_below_the_caps(tmp_path):
    rows = "".join(f"  - {{kind: circle, radius: {n} mm}}\n" for n in range(5000))
    assert len(read(tmp_path, "shapes:\n" + rows).value.shapes) == 5000
    assert MOST_ITEMS >= 5000 * 15
