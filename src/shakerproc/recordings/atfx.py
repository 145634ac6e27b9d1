"""Read ASAM ODS ATFX (.atfx): measured channels of the submatrices of a measurement.

The file is XML: an application model that says which of its elements are which of the base
model, then their instances. Samples stand in it as text, or in binary files beside it, of which
a slice is read at a time.

References
----------
.. [1] ASAM e.V., "ASAM ODS 6.0: base model, and ATF/XML transport format", 2018.
"""

import re
from collections.abc import Mapping
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
from shakerproc.recordings.arrays import ArrayLike, ArrayRow, LinesSource
from shakerproc.recordings.guard import AGAIN, foreign, kept_open, shown
from shakerproc.recordings.raw import Frames, RawChannel, RawFile, RawGroup, TimeAxis
from shakerproc.recordings.time_base import CLOCKS

LARGEST: Final = 1 << 28
"""Bytes of XML that are taken apart in memory; a number of 8 bytes is some 20 letters of it."""

_WIDE: Final = {
    "dt_short": "i2", "dt_ushort": "u2", "dt_long": "i4", "dt_ulong": "u4", "dt_longlong": "i8",
    "ieeefloat4": "f4", "ieeefloat8": "f8",
}  # fmt: skip
_STORED: Final = (
    {"dt_byte": "u1", "dt_sbyte": "i1"}
    | {name: f"<{kind}" for name, kind in _WIDE.items()}
    | {f"{name}_beo": f">{kind}" for name, kind in _WIDE.items()}
)
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

_ALIKE: Final = {
    "value_type": "datatype", "component_length": "length", "start_offset": "inioffset",
    "block_size": "blocksize", "valuesperblock": "valperblock", "value_offset": "valoffsets",
}  # fmt: skip
"""What an instance of AoExternalComponent calls what the XML of values calls otherwise."""

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
    for item in root.iter():
        item.tag = str(item.tag).rpartition("}")[2]  # without its name space
    if root.tag != "atfx_file":
        raise RecordingError(f"{run}: is XML, but no ATFX: it begins with {shown(root.tag)}.")
    with foreign(run, "reading the channels"):
        return kept_open(ExitStack(), lambda opened: _File(path, run, root, opened).described())


def _text(instance: _Instance, name: str) -> str:
    """Return the text of an attribute; empty where an instance has none."""
    item = instance.get(name)
    return "" if item is None else (item.text or "").strip()


@final
@dataclass(frozen=True, slots=True, eq=False)
class Flagged:
    """Samples with a flag each; NaN where it says that the sample is not valid."""

    values: ArrayLike
    flags: ArrayLike

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of samples."""
        return (self.size,)

    @property
    def size(self) -> int:
        """Number of samples."""
        return min(self.values.shape[0], self.flags.shape[0])

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a number."""
        return np.dtype(np.float64)

    def __getitem__(self, key: Any, /) -> Any:
        return np.where(self.flags[key] & _VALID == _VALID, self.values[key], np.nan)


_Column: TypeAlias = Flagged | Frames | NDArray[Any]


