"""Recordings out: each writer writes whole files or none, in the unit that the file had.

CSV, Parquet, HDF5, MATLAB's .mat, MDF and TDMS are formats that libraries know. UFF 58 follows
the format's description: pyuff reads it, and is the tests' oracle, but writing it leaves the
file open, packs one number at a time, counts half the bytes of complex numbers and loses
the header in its mode ``overwrite``.
"""

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO, Final, final

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from numpy.typing import NDArray

from shakerproc import files
from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.errors import RecordingError
from shakerproc.geometry.data_sets import MARK, text_line
from shakerproc.late import without, without_parquet
from shakerproc.recordings.parquet import RATE_KEY
from shakerproc.recordings.si import UNKNOWN, parse_unit

BLOCK = 1 << 16
"""Samples written at a time."""

_SLASH: Final = "\N{DIVISION SLASH}"
"""What stands for a slash in the name of a data set, where a slash is a group."""

LARGEST: Final = (1 << 31) - 1024
"""Bytes of a variable in version 5."""

_TIME_TITLE: Final = "time [s]"


def file_unit(channel: Channel) -> tuple[str, float]:
    """Return the unit that a channel is written in, and SI units in it.

    That is the unit of the file it came from, such as g, where that is a plain unit; else SI.
    """
    if channel.unit == UNKNOWN:
        return channel.source_unit, 1.0
    known = parse_unit(channel.source_unit)
    if known is not None and known[0] == channel.unit:
        return channel.source_unit, known[1]
    return channel.unit, 1.0


def headers(channels: Sequence[Channel]) -> list[str]:
    """Return the header of each channel, such as ``control 1 [g]``."""
    texts = []
    for channel in channels:
        unit, _ = file_unit(channel)
        texts.append(f"{channel.name} [{unit}]" if unit else channel.name)
    return texts


def blocks_in_file_units(recording: Recording) -> Iterator[FloatArray]:
    """Yield the samples in order, (n_channels, at most BLOCK) arrays, in the file's units."""
    factors = np.array([[file_unit(channel)[1]] for channel in recording.channels])
    for block in recording.blocks(size=BLOCK):
        yield block / factors


def write_hdf5(path: Path, recording: Recording) -> None:
    """Write a recording as HDF5, whole or not at all."""
    import h5py

    names = _names([channel.name for channel in recording.channels])
    with (
        files.atomic_path(path) as temporary,
        h5py.File(temporary, "w", track_order=True) as file,
    ):
        file.attrs["sample_rate"] = float(recording.sample_rate)
        file.attrs["title"] = recording.run
        if recording.start_time is not None:
            file.attrs["start_time"] = recording.start_time.isoformat()
        stored = []
        for name, channel in zip(names, recording.channels, strict=True):
            data = file.create_dataset(
                name, (recording.n_samples,), np.float64,
                chunks=(min(BLOCK, recording.n_samples),),
            )  # fmt: skip
            data.attrs["name"] = channel.name
            if unit := file_unit(channel)[0]:
                data.attrs["units"] = unit
            stored.append(data)
        at = 0
        for block in blocks_in_file_units(recording):
            for data, samples in zip(stored, block, strict=True):
                data[at : at + samples.size] = samples
            at += block.shape[1]


def _names(names: list[str]) -> list[str]:
    """Return the names of the data sets: no two alike, none a path."""
    plain = [name.replace("/", _SLASH).replace("\0", "") or "channel" for name in names]
    plain = ["channel" if set(name) == {"."} else name for name in plain]
    return [
        name if plain.count(name) == 1 else f"{name} {number + 1}"
        for number, name in enumerate(plain)
    ]


def write_mat(path: Path, recording: Recording) -> None:
    """Write a recording for MATLAB, whole or not at all.

    Raises
    ------
    RecordingError
        If it is longer than the format can hold.
    """
    from scipy import io as scipy_io

    size = 8 * recording.n_samples * len(recording.channels)
    if size > LARGEST:
        raise RecordingError(
            f"{recording.run}: {size >> 20} MB are more than a .mat file can hold. "
            "Convert it to Parquet or TDMS, or crop it first."
        )
    samples = np.concatenate(list(blocks_in_file_units(recording)), axis=1).T
    units = [file_unit(channel)[0] for channel in recording.channels]
    content = {
        "samples": samples,
        "names": np.array([c.name for c in recording.channels], dtype=object),
        "units": np.array(units, dtype=object),
        "sample_rate_hz": recording.sample_rate,
        "start_time": recording.start_time.isoformat() if recording.start_time else "",
    }
    with files.atomic_path(path) as temporary:
        scipy_io.savemat(temporary, content, do_compression=False, oned_as="column")


