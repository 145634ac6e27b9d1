"""Small recordings of every layout, each with the log that says what to expect of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.recordings import tdms_bytes
from tests.recordings.tdms_bytes import Builder

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import WRITERS

RATE = 1000.0


@dataclass(frozen=True)
class Seed:
    """A good file, what it holds, and where its metadata stand.

    Attributes
    ----------
    name : str
        File name.
    content : bytes
        The file.
    channels : tuple of str
        Names.
    values : (n_channels, n) array
        In SI.
    metadata : list of range
        Bytes that are not payload.
    """

    name: str
    content: bytes
    channels: tuple[str, ...]
    values: np.ndarray
    metadata: tuple[range, ...]

    def log(self) -> str:
        """The test log that describes the file."""
        duration = self.values.shape[1] / RATE
        roles = ", ".join(f"{name}: {{role: response}}" for name in self.channels)
        return (
            f"testlog: 1\nrecordings: .\nchannels: {{{roles}}}\n"
            f"expect: {{duration: {duration!r} s, duration_tolerance: 0.01 %, "
            f"sample_rate: {RATE:g} Hz, channels: {len(self.channels)}, unit: g}}\n"
            f"tests:\n  - {{id: 1, recording: {self.name}}}\n"
        )


def tdms_metadata(content: bytes) -> tuple[range, ...]:
    """The bytes of heads and metadata, found without shakerproc's reader."""
    found, at = [], 0
    while at < len(content):
        big = content[at + 4] & tdms_bytes.BIG
        order = "big" if big else "little"
        to_next = int.from_bytes(content[at + 12 : at + 20], order)
        to_data = int.from_bytes(content[at + 20 : at + 28], order)
        found.append(range(at, at + 28 + to_data))
        at += 28 + to_next
    return tuple(found)


def of_builder(name: str, builder: Builder) -> Seed:
    channels = tuple(f"ch{i + 1}" for i in range(len(builder.dtypes)))
    values = builder.rows() * STANDARD_GRAVITY
    return Seed(name, builder.content, channels, values, tdms_metadata(builder.content))


def contiguous() -> Seed:
    rng = np.random.default_rng(1)
    builder = Builder(["f8", "f8", "f8"]).add(rng, 12)
    return of_builder(
        "contiguous.tdms", builder.add(rng, 12, meta="same").add(rng, 12, meta="none")
    )


def one_chunk() -> Seed:
    return of_builder(
        "one_chunk.tdms", Builder(["f4", "f4"]).add(np.random.default_rng(2), 60, padding=64)
    )


def interleaved() -> Seed:
    rng = np.random.default_rng(3)
    builder = Builder(["i2", "i2", "f4"]).add(rng, 20, interleaved=True)
    return of_builder(
        "interleaved.tdms", builder.add(rng, 20, 2, interleaved=True, meta="same")
    )


def big_endian() -> Seed:
    rng = np.random.default_rng(4)
    builder = Builder(["f8", "i4"]).add(rng, 10, 2, big=True)
    return of_builder("big_endian.tdms", builder.add(rng, 10, big=True, meta="none"))


def daqmx() -> Seed:
    content, values = tdms_bytes.daqmx_file(np.random.default_rng(5), 3, 20, 2)
    unit = tdms_bytes.prop("unit_string", "g")
    content = content.replace(tdms_bytes.prop("unit_string", "V"), unit)
    channels = ("ai0", "ai1", "ai2")
    return Seed(
        "daqmx.tdms", content, channels, values * STANDARD_GRAVITY, tdms_metadata(content)
    )


def scaled() -> Seed:
    table = {
        "NI_Number_Of_Scales": 2,
        "NI_Scale[0]_Scale_Type": "Polynomial",
        "NI_Scale[0]_Polynomial_Coefficients_Size": 2,
        "NI_Scale[0]_Polynomial_Coefficients[0]": 0.5,
        "NI_Scale[0]_Polynomial_Coefficients[1]": 2.0,
        "NI_Scale[0]_Polynomial_Input_Source": 0xFFFFFFFF,
        "NI_Scale[1]_Scale_Type": "Linear",
        "NI_Scale[1]_Linear_Slope": 3.0,
        "NI_Scale[1]_Linear_Y_Intercept": -1.0,
        "NI_Scale[1]_Linear_Input_Source": 0,
    }
    builder = Builder(["i2"], extra=table).add(np.random.default_rng(6), 50, 2)
    raw = builder.rows()
    values = (3.0 * (0.5 + 2.0 * raw) - 1.0) * STANDARD_GRAVITY
    return Seed(
        "scaled.tdms", builder.content, ("ch1",), values, tdms_metadata(builder.content)
    )


def written(ending: str) -> Callable[[Path], Seed]:
    """Return what writes a seed in one of the formats that shakerproc writes."""

    def seed(folder: Path) -> Seed:
        rng = np.random.default_rng(7)
        names = ("control 1", "control 2")
        channels = [Channel(name, "m/s^2", name, "g") for name in names]
        values = np.round(rng.standard_normal((2, 80)), 6) * STANDARD_GRAVITY
        path = folder / f"seed{ending}"
        WRITERS[ending](path, recording_of_arrays("seed", channels, values, RATE))
        content = path.read_bytes()
        path.unlink()
        if ending == ".tdms":
            return Seed(path.name, content, names, values, tdms_metadata(content))
        return Seed(path.name, content, names, values, ())

    return seed


def numpy_archive(folder: Path) -> Seed:
    values = np.random.default_rng(8).standard_normal((2, 80))
    path = folder / "seed.npz"
    np.savez(path, t=np.arange(80) / RATE, ch1_g=values[0], ch2_g=values[1])
    content = path.read_bytes()
    path.unlink()
    return Seed(path.name, content, ("ch1", "ch2"), values * STANDARD_GRAVITY, ())


def labview_text() -> Seed:
    values = np.round(np.random.default_rng(9).standard_normal((2, 80)), 6)
    lines = [
        "LabVIEW Measurement\t",
        "Separator\tTab",
        "Decimal_Separator\t.",
        "***End_of_Header***\t",
        "Channels\t2\t\t",
        "Samples\t80\t80\t",
        "Y_Unit_Label\tg\tg\t",
        "Delta_X\t0.001\t0.001\t",
        "***End_of_Header***\t\t",
        "X_Value\tch1\tch2\tComment",
        *(f"{i / RATE:.3f}\t{a:.6f}\t{b:.6f}\t" for i, (a, b) in enumerate(values.T)),
    ]
    content = ("\n".join(lines) + "\n").encode()
    return Seed("seed.lvm", content, ("ch1", "ch2"), values * STANDARD_GRAVITY, ())


def make_seeds(folder: Path) -> list[Seed]:
    """All seeds; those of TDMS first."""
    tdms = [contiguous(), one_chunk(), interleaved(), big_endian(), daqmx(), scaled()]
    endings = (".tdms", ".csv", ".mat", ".uff", ".parquet")
    others = [written(ending)(folder) for ending in endings]
    return [*tdms, *others, numpy_archive(folder), labview_text()]