@final
@dataclass(slots=True, eq=False)
class _AtfxGroup:
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
        listed = root.findall("files/component")
        self.files = {
            one.findtext("identifier", "").strip(): one.findtext("filename", "").strip()
            for one in listed
        }
        self.lines: list[ArrayRow] = []
        self.used: set[str] = set()
        self.notes: dict[str, None] = {}
        self.instances: dict[str, dict[str, _Instance]] = {}
        model = _model(root)
        for item in root.iterfind("instance_data/*"):
            base, names = model.get(item.tag, ("", {}))
            items = {names.get(one.tag, ""): one for one in item}
            self.instances.setdefault(base, {})[_text(items, "id")] = items

    def described(self) -> RawFile:
        """Return the channels and times of the file.

        Raises
        ------
        RecordingError
            If there are none that can be served.
        """
        groups: list[_AtfxGroup] = []
        for about in self.instances.get("aosubmatrix", {}).values():
            _join(groups, self._group(about))
        if not self.lines:
            why = "".join(f": {c.problem}" for group in groups for c in group.channels[:1])
            raise RecordingError(f"{self.run}: no measured channel in it{why}. {AGAIN}")
        for name in sorted(self.used):
            self.notes[
                f"Samples stand in {shown(name)} beside it, which the SHA-256 of the recording "
                "does not cover."
            ] = None
        made = [
            RawGroup(group.name if len(groups) > 1 else "", tuple(group.channels))
            for group in groups
        ]
        return RawFile(
            tuple(made),
            LinesSource(self.run, tuple(self.lines), self.opened),
            tuple(self.notes),
        )

    def _group(self, about: _Instance) -> _AtfxGroup:
        """Return the columns of a submatrix, with the one that all others depend on as axis."""
        name, measurement = _text(about, "name"), self._one(about, *_MEASUREMENT)
        begin = _text(measurement, "measurement_begin")
        start = _date(begin)
        if not measurement:
            text = (
                f"Submatrix {shown(name, 40)} belongs to no measurement: its start is unknown."
            )
            self.notes[text] = None
        if begin and start is None:
            self.notes[f"Its start is {shown(begin, 40)}, no date: it is not used."] = None
        named = _text(about, "local_columns").split()
        columns = [
            column
            for number, column in self.instances.get("aolocalcolumn", {}).items()
            if number in named or _text(about, "id") in _text(column, "submatrix").split()
        ]
        free = [one for one in columns if _text(one, "independent") in {"1", "true"}]
        axes, step = self._axis(free[0]) if len(free) == 1 else ((), 0.0)
        group = _AtfxGroup(id(measurement), step, name)
        for column in (one for one in columns if not any(one is other for other in free)):
            made = self._channel(column, int(_text(about, "number_of_rows") or -1))
            if len(free) > 1:
                made = replace(made, problem="it depends on several axes, not on time alone")
            row = -1 if made.problem else made.row
            group.channels.append(replace(made, row=row, axes=axes, start_time=start))
        return group

    def _one(self, of: _Instance, base: str, relation: str, inverse: str) -> _Instance:
        """Return the instance that another is related to; an empty one where there is none."""
        every, name = self.instances.get(base, {}), _text(of, "id")
        wanted = _text(of, relation).split() or [
            at for at, one in every.items() if name in _text(one, inverse).split()
        ]
        if wanted and wanted[0] not in every:
            text = f"It refers to {base} {shown(wanted[0], 20)}, which is not in it."
            self.notes[text] = None
        return every.get(wanted[0], {}) if wanted else {}

    def _called(self, column: _Instance) -> tuple[str, str, str]:
        """Return name, unit and quantity of a column."""
        about = self._one(column, *_QUANTITY)
        unit, quantity = (self._one(about, *which) for which in (_UNIT, _DIMENSION))
        name = _text(about, "name") or _text(column, "name")
        return name, _text(unit, "name"), _text(quantity, "name")

    def _axis(self, column: _Instance) -> tuple[tuple[TimeAxis], float]:
        """Return the time axis of a submatrix as stated, and its mean step in its unit."""
        name, unit, quantity = self._called(column)
        axis = TimeAxis(f"column {shown(name, 40)}", unit=unit, quantity=quantity, name=name)
        try:
            if _text(column, "sequence_representation") in _IMPLICIT:
                start, step = _parameters(column, 2)
                return (replace(axis, step=step, start=start),), step
            times = self._values(column)
        except ValueError as error:
            return (replace(axis, problem=f"{axis.where} cannot be read: {error}"),), 0.0
        ends = [float(times[at : at + 1][0]) for at in (0, times.size - 1) if times.size > 1]
        step = (ends[1] - ends[0]) / (times.size - 1) if ends else 0.0
        return (replace(axis, times=times),), step

    def _channel(self, column: _Instance, rows: int) -> RawChannel:
        """Return a column of so many rows, without its times."""
        name, unit, _ = self._called(column)
        try:
            values = self._values(column)
        except ValueError as error:
            return RawChannel(name, -1, 0, max(rows, 1), unit, problem=str(error))
        self.lines.append(ArrayRow(values, None, upright=True))
        there = values.size if rows < 0 else min(values.size, rows)
        return RawChannel(name, len(self.lines) - 1, there, max(rows, values.size), unit)

    def _values(self, column: _Instance) -> _Column:
        """Return the values of a column.

        Raises
        ------
        ValueError
            If they cannot be read, with the reason.
        """
        kind = _text(column, "sequence_representation")
        if kind not in _EXPLICIT and kind not in _LINEAR:
            raise ValueError(f"its values are of the kind {shown(kind, 40)}, which is not read")
        decoded = _scaling(column, _LINEAR[kind]) if kind in _LINEAR else None
        values = self._numbers(column, "values", decoded)
        if values is None:
            values = self._of_component(column, decoded)
        flags = self._numbers(column, "flags", None)
        if flags is not None:
            return Flagged(values, flags)
        known = _text(column, "global_flag")
        if known and int(known) & _VALID != _VALID:
            raise ValueError("the file says that its values are not valid")
        return values

    def _numbers(
        self, column: _Instance, which: str, decoded: Any
    ) -> Frames | NDArray[Any] | None:
        """Return the values or the flags that a column itself has; None where it has none.

        Raises
        ------
        ValueError
            If they cannot be read.
        """
        for one in column.get(which, ()):
            if one.tag == "component":
                about = {part.tag: (part.text or "").strip() for part in one}
                name = self.files.get(about.get("identifier", ""), "")
                return self._stored(name, about, decoded)
            if one.tag not in _NUMBERS:
                raise ValueError("it holds text, not numbers")
            return _written(one.text or "", _NUMBERS[one.tag], decoded)
        plain = _text(column, which)
        return _written(plain, "i8", None) if plain else None

    def _of_component(self, column: _Instance, decoded: Any) -> Frames:
        """Return the values of a column that the component of another instance holds.

        Raises
        ------
        ValueError
            If there is not one of it, or they cannot be read.
        """
        names = _text(column, "external_component").split()
        if len(names) != 1:
            raise ValueError(f"its values stand in {len(names)} places, not in one")
        component = self.instances.get("aoexternalcomponent", {}).get(names[0], {})
        if _text(component, "flags_filename_url"):
            raise ValueError("its flags stand in a file of their own, which is not read")
        about = {_ALIKE.get(base, base): _text(component, base) for base in component}
        return self._stored(_text(component, "filename_url"), about, decoded)

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


