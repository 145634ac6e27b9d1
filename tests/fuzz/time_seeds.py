"""Small recordings of every way to state times, each the only word on rate and start."""

import struct
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import parquet
from tests.fuzz.seeds import (
    CHANNELS,
    N_ROWS,
    RATE,
    Seed,
    numbers,
    of_lines,
    taken,
    text,
    universal,
)
from tests.recordings.tdms_bytes import METADATA, NEW_LIST, RAW, chunk, index, listed
from tests.recordings.tdms_bytes import metadata as tdms_objects
from tests.recordings.tdms_bytes import segment as tdms_segment

from shakerproc.data import STANDARD_GRAVITY

START = datetime(2024, 3, 5, 23, 59, 59, 960000, tzinfo=UTC)
"""Midnight passes while the rows go by."""
OPENDAQ = "# domain;unit=seconds;resolution=1/1000;delta=1;origin=1970-01-01;starting_tick=0;"
LATE = 5
"""Samples by which the second channel starts later, where it does."""


def stamps(form: str) -> list[str]:
    """Return the moments of the rows, to the millisecond."""
    moments = [START + timedelta(seconds=i / RATE) for i in range(N_ROWS)]
    return [f"{m:{form}}.{m.microsecond // 1000:03d}" for m in moments]


def texts() -> list[Seed]:
    """Return tables with times in other units, names, epochs, as clock times and dates."""
    milliseconds = [str(i) for i in range(N_ROWS)]
    epoch = [f"{START.timestamp() + i / RATE:.3f}" for i in range(N_ROWS)]
    labview = [f"{START.timestamp() + 2082844800 + i / RATE:.3f}" for i in range(N_ROWS)]
    head = ["ch1 [g]", "ch2 [g]"]
    return [
        text("named.csv", [",".join(["time_ms", *head])], 20, ",", times=milliseconds),
        text("minutes.txt", ["t [min]\tch1 [g]\tch2 [g]"], 21, "\t",
             times=[f"{i / RATE / 60.0:.9f}" for i in range(N_ROWS)]),
        text("epoch.csv", [",".join(["timestamp", *head])], 22, ",", times=epoch,
             start=START),
        text("labview.csv", [",".join(["timestamp", *head])], 23, ",", times=labview,
             start=START),
        text("clock.csv", ["Zeit;ch1 [g];ch2 [g]"], 24, ";", ",", times=stamps("%H:%M:%S")),
        text("dates.csv", [",".join(["time", *head])], 25, ",",
             times=stamps("%Y-%m-%dT%H:%M:%S"), start=START),
        text("cells.csv", [",".join(["date", "time", *head])], 26, ",",
             times=stamps("%Y-%m-%d,%H:%M:%S"), start=START),
        text("directions.csv", ["# 1 kHz", "time [s],ch1 (X+) [g],ch2 (Z-) [g]"], 27, ",",
             channels=("ch1 (X+)", "ch2 (Z-)")),
        text("ticks.csv", [OPENDAQ, 'Domain,"ch1 (g)","ch2 (g)"'], 33, ",",
             times=[str(1709683199960 + i) for i in range(N_ROWS)]),
    ]  # fmt: skip


def labview_writes(folder: Path) -> Seed:
    """Two writes under one header, with a column of times and its step in the header."""
    values, half = numbers(28), N_ROWS // 2
    lines = [
        "LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t.",
        "Multi_Headings\tNo", "X_Columns\tOne", "***End_of_Header***\t", "\t",
        "Channels\t2\t\t", f"Samples\t{half}\t{half}\t",
        "Date\t2024/03/05\t2024/03/05\t", "Time\t23:59:59.96\t23:59:59.96\t",
        "Y_Unit_Label\tg\tg\t", "X_Dimension\tTime\tTime\t", "X0\t0\t0\t",
        "Delta_X\t0.001\t0.001\t", "***End_of_Header***\t\t", "X_Value\tch1\tch2\tComment",
    ]  # fmt: skip
    rows = [
        f"{i / RATE:.3f}\t" + "\t".join(f"{value:.6f}" for value in row)
        for i, row in enumerate(values.T)
    ]
    content = ("\n".join([*lines, *rows]) + "\n").encode()
    return Seed(
        "writes.lvm", content, CHANNELS, values * STANDARD_GRAVITY, (),
        range(len(lines), len(lines) + N_ROWS), "\t", counted=False, start=START,
        stated=of_lines(content, b"Date", b"Time"),
    )  # fmt: skip


