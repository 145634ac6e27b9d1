"""Changes to a model file that leave every comment, blank line and order where it was."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, final

import yaml

from shakerproc import files
from shakerproc.errors import DocumentError
from shakerproc.model_files.reading import ModelFile, read_model_file
from shakerproc.model_files.writing import element_text, number, parameter_text, text_of
from shakerproc.models.model import Element

Changes = Mapping[int, Mapping[str, float]]
"""New values by the number of the element in the file, from 0, and the parameter [SI]."""

_NONE: Final[Changes] = {}


@final
@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a fitted effect comes from; it is written into the model file.

    Attributes
    ----------
    tests : tuple of str or int
        Tests of the log that it was fitted to.
    hashes : mapping of str to str
        SHA-256 of each file that went in, by its name.
    intervals : mapping of str to (float, float)
        Confidence interval of each fitted parameter of the effect [SI].
    program : str
        Name and version of the program.
    date : str
        ISO date.
    """

    tests: tuple[str | int, ...] = ()
    hashes: Mapping[str, str] = field(default_factory=dict)
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    program: str = ""
    date: str = ""


@final
@dataclass(frozen=True, slots=True, order=True)
class _Edit:
    """A stretch of the text and what takes its place."""

    start: int
    stop: int
    text: str


def add_element(
    path: Path,
    element: Element,
    out: Path,
    provenance: Provenance | None = None,
    *,
    changes: Changes = _NONE,
    title: str | None = None,
) -> None:
    """Write the model file with one element more, comments and order kept.

    Parameters
    ----------
    path : Path
        The model file; `out` may be the same.
    element : Element
        Goes after the last element.
    out : Path
        Where the new file goes, whole or not at all.
    provenance : Provenance, optional
        Written into a list at the end of the file.
    changes : mapping
        New values of parameters that the file gives already; see `change_parameters`.
    title : str, optional
        New title of the model.

    Raises
    ------
    DocumentError
        If the file is not a model, or is laid out so that it cannot be changed in place.
    """
    _edit(path, out, changes, element, provenance, title=title)


def change_parameters(path: Path, changes: Changes, out: Path) -> None:
    """Write the model file with other values of some parameters, comments and order kept.

    Parameters
    ----------
    path : Path
        The model file; `out` may be the same.
    changes : mapping of int to mapping of str to float
        New values by the number of the element, from 0, and the parameter [SI].
    out : Path
        Where the new file goes, whole or not at all.

    Raises
    ------
    DocumentError
        If the file is not a model, or does not hold the parameter in so many words.
    """
    _edit(path, out, changes, None, None)


def _edit(
    path: Path,
    out: Path,
    changes: Changes,
    element: Element | None,
    provenance: Provenance | None,
    *,
    title: str | None = None,
) -> None:
    """Write the changed text, once it has been read back and says what it should."""
    before = read_model_file(path)
    text = path.read_bytes().decode("utf-8-sig")
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    edits = _changes(before, root, changes)
    if title is not None:
        edits.append(_titled(text, root, title))
    if element is not None:
        edits.append(_addition(text, _value(root, "elements"), element))
        if provenance is not None:
            edits.append(_record(before, text, root, element, provenance))
    for edit in sorted(edits, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.stop :]
    expected = _changed(before, changes) + ((element,) if element is not None else ())
    with files.atomic_path(out) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        _check_written(before, temporary, expected)


def _check_written(before: ModelFile, path: Path, expected: tuple[Element, ...]) -> None:
    """Pass a changed file that reads back as what it should say.

    Raises
    ------
    DocumentError
        If it does not.
    """
    try:
        elements = read_model_file(path).model.elements
    except DocumentError as error:
        broken: DocumentError = _refused(before, error.says, "elements")
        raise broken from error
    if elements != expected:
        wrong: DocumentError = _refused(before, "it would not read back the same", "elements")
        raise wrong


def _refused(file: ModelFile, why: str, *place: str | int) -> DocumentError:
    """Return the error of a file that has to be changed by hand."""
    return file.document.error(place, f"cannot be changed in place: {why}. Change it by hand.")


def _changed(file: ModelFile, changes: Changes) -> tuple[Element, ...]:
    return tuple(
        replace(element, effect=replace(element.effect, **changes.get(i, {})))  # type: ignore[type-var]
        for i, element in enumerate(file.model.elements)
    )


def _value(mapping: Any, key: str) -> Any:
    """Return the node of a key, or None."""
    return next((value for name, value in mapping.value if name.value == key), None)


