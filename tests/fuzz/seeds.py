"""Small recordings of every layout, each with the log that says what to expect of it."""

import re
import struct
import wave
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import h5py
import numpy as np
from scipy import io as scipy_io
from scipy.io import wavfile
from tests.recordings import tdms_bytes
from tests.recordings.tdms_bytes import Builder

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import WRITERS

RATE = 1000.0
N_ROWS = 80
CHANNELS = ("ch1", "ch2")


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
    table : range, optional
        Lines of the rows of numbers, of a text file.
    delimiter : str
        Between its cells.
    counted : bool
        Whether the file says how many values there are.
    complete : tuple of int
        Sizes at which a cut file is a whole one by all that it says.
    start : datetime, optional
        When the first row was taken, where the file says it.
    stated : tuple of range
        Bytes that say rate, start or unit of the times and that nothing else in the file
        repeats: once they are damaged, the file says something else.
    unit : str
        What the log says of the unit, of a format that says none.
    """

    name: str
    content: bytes
    channels: tuple[str, ...]
    values: np.ndarray
    metadata: tuple[range, ...]
    table: range | None = None
    delimiter: str = ","
    counted: bool = True
    complete: tuple[int, ...] = ()
    start: datetime | None = None
    stated: tuple[range, ...] = ()
    unit: str = ""

    def log(self) -> str:
        """The test log that describes the file, with a test for each use of bad rows.

        Of TDMS it says the duration too; of the others the readers have to find out by
        themselves what is missing. It says no rate: a wrong one is for the judge to see.
        """
        duration = ""
        if self.name.endswith(".tdms"):
            seconds = self.values.shape[1] / RATE
            duration = f"duration: {seconds!r} s, duration_tolerance: 0.01 %, "
        unit = f", unit: {self.unit}" if self.unit else ""
        roles = ", ".join(f'"{name}": {{role: response{unit}}}' for name in self.channels)
        return (
            f"testlog: 1\nrecordings: .\nchannels: {{{roles}}}\n"
            f"expect: {{{duration}channels: {len(self.channels)}, unit: g}}\ntests:\n"
            f"  - {{id: 1, recording: {self.name}}}\n"
            f"  - {{id: 2, recording: {self.name}, processing: {{bad_rows: skip}}}}\n"
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


def numbers(seed: int) -> np.ndarray:
    """Two channels of noise with six decimals [g]."""
    return np.round(np.random.default_rng(seed).standard_normal((2, N_ROWS)), 6)


def written(ending: str, seed: int) -> Callable[[Path], Seed]:
    """Return what writes a seed in one of the formats that shakerproc writes."""

    def make(folder: Path) -> Seed:
        channels = [Channel(name, "m/s^2", name, "g") for name in CHANNELS]
        values = numbers(seed) * STANDARD_GRAVITY
        path = folder / f"written{ending}"
        WRITERS[ending](path, recording_of_arrays("seed", channels, values, RATE))
        content = taken(path)
        metadata = tdms_metadata(content) if ending == ".tdms" else ()
        return Seed(path.name, content, CHANNELS, values, metadata)

    return make


def taken(path: Path) -> bytes:
    """The content of a file, which goes."""
    content = path.read_bytes()
    path.unlink()
    return content


def text(
    name: str,
    head: list[str],
    seed: int,
    delimiter: str,
    decimal: str = ".",
    *,
    times: Sequence[str] = tuple(f"{i / RATE:.3f}" for i in range(N_ROWS)),
    start: datetime | None = None,
    channels: tuple[str, ...] = CHANNELS,
) -> Seed:
    """A table of text below some lines."""
    values = numbers(seed)
    rows = [
        delimiter.join([time, *(f"{value:.6f}" for value in row)])
        for time, row in zip(times, values.T, strict=True)
    ]
    lines = [*head, *(row.replace(".", decimal) for row in rows)]
    return Seed(
        name,
        ("\n".join(lines) + "\n").encode(),
        channels,
        values * STANDARD_GRAVITY,
        (),
        range(len(head), len(lines)),
        delimiter,
        counted=name.endswith(".lvm"),
        start=start,
        stated=(range(len("\n".join(head))),) if start is None else (),
    )


def csv(folder: Path) -> Seed:
    return text("comma.csv", ["Recorder 5", "", "t [s],ch1 [g],ch2 [g]"], 10, ",")


def german_csv(folder: Path) -> Seed:
    return text("semicolon.csv", ["Zeit;ch1;ch2", "s;g;g"], 11, ";", ",")


def labview_text(folder: Path) -> Seed:
    head = [
        "LabVIEW Measurement\t",
        "Separator\tTab",
        "Decimal_Separator\t.",
        "***End_of_Header***\t",
        "Channels\t2\t\t",
        f"Samples\t{N_ROWS}\t{N_ROWS}\t",
        "Y_Unit_Label\tg\tg\t",
        "Delta_X\t0.001\t0.001\t",
        "***End_of_Header***\t\t",
        "X_Value\tch1\tch2\tComment",
    ]
    return text("seed.lvm", head, 9, "\t")


def csv_below_statements(folder: Path) -> Seed:
    head = ["! bench 3", "Sample Rate (Hz),1000", "start,0.5", "t,ch1,ch2", "s,g,g"]
    return text("statements.csv", head, 16, ",")


def labview_segments(folder: Path) -> Seed:
    """Two segments, each with its header, of which the second follows on."""
    values, lines = numbers(17), []
    for number, half in enumerate(np.split(values, 2, axis=1)):
        lines += [
            "", "Channels\t2\t\t", f"Samples\t{N_ROWS // 2}\t{N_ROWS // 2}\t",
            "Date\t2024/03/05\t2024/03/05\t",
            *(f"Time\t10:11:12.{40 * number:03d}\t10:11:12.{40 * number:03d}\t",),
            "Y_Unit_Label\tg\tg\t", "X_Dimension\tTime\tTime\t", "X0\t0\t0\t",
            "Delta_X\t0.001\t0.001\t", "***End_of_Header***\t\t",
            "X_Value\tch1\tch2\tComment",
            *("\t" + "\t".join(f"{value:.6f}" for value in row) for row in half.T),
        ]  # fmt: skip
    head = [
        "LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t.",
        "Multi_Headings\tYes", "X_Columns\tNo", "***End_of_Header***\t",
    ]  # fmt: skip
    content = ("\n".join([*head, *lines]) + "\n").encode()
    return Seed(
        "segments.lvm", content, CHANNELS, values * STANDARD_GRAVITY, (), counted=False,
        stated=of_lines(content, b"Date", b"Time", b"X0"),
    )  # fmt: skip


def of_lines(content: bytes, *names: bytes) -> tuple[range, ...]:
    """Return where the lines with some names stand."""
    found, at = [], 0
    for line in content.splitlines(keepends=True):
        if line.split(b"\t")[0] in names:
            found.append(range(at - 1, at + len(line)))  # the line end before it too
        at += len(line)
    return tuple(found)


def universal_text(folder: Path) -> Seed:
    """Two records of data set 58 in the text form, 4E20.12."""
    return universal("text.uff", 12, even=True)


def universal_uneven(folder: Path) -> Seed:
    """Two records with their abscissa, 2(E13.5, E20.12), the last line filled with zeros."""
    return universal("uneven.uff", 18, even=False)


def universal(name: str, seed: int, *, even: bool) -> Seed:
    values, lines = numbers(seed)[:, : N_ROWS if even else N_ROWS - 1], []
    count = values.shape[1]
    for channel, row in zip(CHANNELS, values, strict=True):
        axis = f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} "
        lines += [
            "    -1", "    58", channel.ljust(80), "seed".ljust(80), "NONE".ljust(80),
            "NONE".ljust(80), "NONE".ljust(80),
            f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{1:10d}{0:4d} {'NONE':10}{0:10d}{0:4d}",
            f"{4:10d}{count:10d}{even:10d}{0.0:13.5e}{even / RATE:13.5e}{0.0:13.5e}",
            f"{axis}{'s':20}" if even else f"{17:10d}{axis[10:]}{'s':20}",
            f"{axis}{'g':20}", f"{axis}{'NONE':20}", f"{axis}{'NONE':20}",
        ]  # fmt: skip
        pieces = [f"{value:20.12e}" for value in row]
        if not even:
            times = [f"{i / RATE:13.5e}" for i in range(count)]
            pieces = [t + value for t, value in zip(times, pieces, strict=True)]
            pieces.append(f"{0.0:13.5e}{0.0:20.12e}")
        step = 4 if even else 2
        lines += ["".join(pieces[at : at + step]) for at in range(0, len(pieces), step)]
        lines.append("    -1")
    content = ("\n".join(lines) + "\n").encode()
    return Seed(name, content, CHANNELS, values * STANDARD_GRAVITY, ())


def numpy_archive(folder: Path) -> Seed:
    values, path = numbers(8), folder / "seed.npz"
    np.savez(path, t=np.arange(N_ROWS) / RATE, ch1_g=values[0], ch2_g=values[1])
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def numpy_array(folder: Path) -> Seed:
    """Fields of a structured array, of which one is the time."""
    values, path = numbers(24), folder / "fields.npy"
    rows = np.zeros(N_ROWS, [("t", "f8"), ("ch1_g", "f8"), ("ch2_g", "f8")])
    rows["t"], rows["ch1_g"], rows["ch2_g"] = np.arange(N_ROWS) / RATE, *values
    np.save(path, rows)
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def packed_archive(folder: Path) -> Seed:
    values, path = numbers(13), folder / "packed.npz"
    np.savez_compressed(path, fs=RATE, ch1_g=values[0], ch2_g=values[1])
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def matlab(folder: Path) -> Seed:
    values, path = numbers(14), folder / "packed.mat"
    content = {"fs": RATE, "ch1_g": values[0], "ch2_g": values[1].astype("f4")}
    scipy_io.savemat(path, content, do_compression=True)
    values[1] = values[1].astype("f4")
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def simulink(folder: Path) -> Seed:
    """A structure with time, with an array of signals."""
    values, path = numbers(19), folder / "simulink.mat"
    signals = np.zeros(2, dtype=[("values", object), ("label", object), ("units", object)])
    for number, name in enumerate(CHANNELS):
        signals[number] = (values[number][:, None], name, "g")
    times = np.arange(N_ROWS)[:, None] / RATE
    scipy_io.savemat(path, {"ScopeData": {"time": times, "signals": signals}})
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def matlab_7_3(folder: Path) -> Seed:
    values, path = numbers(15), folder / "hdf.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["fs"] = np.array([[RATE]])
        for name, row in zip(CHANNELS, values, strict=True):
            file[f"{name}_g"] = row[None]
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def hdf5_attributes(folder: Path) -> Seed:
    """Data sets beside each other, whose attributes say unit and rate."""
    values, path = numbers(22), folder / "attributes.h5"
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = RATE
        for name, row in zip(CHANNELS, values, strict=True):
            file[name] = row
            file[name].attrs["units"] = "g"
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def netcdf(folder: Path) -> Seed:
    """A time and two variables in packed pieces, as netCDF-4 lays them out."""
    values, path = numbers(23), folder / "packed.nc"
    with h5py.File(path, "w", libver="latest") as file:
        file["time"] = np.arange(N_ROWS) / RATE
        file["time"].attrs["units"] = "s"
        file["time"].make_scale("time")
        for name, row in zip(CHANNELS, values, strict=True):
            data = file.create_dataset(name, data=row, chunks=(32,), compression="gzip")
            data.attrs["units"] = "g"
            data.dims[0].attach_scale(file["time"])
    return Seed(path.name, taken(path), CHANNELS, values * STANDARD_GRAVITY, ())


def wave_file(folder: Path) -> Seed:
    """Two channels of 24 bits, written by the standard library."""
    path = folder / "whole.wav"
    numbers_24 = np.rint(numbers(20) * 2.0**20).astype("<i4")
    with wave.open(str(path), "wb") as file:
        file.setparams((2, 3, int(RATE), 0, "NONE", ""))
        file.writeframes(numbers_24.T.copy().view("u1").reshape(-1, 4)[:, :3].tobytes())
    return in_log(path, numbers_24 / 2.0**23)


def wave_of_floats(folder: Path) -> Seed:
    """Two channels of 32-bit floats, with the number of samples in a chunk of its own."""
    path, values = folder / "floats.wav", numbers(21).astype("f4")
    wavfile.write(path, int(RATE), values.T)
    return in_log(path, values.astype(float))


def in_log(path: Path, values: np.ndarray) -> Seed:
    """Return the seed of a file that knows neither names nor units [g]."""
    channels = ("channel 1", "channel 2")
    return Seed(path.name, taken(path), channels, values * STANDARD_GRAVITY, (), unit="g")


def stated_once(seed: Seed) -> Seed:
    """Return a seed of which the rate or step stands in one number."""
    numbers = (RATE, 1.0 / RATE)
    pieces = [struct.pack(kind, number) for kind in ("<d", ">d", "<f") for number in numbers]
    pieces += [f"{0.0:13.5e}{1.0 / RATE:13.5e}".encode(), b"sample_rate", b"1000"]
    found = (
        range(match.start(), match.end())
        for piece in pieces
        for match in re.finditer(re.escape(piece), seed.content)
    )
    return replace(seed, stated=(*seed.stated, *found))


def make_seeds(folder: Path) -> list[Seed]:
    """All seeds; those of TDMS first."""
    tdms = [contiguous(), one_chunk(), interleaved(), big_endian(), daqmx(), scaled()]
    endings = (".tdms", ".csv", ".mat", ".uff", ".parquet")
    others = [written(ending, number)(folder) for number, ending in enumerate(endings)]
    others = [one if one.name.endswith(".csv") else stated_once(one) for one in others]
    others[1] = replace(others[1], table=range(1, 1 + N_ROWS), counted=False)
    more = (
        csv, german_csv, labview_text, universal_text, numpy_archive, packed_archive, matlab,
        matlab_7_3, csv_below_statements, labview_segments, universal_uneven, simulink,
        wave_file, wave_of_floats, numpy_array, hdf5_attributes, netcdf,
    )  # fmt: skip
    rates = (packed_archive, matlab, matlab_7_3, universal_text, hdf5_attributes)
    made = [stated_once(m(folder)) if m in rates else m(folder) for m in more]
    return [*map(stated_once, tdms), *others, *made]
