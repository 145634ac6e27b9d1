"""Read ASAM ODS ATFX (.atfx): measured channels of the submatrices of a measurement.

The file is XML: an application model that says which of its elements are which of the base
model, then their instances. Samples stand in it as text, or in binary files beside it, of which
a slice is read at a time.

References
----------
.. [1] ASAM e.V., "ASAM ODS 6.0: base model, and ATF/XML transport format", 2018.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from operator import itemgetter
from pathlib import Path, PurePosixPath
from typing import Any, Final, TypeAlias, final
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import ArrayLike, LinesSource, Row
from shakerproc.recordings.frames import Frames
from shakerproc.recordings.guard import AGAIN, foreign, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup
from shakerproc.recordings.time_axis import TimeAxis
from shakerproc.recordings.time_base import CLOCKS

LARGEST: Final = 1 << 28
"""Bytes of XML that are taken apart in memory; a number of 8 bytes is some 20 letters of it."""

_STORED: Final = {
    "dt_byte": "u1", "dt_sbyte": "i1", "dt_short": "<i2", "dt_ushort": "<u2", "dt_long": "<i4",
    "dt_ulong": "<u4", "dt_longlong": "<i8", "ieeefloat4": "<f4", "ieeefloat8": "<f8",
    "dt_short_beo": ">i2", "dt_ushort_beo": ">u2", "dt_long_beo": ">i4", "dt_ulong_beo": ">u4",
    "dt_longlong_beo": ">i8", "ieeefloat4_beo": ">f4", "ieeefloat8_beo": ">f8",
}  # fmt: skip
"""Numbers of binary files by their name in the standard (typespec_enum)."""

_WRITTEN: Final = {f"A_{sign}INT{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)}
_NUMBERS: Final = dict.fromkeys(_WRITTEN, "f8") | {"A_FLOAT32": "f4", "A_FLOAT64": "f8"}
"""Numbers that are written out in the XML."""

_EXPLICIT: Final = {"", "0", "explicit", "7", "external_component"}
_LINEAR: Final = {
    "4": 2, "raw_linear": 2, "8": 2, "raw_linear_external": 2,
    "10": 3, "raw_linear_calibrated": 3, "11": 3, "raw_linear_calibrated_external": 3,
}  # fmt: skip
"""How values follow from raw numbers r: (p1 + p2 r) p3, by how many parameters there are."""

_IMPLICIT: Final = {"2", "implicit_linear"}
_VALID: Final = 0b1001
"""Flags of a sample that is valid and defined."""

_DATE: Final = re.compile(r"(\d{4})(\d\d)(\d\d)(\d\d)?(\d\d)?(\d\d)?(\d{1,9})?")

_Instance: TypeAlias = Mapping[str, ElementTree.Element]
"""Attributes and relations of an instance, by their name in the base model."""


def read_atfx(path: Path, run: str) -> RawFile:
    """Return the channels of an ATFX file, those of one rate as a group.

    Raises
    ------
    RecordingError
        If it is none, is damaged, or holds no measured channels.
    """
    if path.stat().st_size > LARGEST:
        raise RecordingError(
            f"{run}: more than {LARGEST >> 20} MB of XML. Export the samples to a binary file "
            "beside it, or as MDF 4."
        )
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314 - expat bounds entities
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise RecordingError(f"{run}: is no whole XML: {shown(error)}. {AGAIN}") from error
    if _plain(root.tag) != "atfx_file":
        raise RecordingError(f"{run}: is XML, but no ATFX: it begins with {shown(root.tag)}.")
    with ExitStack() as opened, foreign(run, "reading the channels"):
        raw = _File(path, run, root, opened).described()
        return replace(raw, source=replace(raw.source, handle=opened.pop_all()))


def _plain(tag: str) -> str:
    """Return the name of an element without its name space."""
    return tag.rpartition("}")[2]


def _text(item: ElementTree.Element | None) -> str:
    return "" if item is None or item.text is None else item.text.strip()


def _children(item: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    return [one for one in item if _plain(one.tag) == name]


def _said(item: ElementTree.Element, name: str) -> str:
    """Return the text of the first child of a name; empty where there is none."""
    return next((_text(one) for one in _children(item, name)), "")


@final
@dataclass(frozen=True, slots=True, eq=False)
class Flagged:
    """Samples with a flag each; NaN where it says that the sample is not valid."""

    values: ArrayLike
    flags: ArrayLike

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of samples."""
        return (min(self.values.shape[0], self.flags.shape[0]),)

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a number."""
        return np.dtype(np.float64)

    def __getitem__(self, key: Any, /) -> Any:
        return np.where(self.flags[key] & _VALID == _VALID, self.values[key], np.nan)


@final
@dataclass(frozen=True, slots=True, eq=False)
class ColumnTimes:
    """Times that stand in a column, read a piece at a time."""

    values: ArrayLike

    @property
    def size(self) -> int:
        """How many there are."""
        return self.values.shape[0]

    def __getitem__(self, key: slice, /) -> Any:
        return np.asarray(self.values[key], dtype=np.float64)


@final
@dataclass(slots=True, eq=False)
class _Group:
    """Channels of one step [s] of one measurement."""

    measurement: int
    step: float
    name: str
    channels: list[RawChannel] = field(default_factory=list)


@final
class _File:
    """An ATFX file that is being read: its instances, and the files beside it."""

    def __init__(
        self, path: Path, run: str, root: ElementTree.Element, opened: ExitStack
    ) -> None:
        self.path, self.run, self.opened = path, run, opened
        self.files = {
            _said(one, "identifier"): _said(one, "filename")
            for part in _children(root, "files")
            for one in _children(part, "component")
        }
        self.lines: list[Row] = []
        self.used: set[str] = set()
        self.notes: list[str] = []
        self.instances: dict[str, dict[str, _Instance]] = {}
        bases, names = _model(root)
        for item in (one for part in _children(root, "instance_data") for one in part):
            kind = _plain(item.tag)
            if kind in bases:
                found = {names[kind].get(_plain(one.tag), ""): one for one in item}
                at = self.instances.setdefault(bases[kind], {})
                at[_text(found.get("id"))] = found

    def described(self) -> RawFile:
        """Return the channels and times of the file.

        Raises
        ------
        RecordingError
            If there are none that can be served.
        """
        groups: list[_Group] = []
        for about in self.instances.get("aosubmatrix", {}).values():
            _join(groups, self._group(about))
        channels = [channel for group in groups for channel in group.channels]
        if not self.lines:
            why = f": {channels[0].problem}" if channels else ""
            raise RecordingError(f"{self.run}: no measured channel in it{why}. {AGAIN}")
        self.notes += [
            f"Samples stand in {shown(name)} beside it, which the SHA-256 of the recording "
            "does not cover."
            for name in sorted(self.used)
        ]
        made = [
            RawGroup(group.name if len(groups) > 1 else "", tuple(group.channels))
            for group in groups
        ]
        return RawFile(tuple(made), LinesSource(self.run, tuple(self.lines)), tuple(self.notes))

    def _group(self, about: _Instance) -> _Group:
        """Return the columns of a submatrix, with the one that all others depend on as axis."""
        rows = int(_text(about.get("number_of_rows")) or -1)
        name = shown(_text(about.get("name")), 40)
        measurement = self._one("aomeasurement", about, "measurement", "submatrices")
        begin = _text(measurement.get("measurement_begin"))
        start = _date(begin)
        if not measurement:
            self._note(f"Submatrix {name} belongs to no measurement: its start is unknown.")
        if begin and start is None:
            self._note(f"Its start is {shown(begin, 40)}, no date: it is not used.")
        columns = list(self._columns(about))
        free = [one for one in columns if _text(one.get("independent")) in {"1", "true"}]
        axes: tuple[TimeAxis, ...] = ()
        step = 0.0
        if len(free) == 1:
            axis, step = self._axis(free[0])
            axes = (axis,)
        group = _Group(id(measurement), step, _text(about.get("name")))
        for column in columns:
            if any(column is one for one in free):
                continue
            made = self._channel(column, rows)
            many = "it depends on several axes, not on time alone" if len(free) > 1 else ""
            made = replace(made, axes=axes, start_time=start, problem=many or made.problem)
            group.channels.append(replace(made, row=-1) if made.problem else made)
        return group

    def _columns(self, about: _Instance) -> Iterator[_Instance]:
        """Yield the columns of a submatrix: those that it names, or that name it."""
        every = self.instances.get("aolocalcolumn", {})
        named = _text(about.get("local_columns")).split()
        name = _text(about.get("id"))
        for number, column in every.items():
            if number in named or name in _text(column.get("submatrix")).split():
                yield column

    def _one(self, base: str, of: _Instance, relation: str, inverse: str) -> _Instance:
        """Return the instance that another is related to; an empty one where there is none."""
        every, name = self.instances.get(base, {}), _text(of.get("id"))
        wanted = _text(of.get(relation)).split()
        if not wanted:
            found = every.items()
            wanted = [at for at, one in found if name in _text(one.get(inverse)).split()]
        if wanted and wanted[0] not in every:
            self._note(f"It refers to {base} {shown(wanted[0], 20)}, which is not in it.")
        return every.get(wanted[0], {}) if wanted else {}

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def _called(self, column: _Instance) -> tuple[str, str, str]:
        """Return name, unit and quantity of a column."""
        about = self._one(
            "aomeasurementquantity", column, "measurement_quantity", "local_columns"
        )
        unit = self._one("aounit", about, "unit", "measurement_quantities")
        quantity = self._one("aoquantity", about, "quantity", "measurement_quantities")
        name = _text(about.get("name")) or _text(column.get("name"))
        return name, _text(unit.get("name")), _text(quantity.get("name"))

    def _axis(self, column: _Instance) -> tuple[TimeAxis, float]:
        """Return the time axis of a submatrix as stated, and its mean step in its unit."""
        name, unit, quantity = self._called(column)
        axis = TimeAxis(f"column {shown(name, 40)}", unit=unit, quantity=quantity, name=name)
        try:
            if _text(column.get("sequence_representation")) in _IMPLICIT:
                start, step = _parameters(column, 2)
                return replace(axis, step=step, start=start), step
            times = ColumnTimes(self._values(column))
        except ValueError as error:
            return replace(axis, problem=f"{axis.where} cannot be read: {error}"), 0.0
        if times.size < 2:
            return replace(axis, times=times), 0.0
        mean = float(times[times.size - 1 :][0] - times[:1][0]) / (times.size - 1)
        return replace(axis, times=times), mean

    def _channel(self, column: _Instance, rows: int) -> RawChannel:
        """Return a column of so many rows, without its times."""
        name, unit, _ = self._called(column)
        try:
            values = self._values(column)
        except ValueError as error:
            return RawChannel(name, -1, 0, max(rows, 1), unit, problem=str(error))
        self.lines.append(Row(values, None, upright=True))
        there = values.shape[0]
        n_samples = there if rows < 0 else min(there, rows)
        return RawChannel(name, len(self.lines) - 1, n_samples, max(rows, there), unit)

    def _values(self, column: _Instance) -> ArrayLike:
        """Return the values of a column.

        Raises
        ------
        ValueError
            If they cannot be read, with the reason.
        """
        kind = _text(column.get("sequence_representation"))
        if kind not in _EXPLICIT and kind not in _LINEAR:
            raise ValueError(f"its values are of the kind {shown(kind, 40)}, which is not read")
        decoded = _scaling(column, _LINEAR[kind]) if kind in _LINEAR else None
        values, flags = self._numbers(column, "values", decoded), None
        if values is None:
            values, flags = self._of_component(column, decoded)
        flags = flags or self._numbers(column, "flags", None)
        if flags is not None:
            return Flagged(values, flags)
        known = _text(column.get("global_flag"))
        if known and int(known) & _VALID != _VALID:
            raise ValueError("the file says that its values are not valid")
        return values

    def _numbers(self, column: _Instance, which: str, decoded: Any) -> ArrayLike | None:
        """Return the values or the flags that a column itself has; None where it has none.

        Raises
        ------
        ValueError
            If they cannot be read.
        """
        item = column.get(which)
        for one in () if item is None else item:
            if _plain(one.tag) == "component":
                about = {_plain(part.tag): _text(part) for part in one}
                name = self.files.get(about.get("identifier", ""), "")
                return self._stored(name, about, decoded)
            if _plain(one.tag) not in _NUMBERS:
                raise ValueError("it holds text, not numbers")
            return _written(_text(one), _NUMBERS[_plain(one.tag)], decoded)
        return _written(_text(item), "i8", None) if _text(item) else None

    def _of_component(
        self, column: _Instance, decoded: Any
    ) -> tuple[ArrayLike, ArrayLike | None]:
        """Return values and flags of a column that the component of another instance holds.

        Raises
        ------
        ValueError
            If there is not one of it, or they cannot be read.
        """
        names = _text(column.get("external_component")).split()
        if len(names) != 1:
            raise ValueError(f"its values stand in {len(names)} places, not in one")
        found = self.instances.get("aoexternalcomponent", {}).get(names[0], {})
        said = {_ALIKE.get(base, base): _text(part) for base, part in found.items()}
        values = self._stored(said.get("filename_url", ""), said, decoded)
        if not said.get("flags_filename_url"):
            return values, None
        flags = {
            "datatype": "dt_short", "length": said.get("length", ""),
            "inioffset": said.get("flags_start_offset", ""),
        }  # fmt: skip
        return values, self._stored(said["flags_filename_url"], flags, None)

    def _stored(self, name: str, about: Mapping[str, str], decoded: Any) -> Frames:
        """Return numbers of a binary file beside the XML.

        Raises
        ------
        ValueError
            If they cannot be read.
        """
        plain = PurePosixPath(name.replace("\\", "/"))
        where = self.path.parent / plain
        if not name or ":" in name or plain.is_absolute() or ".." in plain.parts:
            raise ValueError(f"its values stand in {shown(name, 60)}, not beside the file")
        if not where.is_file():
            raise ValueError(f"its values stand in {shown(name, 60)}, which is not there")
        kind = about.get("datatype", "").casefold()
        if kind not in _STORED:
            raise ValueError(f"its numbers are {shown(kind, 30)}, which is not read")
        dtype = np.dtype(_STORED[kind])
        length, first, offset = (
            int(about.get(key) or 0) for key in ("length", "inioffset", "valoffsets")
        )
        per_block = int(about.get("valperblock") or 1)
        size = int(about.get("blocksize") or dtype.itemsize)
        if per_block > 1 and size == per_block * dtype.itemsize:
            per_block, size = 1, dtype.itemsize  # one after the other
        if per_block != 1 or min(length, first, offset) < 0 or size < offset + dtype.itemsize:
            raise ValueError(
                f"its {length} values, {per_block} in a block of {size} bytes, are not read"
            )
        at = first + offset
        offset = min(at, size - dtype.itemsize)  # so that a block ends with its value
        block = np.dtype({
            "names": ["v"],
            "formats": [dtype],
            "offsets": [offset],
            "itemsize": size,
        })
        self.used.add(name)
        there = max(0, where.stat().st_size - (at - offset)) // size
        take = itemgetter("v")
        return Frames(
            self.run, self.opened.enter_context(where.open("rb")), at - offset,
            (min(length, there),), block,
            take if decoded is None else lambda raw: decoded(take(raw)),
            dtype if decoded is None else np.dtype(np.float64),
        )  # fmt: skip


_ALIKE: Final = {
    "value_type": "datatype", "component_length": "length", "start_offset": "inioffset",
    "block_size": "blocksize", "valuesperblock": "valperblock", "value_offset": "valoffsets",
}  # fmt: skip
"""What an instance of AoExternalComponent calls what the XML of values calls otherwise."""


def _model(
    root: ElementTree.Element,
) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Return which base element each element is, and which base attribute each of its own."""
    bases: dict[str, str] = {}
    names: dict[str, dict[str, str]] = {}
    for part in _children(root, "application_model"):
        for one in _children(part, "application_element"):
            kind = _said(one, "name")
            bases[kind] = _said(one, "basetype").casefold()
            own = [*_children(one, "application_attribute"),
                   *_children(one, "relation_attribute")]  # fmt: skip
            names[kind] = {
                _said(a, "name"): _said(a, "base_attribute") or _said(a, "base_relation")
                for a in own
            }
    return bases, names


