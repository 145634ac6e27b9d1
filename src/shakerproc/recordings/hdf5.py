"""Read HDF5 and netCDF-4: data sets of a group are channels, attributes say rate, unit, start.

A group that holds but one data set of values, such as ``ch1/data``, is a channel of the group
above it. Time data of Rattlesnake are known by their channel table.

References
----------
.. [1] B. Eaton et al., "NetCDF Climate and Forecast (CF) metadata conventions 1.11", 2023
   (units, scale_factor, add_offset, seconds since a date).
.. [2] Sandia National Laboratories, "Rattlesnake vibration controller", user's guide, 2024
   (appendix on the output of the streaming process).
"""

import math
import re
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import ArrayRow, LinesSource, file_of_arrays
from shakerproc.recordings.columns import RATE_WORD, STEP_WORD
from shakerproc.recordings.guard import first_bytes, foreign, kept_open, shown
from shakerproc.recordings.raw import RawFile, RawGroup
from shakerproc.recordings.times import SECONDS, is_time, iso_date
from shakerproc.recordings.variables import (
    DEEPEST,
    LABEL,
    UNIT,
    VALUES,
    Stored,
    Variables,
    check_kind,
    check_variable,
    is_readable,
    keep_distinct,
)

_NETCDF_3: Final = (b"CDF\x01", b"CDF\x02", b"CDF\x05")
_NO_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable"
_OF_LIBRARIES: Final = frozenset({
    "CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "DIMENSION_LABELS", "_FillValue",
    "_Netcdf4Dimid", "_Netcdf4Coordinates", "_NCProperties", "_nc3_strict",
})  # fmt: skip
_START: Final = re.compile(
    r"(?:wf_)?(?:start|begin|trigger|record(?:ing)?|acquisition)?_?(?:date_?time|date|time|"
    r"time_?stamp)|start|t0|x0",
    re.IGNORECASE,
)
_SINCE: Final = re.compile(r"(?P<unit>\w+)\s+since\s+(?P<date>.+)", re.IGNORECASE)
_MOST_TEXTS: Final = 10_000
_LONGEST_S: Final = 5.0
"""What a process may compute while it walks over a file [s]: 10,000 data sets take one."""

_EPOCH: Final = (946_684_800.0, 3_029_529_600.0)
"""Seconds since 1970 that are a date between 2000 and 2066."""


@final
@dataclass(slots=True, eq=False)
class _Hdf5Group:
    """A group of a file: its variables, and when their time 0 is."""

    run: str
    name: str
    variables: Variables = field(default_factory=Variables)
    starts: dict[str, datetime] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def read_hdf5(path: Path, run: str) -> RawFile:
    """Return the data sets of an HDF5 or netCDF-4 file as channels, by group.

    Raises
    ------
    RecordingError
        If it cannot be read, or holds no time series.
    """
    if first_bytes(path, run, 4) in _NETCDF_3:
        raise RecordingError(
            f"{run}: is netCDF of version 3, not 4. Convert it: nccopy -k nc4 {run} new.nc."
        )
    with foreign(run, "reading the data sets"):
        return kept_open(opened_hdf5(path, run), lambda file: _read(file, run))


def _read(file: Any, run: str) -> RawFile:
    with short_walk():
        groups = _of_rattlesnake(file, run) or list(_groups(file, run))
    return _joined(groups, run, file)


@contextmanager
def short_walk() -> Iterator[None]:
    """End this process, which is one of its own, where a walk over a file never comes back.

    HDF5 does not from some damaged texts. A signal ends it, where there is one for what a
    process has computed.
    """
    limits = hasattr(signal, "setitimer")
    if limits:
        signal.setitimer(signal.ITIMER_PROF, _LONGEST_S)
    try:
        yield
    finally:
        if limits:
            signal.setitimer(signal.ITIMER_PROF, 0.0)


def opened_hdf5(path: Path, run: str) -> Any:
    """Return an open file.

    Raises
    ------
    RecordingError
        If it cannot be opened.
    """
    import h5py

    with foreign(run, "opening the file"):
        return h5py.File(path, "r")