def write_mf4(path: Path, recording: Recording) -> None:
    """Write a recording as MDF of version 4.10, whole or not at all.

    Raises
    ------
    RecordingError
        If asammdf is not installed.
    """
    if lacks := without("asammdf", "MDF", "recorders", "write TDMS or HDF5"):
        raise RecordingError(f"{path}: {lacks}")
    from asammdf import MDF, Signal

    with files.atomic_path(path) as temporary, MDF(version="4.10") as file:
        if recording.start_time is not None:
            file.start_time = recording.start_time
        else:
            file.header.abs_time = 0  # else the time of writing would be that of the test
        for number, block in enumerate(blocks_in_file_units(recording)):
            at = np.arange(number * BLOCK, number * BLOCK + block.shape[1])
            times = at / recording.sample_rate
            if number:
                file.extend(0, [(times, None), *((samples, None) for samples in block)])
                continue
            signals = [
                Signal(samples, times, name=channel.name, unit=file_unit(channel)[0])
                for channel, samples in zip(recording.channels, block, strict=True)
            ]
            file.append(signals, comment=recording.run, common_timebase=True)
        file.save(temporary, overwrite=True)


def write_csv(path: Path, recording: Recording) -> None:
    """Write a recording as CSV, whole or not at all; every number with all its digits."""
    line = io.StringIO()
    titles = [_TIME_TITLE, *headers(recording.channels)]
    csv.writer(line, lineterminator="\n").writerow([files.csv_cell(title) for title in titles])
    write_block = _with_python if without_parquet() else _with_arrow
    with files.atomic_path(path) as temporary, temporary.open("wb") as sink:
        sink.write(line.getvalue().encode("utf-8"))
        for columns in _columns(recording):
            write_block(columns, sink)


def _with_arrow(columns: list[FloatArray], sink: BinaryIO) -> None:
    """Write rows of numbers, each in the fewest digits that give it back."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    names = [str(number) for number in range(len(columns))]
    batch = pa.record_batch([pa.array(column) for column in columns], names=names)
    arrow_csv.write_csv(batch, sink, arrow_csv.WriteOptions(include_header=False))


def _with_python(columns: list[FloatArray], sink: BinaryIO) -> None:
    """Write the same numbers without pyarrow, in some five times the time."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    sink.write("".join(",".join(map(repr, row)) + "\n" for row in rows).encode("ascii"))


def write_parquet(path: Path, recording: Recording) -> None:
    """Write a recording as Parquet, whole or not at all.

    Raises
    ------
    RecordingError
        If pyarrow is not installed.
    """
    if lacks := without_parquet():
        raise RecordingError(f"{path}: {lacks}")
    from pyarrow import parquet

    with files.atomic_path(path) as temporary:
        batches = _batches(recording)
        first = next(batches)
        rate = repr(float(recording.sample_rate)).encode("ascii")
        schema = first.schema.with_metadata({RATE_KEY: rate})
        with parquet.ParquetWriter(temporary, schema) as writer:
            writer.write_batch(first.replace_schema_metadata(schema.metadata))
            for batch in batches:
                writer.write_batch(batch.replace_schema_metadata(schema.metadata))


def _batches(recording: Recording) -> Iterator[Any]:
    """Yield the table in pieces."""
    import pyarrow as pa

    titles = [_TIME_TITLE, *headers(recording.channels)]
    for columns in _columns(recording):
        yield pa.record_batch([pa.array(column) for column in columns], names=titles)


def _columns(recording: Recording) -> Iterator[list[FloatArray]]:
    """Yield time [s] and channels in pieces."""
    for number, block in enumerate(blocks_in_file_units(recording)):
        at = np.arange(number * BLOCK, number * BLOCK + block.shape[1])
        yield [at / recording.sample_rate, *block]


