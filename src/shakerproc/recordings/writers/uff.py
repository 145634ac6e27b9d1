"""Write UFF 58, as text or with binary numbers, after the format's description.

pyuff reads what is written here (and is the tests' oracle) but is not used to write: it leaves
the file open, packs one number at a time, counts half the bytes of complex numbers and loses
the header in its mode ``overwrite``.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import files
from shakerproc.data import FloatArray, Recording
from shakerproc.geometry.data_sets import MARK, text_line
from shakerproc.recordings.writers.by_libraries import BLOCK, file_unit

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
            f"sample rate {float(recording.sample_rate)!r} Hz",
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