def _joined(groups: list[_Hdf5Group], run: str, file: Any) -> RawFile:
    """Return groups of which at least one holds a time series as one file.

    Raises
    ------
    RecordingError
        If none does.
    """
    made: list[RawGroup] = []
    lines: list[ArrayRow] = []
    notes: list[str] = []
    problem: RecordingError | None = None
    for group in groups:
        keep_distinct(group.variables.called)
        try:
            raw = file_of_arrays(
                group.variables.arrays, group.variables.texts, run,
                called=group.variables.called, starts=group.starts,
                left_out=group.variables.left_out,
            )  # fmt: skip
        except RecordingError as error:
            problem = problem or error
            notes += [f"Group {shown(group.name)} holds no time series."] * bool(group.name)
            continue
        where = f"{group.name}: " if len(groups) > 1 and group.name else ""
        notes += [f"{where}{note}" for note in (*raw.notes, *group.notes)]
        shifted = [replace(c, row=c.row + len(lines)) for c in raw.groups[0].channels]
        made.append(RawGroup(group.name, tuple(shifted)))
        if isinstance(raw.source, LinesSource):
            lines += raw.source.lines
    if not made:
        raise problem or RecordingError(
            f"{run}: no time series in it. Save the channels as data sets of one length, with "
            "an attribute sample_rate or a data set time beside them."
        )
    return RawFile(tuple(made), LinesSource(run, tuple(lines), file), tuple(notes))


def _groups(file: Any, run: str) -> Iterator[_Hdf5Group]:
    """Yield the groups that hold data sets of numbers, that of the file first."""
    waiting: list[tuple[str, Any, Variables, dict[str, datetime], int]] = [
        ("", file, Variables(), {}, 0)
    ]
    while waiting:
        name, item, above, starts, depth = waiting.pop(0)
        group = _Hdf5Group(run, name, starts=dict(starts))
        group.variables.arrays |= above.arrays
        group.variables.texts |= above.texts
        _take_attributes(item, "", group)
        said = Variables(dict(group.variables.arrays), dict(group.variables.texts))
        own = dict(group.starts)
        for key, inner in _members(item):
            if not _is_group(inner):
                _take(inner, key, group)
            elif (values := _only_values(inner)) is None:
                within = f"{name}/{key}" if name else key
                if depth < DEEPEST:
                    waiting.append((within, inner, said, own, depth + 1))
            else:
                _take_channel(inner, key, values, group)
        if any(max(array.shape, default=0) > 1 for array in group.variables.arrays.values()):
            yield group
        elif group.variables.left_out:
            group.notes.append(
                f"Left out: {', '.join(map(shown, group.variables.left_out[:20]))}."
            )


def _members(group: Any) -> Iterator[tuple[str, Any]]:
    """Yield the members of a group, following no link out of it."""
    import h5py

    for key in group:
        if isinstance(group.get(key, getlink=True), h5py.HardLink):
            yield key, group[key]


def _is_group(item: Any) -> bool:
    import h5py

    return isinstance(item, h5py.Group)


def _only_values(group: Any) -> str | None:
    """Return the one data set of values in a group that is a channel; None of other groups."""
    members = dict(_members(group))
    others = [key for key in members if not is_time(key) and max(_shape(members[key])) > 1]
    plain = len(others) == 1 and VALUES.fullmatch(others[0])
    return others[0] if plain and not any(map(_is_group, members.values())) else None


def _shape(item: Any) -> tuple[int, ...]:
    return (0, *(getattr(item, "shape", None) or ()))


def _take_channel(item: Any, key: str, values: str, group: _Hdf5Group) -> None:
    """Take a group that is a channel: its values, their times and the attributes of both."""
    _take_attributes(item, key, group)
    for name, inner in _members(item):
        _take(inner, f"{key}.{name}", group)
    place = f"{key}.{values}"
    label, unit = group.variables.called.get(place, ("", ""))
    above = group.variables.called.pop(key, ("", ""))
    group.variables.called[place] = (label or above[0] or key, unit or above[1])


def _take(item: Any, name: str, group: _Hdf5Group) -> None:
    """Take a data set, or say that it is left out."""
    import h5py

    if not isinstance(item, h5py.Dataset):
        return
    if h5py.check_string_dtype(item.dtype) is not None and item.size is not None:
        if item.size <= _MOST_TEXTS and is_readable(item):
            group.variables.texts[name] = [_text(one) for one in np.ravel(item[...])]
        return
    about = _plain_name(item)
    if about.startswith(_NO_VARIABLE):
        return
    if item.dtype.kind not in "iuf" or not is_readable(item) or len(item.shape) > 2:
        if max(_shape(item)) > 1:
            group.variables.left_out.append(name)
        return
    check_variable(item, group.run, name)
    group.variables.arrays[name] = _stored(item, name, group.run)
    _take_attributes(item, name, group)


def _plain_name(item: Any) -> str:
    return _text(item.attrs["NAME"]) if "NAME" in item.attrs else ""


def _stored(item: Any, name: str, run: str) -> Stored:
    """Return a data set with the scale that its attributes say."""
    scale, offset = (_number(item.attrs.get(key)) for key in ("scale_factor", "add_offset"))
    fill = _number(item.attrs.get("_FillValue"))
    if fill is None and abs(float(item.fillvalue)) > 1e30:
        fill = float(item.fillvalue)
    return Stored(run, name, item, 1.0 if scale is None else scale, offset or 0.0, fill)


