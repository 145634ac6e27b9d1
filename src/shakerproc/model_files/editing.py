"""Changes to a model file that leave every comment, blank line and order where it was."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, final

import yaml

from shakerproc import files
from shakerproc.errors import DocumentError
from shakerproc.model_files.reading import ModelFile, read_model_file
from shakerproc.model_files.writing import (
    Provenance,
    element_text,
    mode_text,
    number,
    parameter_text,
    record_lines,
    structure_in_brackets,
    text_of,
)
from shakerproc.models.model import Element
from shakerproc.models.structure import Mode, Structure

Changes = Mapping[int, Mapping[str, float]]
"""New values by the number of the element in the file, from 0, and the parameter [SI]."""


@final
@dataclass(frozen=True, slots=True, order=True)
class _Edit:
    """A stretch of the text and its replacement."""

    start: int
    stop: int
    text: str


@final
@dataclass(frozen=True, slots=True)
class NewNumbers:
    """Numbers that a file gives already, with other values.

    Attributes
    ----------
    changes : mapping
        Of elements; see `change_parameters`.
    masses : mapping of str to float
        Masses [kg].
    structures : mapping of str to Structure
        Structures that have other numbers than their files say; they then stand in this one.
    """

    changes: Changes = field(default_factory=dict)
    masses: Mapping[str, float] = field(default_factory=dict)
    structures: Mapping[str, Structure] = field(default_factory=dict)


AS_THEY_ARE: Final = NewNumbers()
"""Nothing changed."""


@final
@dataclass(frozen=True, slots=True)
class _NewContent:
    """Wanted content of a changed file; see `add_element`."""

    numbers: NewNumbers
    modes: tuple[Mode, ...] = ()
    element: Element | None = None
    provenance: Provenance | None = None
    title: str | None = None


def add_element(
    path: Path,
    element: Element,
    out: Path,
    provenance: Provenance | None = None,
    *,
    numbers: NewNumbers = AS_THEY_ARE,
    modes: Sequence[Mode] = (),
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
    numbers : NewNumbers
        New values of what the file gives already.
    modes : sequence of Mode
        Further modes of the specimen, after those of the file.
    title : str, optional
        New title of the model.

    Raises
    ------
    DocumentError
        If the file is not a model, or is laid out so that it cannot be changed in place.
    """
    _edit(path, out, _NewContent(numbers, tuple(modes), element, provenance, title))


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
    _edit(path, out, _NewContent(NewNumbers(changes)))


# text is replaced: a YAML writer moves indentation and columns (decision 14)
def _edit(path: Path, out: Path, wanted: "_NewContent") -> None:
    """Write the changed text, once it has been read back and checked."""
    before, new = read_model_file(path), wanted.numbers
    motion = before.model.motion
    text = path.read_bytes().decode("utf-8-sig")
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    edits = _changes(before, root, new.changes) + _masses(before, root, new.masses)
    edits += _structures(before, root, out, new.structures)
    if wanted.title is not None:
        edits.append(_titled(text, root, wanted.title))
    if wanted.element is not None:
        edits.append(
            _addition(text, _value(root, "elements"), element_text(wanted.element, motion))
        )
    end: list[str] = []
    if wanted.modes:
        edits += _modes(text, root, [mode_text(one, motion) for one in wanted.modes], end)
    edits += _record(before, text, root, wanted, end)
    for edit in sorted(edits, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.stop :]
    if end:
        text += ("" if text.endswith("\n") else _line_end(text)) + _joined(text, end)
    with files.atomic_path(out) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        _check_written(before, temporary, wanted)


def _joined(text: str, lines: Sequence[str]) -> str:
    """Return whole lines with the line ends of a text."""
    return "".join(line + _line_end(text) for line in lines)


