"""Write CSV, Parquet, HDF5, MATLAB's .mat, MDF and TDMS: formats that libraries know."""

import csv
import io
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from shakerproc import files
from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.errors import RecordingError
from shakerproc.late import without, without_parquet
from shakerproc.recordings.parquet import RATE_KEY
from shakerproc.recordings.si import UNKNOWN, parse_unit

BLOCK = 1 << 16
"""Samples written at a time."""

_SLASH: Final = "\N{DIVISION SLASH}"
"""What stands for a slash in the name of a data set, where a slash is a group."""

LARGEST: Final = (1 << 31) - 1024
"""Bytes of a variable in version 5."""

TIME: Final = "time [s]"


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
    found = []
    for channel in channels:
        unit, _ = file_unit(channel)
        found.append(f"{channel.name} [{unit}]" if unit else channel.name)
    return found


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
    titles = [TIME, *headers(recording.channels)]
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

    titles = [TIME, *headers(recording.channels)]
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
    found = []
    for channel, samples in zip(recording.channels, block, strict=True):
        properties: dict[str, Any] = {}
        if described:
            unit, _ = file_unit(channel)
            properties = {"wf_increment": 1.0 / recording.sample_rate, "wf_start_offset": 0.0}
            if unit:
                properties |= {"unit_string": unit, "NI_UnitDescription": unit}
            if recording.start_time is not None:
                properties["wf_start_time"] = _naive(recording.start_time)
        found.append(ChannelObject(group, channel.name, samples, properties))
    return found


def _naive(moment: datetime) -> np.datetime64:
    return np.datetime64(moment.astimezone(UTC).replace(tzinfo=None), "us")