def write_tdms(path: Path, recording: Recording) -> None:
    """Write a recording as TDMS, whole or not at all; groups are named as by SignalExpress."""
    title = _title(recording)
    name = f"{title} - All Data"
    with files.atomic_path(path) as temporary, TdmsWriter(str(temporary)) as writer:
        root = RootObject(_root_properties(recording, title))
        group = GroupObject(name, {"DecimationLevel": 0, "IntervalIndex": 0})
        for number, block in enumerate(blocks_in_file_units(recording)):
            described = [root, group] if number == 0 else []
            channels = _channels(recording, name, block, described=number == 0)
            writer.write_segment([*described, *channels])


def _title(recording: Recording) -> str:
    start = recording.start_time
    moment = start.strftime("%m/%d/%Y %I:%M:%S %p - ") if start else ""
    return f"{moment}{recording.run.removesuffix('.tdms')}"


def _root_properties(recording: Recording, title: str) -> dict[str, Any]:
    promised = recording.expected_samples or recording.n_samples
    return {
        "name": recording.run.removesuffix(".tdms"),
        "Title": title,
        "WriterName": "shakerproc",
        "log-dt": 1.0 / recording.sample_rate,
        "log-duration": promised / recording.sample_rate,
        "recording-complete": not recording.incomplete,
    }


def _channels(
    recording: Recording, group: str, block: FloatArray, *, described: bool
) -> list[ChannelObject]:
    channel_objects = []
    for channel, samples in zip(recording.channels, block, strict=True):
        properties: dict[str, Any] = {}
        if described:
            unit, _ = file_unit(channel)
            properties = {"wf_increment": 1.0 / recording.sample_rate, "wf_start_offset": 0.0}
            if unit:
                properties |= {"unit_string": unit, "NI_UnitDescription": unit}
            if recording.start_time is not None:
                properties["wf_start_time"] = _naive(recording.start_time)
        channel_objects.append(ChannelObject(group, channel.name, samples, properties))
    return channel_objects


def _naive(moment: datetime) -> np.datetime64:
    return np.datetime64(moment.astimezone(UTC).replace(tzinfo=None), "us")


QUANTITIES: Final = {"m/m": 3, "m": 8, "m/s": 11, "m/s^2": 12, "N": 13, "Pa": 15}
"""What the format calls the kinds of data, by their SI unit; 0 is unknown, 1 general."""

TIME_RESPONSE, RESPONSE, COHERENCE, DENSITY = 1, 4, 6, 9
"""Types of function."""

_ALONG: Final = 0.999
"""Cosine from which a direction is that of an axis: within 2.6 degrees [-]."""

_DOUBLE, _COMPLEX_DOUBLE = 4, 6
_PER_LINE: Final = 4
_LITTLE_ENDIAN: Final = 1
_IEEE: Final = 2


@final
@dataclass(frozen=True, slots=True)
class RecordAxis:
    """An axis of a record: number of its quantity in the format, its name and its unit."""

    quantity: int
    label: str
    unit: str


TIME: Final = RecordAxis(17, "time", "s")
FREQUENCY: Final = RecordAxis(18, "frequency", "Hz")
NONE: Final = RecordAxis(0, "NONE", "NONE")


@final
@dataclass(frozen=True, slots=True)
class End:
    """Where a function was measured: entity, number of the node, direction (-3 to 3)."""

    name: str = "NONE"
    node: int = 0
    direction: int = 0


@final
@dataclass(frozen=True, slots=True)
class RecordHead:
    """Header of a record 58.

    Attributes
    ----------
    function : int
        Its type.
    texts : tuple of str
        Up to five lines.
    response, reference : End
        Where the numerator and the denominator were measured.
    start, step : float
        Of the abscissa [unit of the abscissa].
    abscissa, ordinate, denominator : RecordAxis
        What the values are over, are, and are divided by.
    """

    function: int
    texts: tuple[str, ...]
    response: End
    reference: End
    start: float
    step: float
    abscissa: RecordAxis
    ordinate: RecordAxis
    denominator: RecordAxis = NONE


def write_uff(path: Path, recording: Recording) -> None:
    """Write a recording as universal file, whole or not at all."""
    with files.atomic_path(path) as temporary, temporary.open("wb") as file:
        for number in range(len(recording.channels)):
            _write_record(file, recording, number)


def _write_record(file: BinaryIO, recording: Recording, number: int) -> None:
    """Write one channel, a block at a time."""
    _, factor = file_unit(recording.channels[number])
    blocks = recording.select([number]).blocks(size=BLOCK)
    head = _head(recording, number)
    parts = (block[0] / factor for block in blocks)
    _write(file, head, recording.n_samples, parts, kind=_DOUBLE, binary=True)