def _number(value: Any) -> float | None:
    """Return a single real number, or None."""
    array = np.asarray(value)
    if array.dtype.kind in "iuf" and array.size == 1:
        return float(array.reshape(-1)[0])
    try:
        return float(_text(value)) if value is not None and array.size == 1 else None
    except ValueError:
        return None


def _text(value: Any) -> str:
    """Return a text, whatever HDF5 has made of it."""
    one = np.asarray(value).reshape(-1)[0] if isinstance(value, np.ndarray) else value
    text = one.decode("utf-8", "replace") if isinstance(one, bytes) else str(one)
    return text.strip("\0 ")


def _take_attributes(item: Any, name: str, group: _Hdf5Group) -> None:
    """Take rate, unit, label and start from the attributes of a data set or a group."""
    import h5py

    label, unit = "", ""
    for key in (one for one in item.attrs if one not in _OF_LIBRARIES):
        kind = item.attrs.get_id(key)
        if kind.dtype.kind in "iuf":
            check_kind(kind, group.run, f"attribute {shown(key)}")
        value = item.attrs[key]
        if value is None or isinstance(value, h5py.Empty):
            continue
        place, number = (f"{name}.{key}" if name else key), _number(value)
        if isinstance(value, np.ndarray) and value.size > 1 and value.dtype.kind in "OSU":
            group.variables.texts[place] = [_text(one) for one in value.reshape(-1)]
        elif _START.fullmatch(re.sub(r"[\s_]+", "_", key.strip())):
            _take_start(name, place, value, number, group)
        elif number is not None:
            group.variables.arrays[_known(name, key)] = np.array(number)
        elif UNIT.fullmatch(key):
            unit = _unit(name, _text(value), group)
        elif LABEL.fullmatch(key):
            label = _text(value)
    if name and (label or unit):
        group.variables.called[name] = (label, unit)


def _known(name: str, key: str) -> str:
    """Return where a number of an attribute stands, as a rate or step where it is called so."""
    words = re.sub(r"[\s_]+", "_", key.strip())
    said = "sample_rate" if RATE_WORD.fullmatch(words) else key
    said = "time_step" if STEP_WORD.fullmatch(words) else said
    return f"{name}.{said}" if name else said


def _unit(name: str, text: str, group: _Hdf5Group) -> str:
    """Return a unit; that of times may say since when they count."""
    match = _SINCE.fullmatch(text)
    if match is None or match["unit"].casefold() not in SECONDS:
        return text
    date = iso_date(match["date"])
    if date is not None and is_time(name.rpartition(".")[2]):
        group.starts[name.rpartition(".")[0]] = date
    return match["unit"]


def _take_start(
    name: str, place: str, value: Any, number: float | None, group: _Hdf5Group
) -> None:
    """Take when a data set or a group begins, or say that it is not understood."""
    if number is not None and _EPOCH[0] <= number < _EPOCH[1]:
        date: datetime | None = datetime.fromtimestamp(0.0, UTC) + timedelta(seconds=number)
    else:
        date = None if number is not None else iso_date(_text(value))
    if date is not None:
        group.starts[name] = date
    elif number or number is None:
        group.notes.append(
            f"Attribute {shown(place)} is {shown(_text(value), 40)}, no date: it is not used."
        )


def _of_rattlesnake(file: Any, run: str) -> list[_Hdf5Group]:
    """Return the streams of a file of Rattlesnake, a group each; empty of other files.

    A channel is called after its node and direction, where these tell all of them apart.
    """
    import h5py

    table = file.get("channels")
    streams = [key for key in file if re.fullmatch(r"time_data(?:_\d+)?", key)]
    known = isinstance(table, h5py.Group) and {"unit", "node_number"} <= set(table)
    if not (streams and known and "sample_rate" in file.attrs):
        return []
    texts: Mapping[str, list[str]] = {
        key: [_text(one) for one in item[...]]
        for key, item in _members(table)
        if isinstance(item, h5py.Dataset) and h5py.check_string_dtype(item.dtype) is not None
    }
    names = list(map("".join, zip(texts["node_number"], texts["node_direction"], strict=True)))
    if len(set(names)) < len(names):
        names = [f"{number + 1} {name}".strip() for number, name in enumerate(names)]
    groups = []
    for key in streams:
        group = _Hdf5Group(run, key if len(streams) > 1 else "")
        _take(file[key], key, group)
        group.variables.arrays["sample_rate"] = np.array(
            _number(file.attrs["sample_rate"]) or 0.0
        )
        group.variables.texts |= {"names": names, "units": texts["unit"]}
        if math.prod(file[key].shape):
            groups.append(group)
    return groups