_MEASUREMENT: Final = "aomeasurement", "measurement", "submatrices"
_QUANTITY: Final = "aomeasurementquantity", "measurement_quantity", "local_columns"
_UNIT: Final = "aounit", "unit", "measurement_quantities"
_DIMENSION: Final = "aoquantity", "quantity", "measurement_quantities"
"""Base element, relation to it, and the relation back from it."""


def _model(root: ElementTree.Element) -> dict[str, tuple[str, dict[str, str]]]:
    """Return the base element of each element, and the base attributes of its own by name."""
    return {
        one.findtext("name", ""): (
            one.findtext("basetype", "").casefold(),
            {
                own.findtext("name", ""): own.findtext("base_attribute", "")
                or own.findtext("base_relation", "")
                for own in one
                if own.tag in {"application_attribute", "relation_attribute"}
            },
        )
        for one in root.iterfind("application_model/application_element")
    }


def _join(groups: list[_AtfxGroup], made: _AtfxGroup) -> None:
    """Add channels to the group that has their step, or as a group of its own.

    Submatrices with channels of one name follow each other, or are of several runs.
    """
    names = {channel.name for channel in made.channels}
    for group in groups:
        same_step = group.step and abs(made.step / group.step - 1.0) <= CLOCKS
        distinct = names.isdisjoint(channel.name for channel in group.channels)
        if same_step and distinct and group.measurement == made.measurement:
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
    values = [float(word) for word in "".join(() if item is None else item.itertext()).split()]
    if len(values) != count:
        raise ValueError(f"{len(values)} generation parameters where {count} belong")
    return values


def _scaling(column: _Instance, count: int) -> Any:
    """Return the function from raw numbers to values."""
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
