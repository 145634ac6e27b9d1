"""Write UFF 58 in its binary form: one record for each channel, after the format's description.

pyuff reads what is written here (and is the tests' oracle) but is not used to write: it leaves
the file open, packs one number at a time and loses the header in its mode ``overwrite``.
"""

from pathlib import Path
from typing import BinaryIO, Final

from shakerproc import files
from shakerproc.data import Recording
from shakerproc.recordings.writers.shown_units import BLOCK, file_unit

QUANTITIES: Final = {"m/s^2": 12, "m/s": 11, "m": 8, "N": 13}
"""What the format calls the kinds of data; 0 is unknown."""

_TIME: Final = 17
_TIME_RESPONSE: Final = 1
_DOUBLE: Final = 4
_LITTLE_ENDIAN: Final = 1
_IEEE: Final = 2


def write_uff(path: Path, recording: Recording) -> None:
    """Write a recording as universal file, whole or not at all."""
    with files.atomic_path(path) as temporary, temporary.open("wb") as file:
        for number in range(len(recording.channels)):
            _write_record(file, recording, number)


def _write_record(file: BinaryIO, recording: Recording, number: int) -> None:
    """Write one dataset: eleven lines of text, then the numbers as they are in memory."""
    file.write(_head(recording, number).encode("ascii", errors="replace"))
    _, factor = file_unit(recording.channels[number])
    for block in recording.select([number]).blocks(size=BLOCK):
        file.write((block[0] / factor).astype("<f8").tobytes())
    file.write(b"\n    -1\n")


def _head(recording: Recording, number: int) -> str:
    channel = recording.channels[number]
    unit, _ = file_unit(channel)
    start = recording.start_time
    n = recording.n_samples
    lines = [
        "    -1",
        f"    58b{_LITTLE_ENDIAN:6d}{_IEEE:6d}{11:12d}{8 * n:12d}{0:6d}{0:6d}{0:12d}{0:12d}",
        _text(channel.name),
        _text(recording.run),
        _text(start.strftime("%d-%b-%y %H:%M:%S") if start else "NONE"),
        "NONE".ljust(80),
        _text(f"sample rate {float(recording.sample_rate)!r} Hz"),
        f"{_TIME_RESPONSE:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{number + 1:10d}{0:4d} "
        f"{'NONE':10}{0:10d}{0:4d}",
        f"{_DOUBLE:10d}{n:10d}{1:10d}{0.0:13.5e}{1.0 / recording.sample_rate:13.5e}{0.0:13.5e}",
        _axis(_TIME, "time", "s"),
        _axis(QUANTITIES.get(channel.unit, 0), "NONE", files.printable(unit)[:20] or "NONE"),
        _axis(0, "NONE", "NONE"),
        _axis(0, "NONE", "NONE"),
    ]
    return "\n".join(lines) + "\n"


def _text(content: str) -> str:
    return (files.printable(content)[:80] or "NONE").ljust(80)


def _axis(kind: int, label: str, unit: str) -> str:
    return f"{kind:10d}{0:5d}{0:5d}{0:5d} {label:20} {unit:20}"