def write_function(
    file: BinaryIO, head: RecordHead, values: NDArray[np.inexact[Any]], *, binary: bool
) -> None:
    """Write one record 58: eleven lines of text, then the numbers as bytes or as text.

    `values` are (n,), in the unit of the ordinate over that of the denominator.
    """
    kind = _COMPLEX_DOUBLE if np.iscomplexobj(values) else _DOUBLE
    wanted = np.complex128 if kind == _COMPLEX_DOUBLE else np.float64
    numbers: FloatArray = np.ascontiguousarray(values, wanted).view(np.float64)
    _write(file, head, values.size, [numbers], kind=kind, binary=binary)


def _write(
    file: BinaryIO, head: RecordHead, count: int, parts: Iterable[FloatArray], *, kind: int,
    binary: bool,
) -> None:  # fmt: skip
    size = 8 * count * (2 if kind == _COMPLEX_DOUBLE else 1)
    first = "    58"
    if binary:
        first += f"b{_LITTLE_ENDIAN:6d}{_IEEE:6d}{11:12d}{size:12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    lines = [MARK + first, *_lines(head, count, kind)]
    file.write("".join(f"{line}\n" for line in lines).encode("ascii", errors="replace"))
    for part in parts:
        file.write(part.astype("<f8").tobytes() if binary else _as_text(part))
    file.write(MARK.encode())  # behind bytes at once: SDynPy takes a line end for one of them


def _as_text(numbers: FloatArray) -> bytes:
    """Return numbers in columns, 4E20.12."""
    rows = (numbers[at : at + _PER_LINE] for at in range(0, numbers.size, _PER_LINE))
    return "".join("".join(f"{v:20.12E}" for v in row) + "\n" for row in rows).encode()


def _lines(head: RecordHead, count: int, kind: int) -> Iterator[str]:
    """Yield the eleven lines above the numbers."""
    yield from map(text_line, (*head.texts, *[""] * 5)[:5])
    ends = [
        f"{e.name:10.10}{e.node:10d}{e.direction:4d}" for e in (head.response, head.reference)
    ]
    yield f"{head.function:5d}{0:10d}{0:5d}{0:10d} {' '.join(ends)}"
    yield f"{kind:10d}{count:10d}{1:10d}{head.start:13.5e}{head.step:13.5e}{0.0:13.5e}"
    for axis in (head.abscissa, head.ordinate, head.denominator, NONE):
        label, unit = (files.printable(text)[:20] or "NONE" for text in (axis.label, axis.unit))
        yield f"{axis.quantity:10d}{0:5d}{0:5d}{0:5d} {label:20} {unit:20}"


def _head(recording: Recording, number: int) -> RecordHead:
    channel = recording.channels[number]
    unit, _ = file_unit(channel)
    start = recording.start_time
    return RecordHead(
        TIME_RESPONSE,
        (
            channel.name,
            recording.run,
            start.strftime("%d-%b-%y %H:%M:%S") if start else "",
            "",
            f"sample rate {float(recording.sample_rate)!r} Hz, "
            f"record {number + 1} of {len(recording.channels)}",
        ),
        End(node=number + 1),
        End(),
        0.0,
        1.0 / recording.sample_rate,
        TIME,
        RecordAxis(QUANTITIES.get(channel.unit, 0), "NONE", unit),
    )


def direction_of(vector: tuple[float, float, float] | None) -> int:
    """Return 1, 2, 3 along x, y, z, less than 0 against it; 0 along none of them.

    `vector` is of unit length [-].
    """
    for axis, cosine in enumerate(vector or ()):
        if abs(cosine) > _ALONG:
            return (axis + 1) * (1 if cosine > 0.0 else -1)
    return 0


WRITERS: Mapping[str, Callable[[Path, Recording], None]] = MappingProxyType({
    ".tdms": write_tdms,
    ".csv": write_csv,
    ".mat": write_mat,
    ".uff": write_uff,
    ".unv": write_uff,
    ".parquet": write_parquet,
    ".h5": write_hdf5,
    ".hdf5": write_hdf5,
    ".mf4": write_mf4,
})
"""What writes a file, by its ending in small letters."""