def _join(groups: list[_Group], made: _Group) -> None:
    """Add channels to the group that has their step, or as a group of its own.

    Submatrices with channels of one name follow each other, or are of several runs.
    """
    names = {channel.name for channel in made.channels}
    for group in groups:
        alike = group.step and abs(made.step / group.step - 1.0) <= CLOCKS
        apart = names.isdisjoint(channel.name for channel in group.channels)
        if alike and apart and group.measurement == made.measurement:
            group.channels.extend(made.channels)
            return
    if made.channels:
        taken = made.name in {group.name for group in groups}
        made.name = f"{made.name} ({len(groups) + 1})" if taken else made.name
        groups.append(made)


def _parameters(column: _Instance, count: int) -> list[float]:
    """Return the numbers by which the values of a column follow from others.

    Raises
    ------
    ValueError
        If there are others than so many.
    """
    item = column.get("generation_parameters")
    inner = [] if item is None else [_text(one) for one in item]
    found = [float(word) for word in " ".join([_text(item), *inner]).split()]
    if len(found) != count:
        raise ValueError(f"{len(found)} generation parameters where {count} belong")
    return found


def _scaling(column: _Instance, count: int | None) -> Any:
    """Return the function from raw numbers to values; None where they are the values."""
    if count is None:
        return None
    offset, factor, *calibration = _parameters(column, count)
    (last,) = calibration or (1.0,)
    return lambda raw: (offset + factor * raw.astype(np.float64)) * last


def _written(text: str, kind: str, decoded: Any) -> NDArray[Any]:
    """Return numbers that are written out."""
    values = np.array(text.split(), dtype=np.float64).astype(kind)
    return values if decoded is None else np.asarray(decoded(values))


def _date(text: str) -> datetime | None:
    """Return a date, such as 20051202103115000; the standard knows no zones: UTC is taken."""
    match = _DATE.fullmatch(text)
    if match is None:
        return None
    *whole, fraction = match.groups()
    try:
        date = datetime(*(int(one or 0) for one in whole), tzinfo=UTC)  # type: ignore[arg-type, misc]
    except ValueError:
        return None
    return date.replace(microsecond=int(f"{fraction or 0:0<6}"[:6]))
