"""Small recordings: RPC III, ATFX and RF64 of the core, others that an extra reads."""

import re
import struct
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from tests.fuzz.seeds import CHANNELS, N_ROWS, RATE, Seed, numbers, taken
from tests.recordings.recorder_files import (
    atfx,
    atfx_explicit,
    rpc3_bytes,
    write_famos,
    write_ide,
    write_mdf,
)

from shakerproc.data import STANDARD_GRAVITY

if TYPE_CHECKING:
    import pandas as pd

STATED = (b"DELTA_T", b"SAMPLES", b"FRAMES")


def mts(_: Path) -> Seed:
    """Two channels of whole numbers in groups of 16, after the format's description."""
    counts = np.rint(numbers(25) * 2.0**12).astype(int)
    content = rpc3_bytes(counts, [2.0**-12, 2.0**-12], 1.0 / RATE, per_group=16)
    values = counts * 2.0**-12 * STANDARD_GRAVITY
    stated = [range(content.index(name), content.index(name) + 128) for name in STATED]
    return Seed("whole.rsp", content, CHANNELS, values, (), stated=tuple(stated))


def ods(_: Path) -> Seed:
    """A submatrix whose numbers are written out; its step stands once, and its start."""
    values = numbers(29)
    columns = [
        (name, "g", "acceleration", atfx_explicit(row))
        for name, row in zip(CHANNELS, values, strict=True)
    ]
    axis = ("time", "s", "Time", (0.0, 1.0 / RATE))
    content = atfx([("part", N_ROWS, [axis, *columns])], begin="20240506070809").encode()
    once = re.finditer(rb"0\.0 0\.001|<Beginn>\d+</Beginn>|Beginn</name>.{,40}_begin", content)
    start = datetime(2024, 5, 6, 7, 8, 9, tzinfo=UTC)
    return Seed(
        "whole.atfx", content, CHANNELS, values * STANDARD_GRAVITY, (), start=start,
        stated=tuple(range(*found.span()) for found in once),
    )  # fmt: skip


def mdf(folder: Path) -> Seed:
    """A group with its times, as asammdf writes it."""
    path, values, times = folder / "whole.mf4", numbers(26), np.arange(N_ROWS) / RATE
    write_mdf(
        path, [[(name, "g", times, row) for name, row in zip(CHANNELS, values, strict=True)]]
    )
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def ide(folder: Path) -> Seed:
    """Blocks of 20 samples, each with its first and its last time."""
    path, values = folder / "whole.ide", numbers(27).astype("f4").astype(float)
    write_ide(path, [(8, "A", "g", CHANNELS, RATE, values)], 1714979289, block=20)
    content = taken(path)
    scale = re.search(rb"1/1000000000", content)
    blocks = tuple(found.start() for found in re.finditer(rb"\xa1@.\xb0\x81\x08", content))
    assert len(blocks) == N_ROWS // 20
    first = content.index(b"\xb8", blocks[0])  # no other block repeats these two times
    last = content.index(b"\xb9", blocks[-1])
    stated = (
        range(scale.start() - 3, scale.end()),  # with its element
        range(first, content.index(b"\xb9", first)),
        range(last, content.index(b"\xb2", last)),
    )
    return Seed(
        path.name, content, CHANNELS, values * STANDARD_GRAVITY, (), stated=stated,
        complete=blocks[1:],
    )  # fmt: skip


def famos(folder: Path) -> Seed:
    """Version 2, a key after the other; the step of each channel stands once."""
    path, values = folder / "whole.raw", numbers(28)
    channels = [(name, "g", row) for name, row in zip(CHANNELS, values, strict=True)]
    write_famos(path, channels, 1.0 / RATE, (6, 5, 2024, 7, 8, 9.25))
    content = taken(path)
    keys = re.finditer(rb"\|(?:C[DbP]|NT),[^;]*;", content)
    stated = tuple(range(found.start(), found.end()) for found in keys)
    return Seed(path.name, content, CHANNELS, values * STANDARD_GRAVITY, (), stated=stated)


def rf64(_: Path) -> Seed:
    """Two channels of 16 bits, whose sizes stand in a chunk of 64-bit numbers."""
    counts = np.rint(numbers(30) * 2.0**12).astype("<i2")
    data, rate = counts.T.tobytes(), int(RATE)
    sizes = struct.pack("<4sIQQQI", b"ds64", 28, 72 + len(data), len(data), N_ROWS, 0)
    form = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 2, rate, 4 * rate, 4, 16)
    later = b"\xff" * 4
    content = b"RF64" + later + b"WAVE" + sizes + form + b"data" + later + data
    channels = ("channel 1", "channel 2")
    return Seed(
        "whole.rf64", content, channels, counts / 2.0**15 * STANDARD_GRAVITY, (), unit="g"
    )


def table(values: np.ndarray) -> "pd.DataFrame":
    """Times and two channels with their units in the headers."""
    import pandas as pd

    columns = {f"{name} [g]": row for name, row in zip(CHANNELS, values, strict=True)}
    return pd.DataFrame({"time [s]": np.arange(N_ROWS) / RATE} | columns)


def feather(folder: Path) -> Seed:
    """A table with its times, as pandas writes it, packed."""
    path, values = folder / "whole.feather", numbers(31)
    table(values).to_feather(path)
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def xlsx(folder: Path) -> Seed:
    """A table with its times, as pandas writes it."""
    path, values = folder / "whole.xlsx", numbers(32)
    table(values).to_excel(path, index=False)
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


CORE: tuple[Callable[[Path], Seed], ...] = (mts, ods, rf64)
"""What writes a seed of a format that needs no package."""

EXTRAS: dict[str, Callable[[Path], Seed]] = {
    "asammdf": mdf, "idelib": ide, "imctermite": famos, "pyarrow": feather, "openpyxl": xlsx,
}  # fmt: skip
"""What writes a seed, by the package that reads it."""
