"""Variables of HDF5 and MATLAB files: read a slice at a time, or one within the other.

Simulink saves a structure with ``time`` and ``signals(k).values``, each signal with its label;
a timeseries that was turned into a structure has ``Time``, ``Data`` and ``Name``; measuring
programs put the unit beside the values.
"""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias, final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import ArrayLike
from shakerproc.recordings.guard import AGAIN, foreign, shown

Tree: TypeAlias = "ArrayLike | list[str] | Mapping[str, Any] | MatlabObject | None"
"""Numbers, lines of text, fields (or elements, by their index), an object, or the unknown."""

VALUES: Final = re.compile(r"values?|data|samples|signal|y|y_?values?", re.IGNORECASE)
"""Fields that hold the numbers of what is described beside them."""

LABEL: Final = re.compile(r"label|name|(?:channel|signal|short)_?name", re.IGNORECASE)
UNIT: Final = re.compile(r"units?|y?_?units?(?:_?string)?", re.IGNORECASE)
_ABOUT: Final = ("DataInfo", "Info", "Properties")
"""Structures beside values that describe them."""

DEEPEST: Final = 8
"""How far groups may stand in each other."""

_PACKED: Final = 1040
"""Times that packing makes numbers smaller at most: deflate reaches 1032."""

_LARGEST_CHUNK: Final = 1 << 28
"""Bytes that are unpacked at once at most."""


@final
@dataclass(frozen=True, slots=True)
class MatlabObject:
    """A variable of a class, which only its own program can open."""

    kind: str


@final
@dataclass(slots=True, eq=False)
class Variables:
    """Variables of a file, as arrays and texts by their places.

    Attributes
    ----------
    arrays : dict
        Real numbers with at most two axes, by where they stand.
    texts : dict
        Lines of text, by where they stand.
    called : dict
        Label and unit of an array, where they stand beside it; either may be empty.
    left_out : list of str
        What could not be read, with what it is.
    """

    arrays: dict[str, ArrayLike] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)
    called: dict[str, tuple[str, str]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)


def flattened(trees: Iterable[tuple[str, Tree]]) -> Variables:
    """Return the arrays and texts of variables, however deep they stand."""
    variables = Variables()
    for name, tree in trees:
        _sort_in(name, tree, ("", ""), variables)
    keep_distinct(variables.called)
    return variables


def _sort_in(name: str, tree: Tree, called: tuple[str, str], variables: Variables) -> None:
    """Put a variable where it belongs; `called` are the names beside it or above."""
    if isinstance(tree, list):
        variables.texts[name] = [text.strip() for text in tree]
    elif isinstance(tree, MatlabObject):
        variables.left_out.append(
            f"{name}, an object of class {tree.kind}: save its times and data as vectors"
        )
    elif isinstance(tree, Mapping):
        own = _described(tree)
        called = (own[0] or called[0], own[1] or called[1])
        for key, inner in tree.items():
            holds = isinstance(inner, Mapping) or bool(VALUES.fullmatch(key))
            path = f"{name}{key}" if key[:1] in {"(", "{"} else f"{name}.{key}"
            _sort_in(path, inner, called if holds else ("", ""), variables)
    elif tree is not None and (plain := _two_axes(tree)) is not None:
        variables.arrays[name] = plain
        if any(called):
            variables.called[name] = called
    else:
        variables.left_out.append(name)


def _described(fields: Mapping[str, Any]) -> tuple[str, str]:
    """Return label and unit among fields, or in a structure about them."""
    about = [fields[key] for key in _ABOUT if isinstance(fields.get(key), Mapping)]
    said = [
        next((t for part in (fields, *about) if (t := _text(part, kind))), "")
        for kind in (LABEL, UNIT)
    ]
    return said[0], said[1]


def _text(fields: Mapping[str, Any], kind: re.Pattern[str]) -> str:
    """Return the single line of text in the first field of a kind."""
    lines = [v for k, v in fields.items() if kind.fullmatch(k) and isinstance(v, list)]
    return next((line[0].strip() for line in lines if len(line) == 1 and line[0].strip()), "")


def _two_axes(array: ArrayLike) -> ArrayLike | None:
    """Return real numbers with at most two axes, those of length one left out of more."""
    if array.dtype.kind not in "iufb":
        return None
    shape = tuple(n for n in array.shape if n != 1)
    if len(array.shape) <= 2:
        return array
    if len(shape) > 2 or math.prod(shape) > 1 << 28:
        return None
    return np.asarray(array[...]).reshape(shape)


def keep_distinct(called: dict[str, tuple[str, str]]) -> None:
    """Put where it stands before a label that several arrays have."""
    labels = [label for label, _ in called.values()]
    for name, (label, unit) in called.items():
        if label and labels.count(label) > 1:
            called[name] = (f"{name}: {label}", unit)


@final
@dataclass(frozen=True, slots=True)
class Stored:
    """A variable of an open HDF5 file; a part that cannot be read is an error that names it.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    name : str
        Where it stands.
    item : h5py.Dataset
        The variable.
    scale, offset : float
        What makes values of its numbers, by the conventions of netCDF.
    fill : float, optional
        Stands where nothing was written.
    """

    run: str
    name: str
    item: Any
    scale: float = 1.0
    offset: float = 0.0
    fill: float | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Length along every axis."""
        return tuple(self.item.shape)

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a number."""
        plain = (self.scale, self.offset, self.fill) == (1.0, 0.0, None)
        kind: np.dtype[Any] = self.item.dtype if plain else np.dtype(np.float64)
        return kind

    def __getitem__(self, key: Any, /) -> Any:
        with foreign(self.run, f"reading variable {shown(self.name)}"):
            raw = self.item[key]
        if self.dtype == self.item.dtype and self.fill is None:
            return raw
        values = raw * self.scale + self.offset
        return values if self.fill is None else np.where(raw == self.fill, np.nan, values)


def is_readable(item: Any) -> bool:
    """Return whether a dataset lies in this file, in pieces that fit into memory."""
    if item.shape is None or item.is_virtual or item.external:
        return False
    chunk = math.prod(item.chunks) if item.chunks else 0
    width = int(item.dtype.itemsize)
    stored = int(item.id.get_storage_size())
    return chunk * width <= _LARGEST_CHUNK and math.prod(item.shape) * width <= _PACKED * stored


def check_kind(kind: Any, run: str, what: str) -> None:
    """Pass numbers of a type that processors have, which HDF5 need not convert.

    A damaged header says another exponent, say.

    Parameters
    ----------
    kind : h5py.h5d.DatasetID or h5py.h5a.AttrID
        What the numbers belong to.
    run : str
        Name of the run, for messages.
    what : str
        What it is, for messages.

    Raises
    ------
    RecordingError
        If they are of no such type.
    """
    import h5py

    if h5py.h5t.py_create(kind.dtype) != kind.get_type():
        raise RecordingError(
            f"{run}: {what} is stored as numbers of a kind that no program writes, which is "
            f"damage. {AGAIN}"
        )


def check_variable(item: Any, run: str, name: str) -> None:
    """Pass a data set whose numbers agree with its header.

    Raises
    ------
    RecordingError
        If they are of no type of a processor, or others are stored than it says.
    """
    check_kind(item.id, run, f"variable {shown(name)}")
    size, stored = item.size * item.dtype.itemsize, int(item.id.get_storage_size())
    if not item.chunks and size != stored:
        raise RecordingError(
            f"{run}: variable {shown(name)} says it holds {size} bytes, but {stored} are "
            f"stored. {AGAIN}"
        )