def _check_written(before: ModelFile, path: Path, wanted: _NewContent) -> None:
    """Check that a changed file reads back as intended.

    Raises
    ------
    DocumentError
        If it does not.
    """
    known, new = before.model, wanted.numbers
    added = () if wanted.element is None else (wanted.element,)
    expected = (
        _changed(before, new.changes) + added,
        {**known.masses, **new.masses},
        known.modes + wanted.modes,
        {**known.structures, **new.structures},
    )
    try:
        model = read_model_file(path).model
    except DocumentError as error:
        broken: DocumentError = _refused(before, error.says, "elements")
        raise broken from error
    written = (model.elements, dict(model.masses), model.modes, dict(model.structures))
    if written != expected:
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
            text = parameter_text(value, effect.parameters[name], file.model.motion)
            edits.append(_Edit(node.start_mark.index, node.end_mark.index, text))
    return edits


def _masses(file: ModelFile, root: Any, masses: Mapping[str, float]) -> list[_Edit]:
    """Return the edits that give masses other values.

    Raises
    ------
    DocumentError
        If one does not stand there as a plain number.
    """
    edits, unit = [], file.model.unit_of("kg")
    for name, value in masses.items():
        node = _value(_value(root, "masses"), name)
        if not isinstance(node, yaml.ScalarNode):
            refused: DocumentError = _refused(file, "the mass does not stand there", "masses")
            raise refused
        edits.append(_Edit(node.start_mark.index, node.end_mark.index, number(value, unit)))
    return edits


def _structures(
    file: ModelFile, root: Any, out: Path, changed: Mapping[str, Structure]
) -> list[_Edit]:
    """Return the edits by which a file in another folder names the same files of structures.

    Those that are changed stand in the file itself.
    """
    edits: list[_Edit] = []
    there, here = file.path.parent.resolve(), out.parent.resolve()
    for name, said in file.document.value.structures.items():
        node = _value(_value(root, "structures"), name)
        if name in changed:
            text = structure_in_brackets(changed[name], said if isinstance(said, str) else "")
            edits.append(_Edit(node.start_mark.index, _end(node), text))
        elif isinstance(said, str) and there != here:
            text = text_of(Path(os.path.relpath(there / said, here)).as_posix())
            edits.append(_Edit(node.start_mark.index, node.end_mark.index, text))
    return edits


def _modes(text: str, root: Any, modes: Sequence[str], end: list[str]) -> list[_Edit]:
    """Return the edits that append modes to those of a file; without any, lines at its end."""
    known = _value(root, "modes")
    if known is None or not known.value:
        end += ["modes:", *(f"  - {mode}" for mode in modes)]
        return []
    if known.flow_style:
        return [_addition(text, known, ", ".join(modes))]
    return [_addition(text, known, mode) for mode in modes]


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


def _addition(text: str, elements: Any, written: str) -> _Edit:
    """Return the edit that puts the text of an element or a mode after the last one."""
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
    """Return where the last thing in a node ends."""
    if isinstance(node, yaml.ScalarNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(last, tuple) else last)


def _after_line(text: str, position: int) -> tuple[int, str]:
    """Return where the next line begins, and the line end that is missing before it."""
    end = text.find("\n", position)
    return (len(text), _line_end(text)) if end < 0 else (end + 1, "")


def _record(
    file: ModelFile, text: str, root: Any, wanted: _NewContent, end: list[str]
) -> list[_Edit]:
    """Return the edit that appends the provenance of an element; the first one ends the file.

    Raises
    ------
    DocumentError
        If the provenance that stands there is written in brackets.
    """
    if wanted.element is None or wanted.provenance is None:
        return []
    lines = record_lines(file.path.name, wanted.element, wanted.provenance, file.model.motion)
    known = _value(root, "provenance")
    if known is None:
        end += ["provenance:", *(f"  {line}" for line in lines)]
        return []
    if known.flow_style:
        refused: DocumentError = _refused(file, "expected a list with dashes", "provenance")
        raise refused
    dash = text.rindex("-", 0, known.value[-1].start_mark.index)
    indent = " " * (dash - text.rfind("\n", 0, dash) - 1)
    at, lead = _after_line(text, _end(known.value[-1]))
    return [_Edit(at, at, lead + _joined(text, [indent + line for line in lines]))]
