"""Read imc FAMOS (.raw, .dat): channels, each with its step, a slice at a time.

imctermite reads the keys of both versions of the format, and scales the samples.
"""

import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any, Final

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, SlicedSource, TimeAxis

MAGIC: Final = b"|CF,"
"""How a file begins."""

_ZERO: Final = datetime(1980, 1, 1, tzinfo=UTC)
"""When the clocks of imc begin to count."""

_LATEST_S: Final = 3_784_752_000.0
"""Seconds from then to 2099: a start that is later is none [s]."""


_KEY: Final = re.compile(rb"[\s]*\|[A-Za-z]{2},\d+,\s*(\d{1,18}),")
"""How a block begins: a mark, its version, and the bytes up to the semicolon that ends it."""


def read_famos(path: Path, run: str) -> RawFile:
    """Return the channels of an imc file; events and pairs of values are named and left out.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    from imctermite import ImcTermite

    _check_blocks(path, run)
    file = ImcTermite(str(path))
    keys: list[str] = []
    channels: list[RawChannel] = []
    for one in file.get_channels_metadata():
        problem = ""
        if one.kind != "numeric":
            problem = "it holds events, not even samples"
        elif one.dimension != 1:
            problem = "it holds pairs of values, not even samples"
        channels.append(_channel(one, -1 if problem else len(keys), problem))
        if not problem:
            keys.append(one.uuid)
    return RawFile(
        (RawGroup("", tuple(channels)),),
        SlicedSource(run, partial(_samples, file, keys), ExitStack()),
    )


def _check_blocks(path: Path, run: str) -> None:
    """Pass a file whose blocks follow each other to its end, as they say.

    imctermite fills in what a file lacks, and says so on the terminal only.

    Raises
    ------
    RecordingError
        If one ends elsewhere.
    """
    size, at = path.stat().st_size, 0
    with path.open("rb") as file:
        head = file.read(64)
        while head.startswith(MAGIC) or at:
            if not head.strip():
                return
            match = _KEY.match(head)
            end = at + (match.end() + int(match[1]) if match is not None else 0)
            file.seek(end)
            if match is None or file.read(1) != b";":
                raise RecordingError(
                    f"{run}: byte {at}: a block of the file does not end where it says; the "
                    f"file has {size} bytes. {AGAIN}"
                )
            at = end + 1
            head = file.read(64)


def _samples(
    file: Any, keys: Sequence[str], rows: Sequence[int], start: int, stop: int
) -> Iterator[FloatArray]:
    """Yield samples of rows, scaled as the file says; it is open only meanwhile."""
    for row in rows:
        pieces = file.iter_channel_numpy(
            keys[row], include_x=False, chunk_rows=stop - start, start_index=start
        )
        with closing(pieces):
            yield next(pieces)["y"]


def _channel(one: Any, row: int, problem: str) -> RawChannel:
    """Return a channel as the file describes it."""
    at = float(one.absolute_trigger_time)
    axis = TimeAxis(
        "key CD", step=float(one.x_step_width), start=float(one.x_offset), unit=one.x_unit,
        quantity="" if one.x_unit else one.x_name,
    )  # fmt: skip
    return RawChannel(
        name=one.name,
        row=row,
        n_samples=int(one.sample_count),
        promised=int(one.sample_count),
        unit=one.y_unit,
        problem=problem,
        axes=(axis,),
        start_time=_ZERO + timedelta(seconds=at) if 0.0 < at < _LATEST_S else None,
    )