def labview_starts(folder: Path) -> Seed:
    """No column of times; the second channel starts later, by its X0."""
    values, late = numbers(29), LATE / RATE
    lines = [
        "LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t.",
        "X_Columns\tNo", "***End_of_Header***\t", "\t",
        "Channels\t2\t\t", f"Samples\t{N_ROWS}\t{N_ROWS}\t", "Y_Unit_Label\tg\tg\t",
        "X_Dimension\tTime\tTime\t", f"X0\t0\t{late:.3f}\t", "Delta_X\t0.001\t0.001\t",
        "***End_of_Header***\t\t", "X_Value\tch1\tch2\tComment",
    ]  # fmt: skip
    rows = ["\t" + "\t".join(f"{value:.6f}" for value in row) for row in values.T]
    content = ("\n".join([*lines, *rows]) + "\n").encode()
    common = np.stack([values[0, LATE:], values[1, : N_ROWS - LATE]])
    return Seed(
        "starts.lvm", content, CHANNELS, common * STANDARD_GRAVITY, (),
        stated=of_lines(content, b"X0", b"Delta_X"),
    )  # fmt: skip


def universal_starts(folder: Path) -> Seed:
    """Two records, the second of which starts later by its abscissa minimum."""
    seed = universal("starts.uff", 30, even=True)
    zero, late = f"{1:10d}{0.0:13.5e}".encode(), f"{1:10d}{LATE / RATE:13.5e}".encode()
    at = seed.content.rindex(zero)
    content = seed.content[:at] + late + seed.content[at + len(zero) :]
    common = np.stack([seed.values[0, LATE:], seed.values[1, : N_ROWS - LATE]])
    step = f"{1.0 / RATE:13.5e}".encode()
    width = len(late) + len(step)
    stated = [range(m, m + width) for m in places(content, zero + step)]
    stated += [range(m, m + width) for m in places(content, late + step)]
    return Seed("starts.uff", content, CHANNELS, common, (), stated=tuple(stated))


def universal_binary(folder: Path) -> Seed:
    """Two binary records with stored abscissas of doubles."""
    even = universal("binary.uff", 31, even=False)
    values, parts = numbers(31)[:, : N_ROWS - 1], []
    count = values.shape[1]
    for record, row in zip(even.content.split(b"    -1\n    58\n")[1:], values, strict=True):
        lines = record.splitlines()
        data = b"".join(struct.pack("<dd", i / RATE, value) for i, value in enumerate(row))
        first = f"    58b{1:6d}{2:6d}{11:12d}{len(data):12d}" + 2 * f"{0:6d}" + 2 * f"{0:12d}"
        head = b"\n".join([b"    -1", first.encode(), *lines[:11]]) + b"\n"
        assert count == int(lines[6].split()[1])
        parts.append(head + data + b"\n    -1\n")
    return Seed("binary.uff", b"".join(parts), CHANNELS, values * STANDARD_GRAVITY, ())


def places(content: bytes, piece: bytes) -> list[int]:
    """Return where a piece of a file stands."""
    found, at = [], content.find(piece)
    while at >= 0:
        found.append(at)
        at = content.find(piece, at + 1)
    return found


def parquet_times(folder: Path) -> Seed:
    """A column of dates."""
    values, path = numbers(32), folder / "dates.parquet"
    moments = [START + timedelta(seconds=i / RATE) for i in range(N_ROWS)]
    times = pa.array([m.replace(tzinfo=None) for m in moments], pa.timestamp("us"))
    table = pa.table({"time": times, "ch1 [g]": values[0], "ch2 [g]": values[1]})
    parquet.write_table(table, path, use_dictionary=False)
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, (), start=START)


def tdms_starts(folder: Path) -> Seed:
    """The second channel starts later, by its offset."""
    values = numbers(33)
    objects = [
        listed(
            f"/'g'/'{name}'",
            index("f8", N_ROWS),
            {"wf_increment": 1.0 / RATE, "wf_start_offset": late / RATE, "unit_string": "g"},
        )
        for name, late in zip(CHANNELS, (0, LATE), strict=True)
    ]
    head = tdms_objects(objects)
    raw = chunk(list(values), interleaved=False, e="<")
    content = tdms_segment(head, raw, METADATA | NEW_LIST | RAW)
    common = np.stack([values[0, LATE:], values[1, : N_ROWS - LATE]])
    return Seed(
        "starts.tdms", content, CHANNELS, common * STANDARD_GRAVITY, (range(28 + len(head)),)
    )


def make_time_seeds(folder: Path) -> list[Seed]:
    """All seeds of times."""
    more = (
        labview_writes, labview_starts, universal_starts, universal_binary, parquet_times,
        tdms_starts,
    )  # fmt: skip
    return [*texts(), *(make(folder) for make in more)]