def _changes(file: ModelFile, root: Any, changes: Changes) -> list[_Edit]:
    elements = _value(root, "elements").value
    edits = []
    for i, values in changes.items():
        effect = file.model.elements[i].effect
        for name, value in values.items():
            node = _value(elements[i], name)
            if not isinstance(node, yaml.ScalarNode):
                raise _refused(file, f"{name} does not stand there", "elements", i)
            text = parameter_text(value, effect.parameters[name])
            edits.append(_Edit(node.start_mark.index, node.end_mark.index, text))
    return edits


def _titled(text: str, root: Any, title: str) -> _Edit:
    """Return the edit that gives the model another title, or its first one."""
    node, written = _value(root, "title"), text_of(title)
    if node is not None:
        if node.style in {"|", ">"}:  # its end is that of its last line
            written += _line_end(text)
        return _Edit(node.start_mark.index, node.end_mark.index, written)
    version = _value(root, "model")
    if root.flow_style:
        at = version.end_mark.index
        return _Edit(at, at, f", title: {written}")
    at, lead = _after_line(text, version.end_mark.index)
    return _Edit(at, at, f"{lead}title: {written}{_line_end(text)}")


def _line_end(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"


def _addition(text: str, elements: Any, element: Element) -> _Edit:
    """Return the edit that puts an element after the last one."""
    written = element_text(element)
    if elements.flow_style:
        at = elements.end_mark.index - 1
        comma = ", " if elements.value else ""
        if elements.value:
            at = _end(elements.value[-1])
        return _Edit(at, at, comma + written)
    dash = text.rindex("-", 0, elements.value[-1].start_mark.index)
    indent = text[text.rfind("\n", 0, dash) + 1 : dash]
    if indent.strip():  # a dash within a line, such as "- - ..."
        indent = " " * len(indent)
    at, lead = _after_line(text, _end(elements.value[-1]))
    end = _line_end(text)
    return _Edit(at, at, f"{lead}{indent}- {written}{end}")


def _end(node: Any) -> int:
    """Return where the last thing in a node ends, before what follows it."""
    if isinstance(node, yaml.ScalarNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(last, tuple) else last)


def _after_line(text: str, position: int) -> tuple[int, str]:
    """Return where the next line begins, and the line end that is missing before it."""
    end = text.find("\n", position)
    return (len(text), _line_end(text)) if end < 0 else (end + 1, "")


def _record(
    file: ModelFile, text: str, root: Any, element: Element, provenance: Provenance
) -> _Edit:
    """Return the edit that appends the provenance of an element.

    Raises
    ------
    DocumentError
        If the provenance that stands there is written in brackets.
    """
    end = _line_end(text)
    lines = _record_lines(file, element, provenance)
    known = _value(root, "provenance")
    if known is None:
        start = "" if text.endswith("\n") else end
        block = ["provenance:", *(f"  {line}" for line in lines)]
        return _Edit(len(text), len(text), start + end.join(block) + end)
    if known.flow_style:
        refused: DocumentError = _refused(file, "expected a list with dashes", "provenance")
        raise refused
    dash = text.rindex("-", 0, known.value[-1].start_mark.index)
    indent = " " * (dash - text.rfind("\n", 0, dash) - 1)
    at, lead = _after_line(text, _end(known.value[-1]))
    return _Edit(at, at, lead + end.join(indent + line for line in lines) + end)


def _record_lines(file: ModelFile, element: Element, provenance: Provenance) -> list[str]:
    parameters = element.effect.parameters
    between = ", ".join(text_of(place) for place in element.between)
    lines = [f"- added: {element.effect.kind}", f"  between: [{between}]"]
    lines.append(f"  from model: {text_of(file.path.name)}")
    if provenance.tests:
        tests = ", ".join(
            t if isinstance(t, str) and t.isalpha() else _key(t) for t in provenance.tests
        )
        lines.append(f"  tests: [{tests}]")
    if provenance.hashes:
        lines.append("  sha256:")
        lines += [
            f"    {_key(name)}: {_key(digest)}" for name, digest in provenance.hashes.items()
        ]
    if provenance.intervals:
        lines.append("  intervals:")
        for name, (low, high) in provenance.intervals.items():
            unit = parameters[name].unit
            limits = ", ".join(_key(number(value, unit)) for value in (low, high))
            lines.append(f"    {name}: [{limits}]")
    if provenance.program:
        lines.append(f"  program: {_key(provenance.program)}")
    if provenance.date:
        lines.append(f"  date: {_key(provenance.date)}")
    return lines


def _key(value: str | int) -> str:
    """Return a whole number plain and text in quotes, so that a hash stays text."""
    return str(value) if isinstance(value, int) else json.dumps(value, ensure_ascii=False)
