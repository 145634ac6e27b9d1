"""``python -m tests.recordings.every_format``: each format against another reader of it.

Writes the same two channels in each format, by another program where there is one, prints what
shakerproc reads, whether it equals what another reader reads to the last digit, and whether
`inspect`, `process`, `batch`, `watch` and `convert` took it. ``--only wav xlsx`` takes some.
"""

import argparse
import contextlib
import io
import sys
import tempfile
import wave
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from scipy import signal
from scipy.io import wavfile
from tests.recordings.recorder_files import (
    atfx,
    atfx_component,
    atfx_explicit,
    write_famos,
    write_ide,
    write_mdf,
)
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.recordings import open_recording
from shakerproc.recordings.opening import read_whole
from shakerproc.recordings.raw import Sampling

RATE, N = 2000.0, 16_000
NAMES = ("control", "response")


def signals() -> np.ndarray:
    """Noise and what a resonator of 200 Hz makes of it, below 1 (2, N)."""
    noise = np.random.default_rng(44).standard_normal(N)
    b, a = signal.iirpeak(200.0, 20.0, fs=RATE)
    both = np.array([noise, signal.lfilter(b, a, noise) * 3.0])
    return 0.9 * both / np.abs(both).max()


class Format(NamedTuple):
    """One format: file name, who writes it, who else reads it, and how.

    `write` takes the path and the values; `read` takes the path and returns the values in the
    unit of the file, by the other reader.
    """

    name: str
    writer: str
    reader: str
    write: Callable[[Path, np.ndarray], None]
    read: Callable[[Path], Any]
    log: str = ""
    options: tuple[str, ...] = ()


def wav(kind: str) -> Callable[[Path, np.ndarray], None]:
    def write(path: Path, values: np.ndarray) -> None:
        scaled = {"int16": 2.0**15, "int32": 2.0**31, "float32": 1.0}[kind]
        wavfile.write(path, int(RATE), (values.T * scaled).astype(kind))

    return write


def wav24(path: Path, values: np.ndarray) -> None:
    counts = (values.T * 2.0**23).astype("<i4")
    with wave.open(str(path), "wb") as file:
        file.setparams((2, 3, int(RATE), N, "NONE", ""))
        file.writeframes(
            np.ascontiguousarray(counts).view("u1").reshape(-1, 4)[:, :3].tobytes()
        )


def by_soundfile(form: str, subtype: str) -> Callable[[Path, np.ndarray], None]:
    def write(path: Path, values: np.ndarray) -> None:
        import soundfile

        soundfile.write(path, values.T, int(RATE), format=form, subtype=subtype)

    return write


def read_sound(path: Path) -> np.ndarray:
    import soundfile

    return soundfile.read(path, dtype="float64")[0].T


def hdf5(path: Path, values: np.ndarray) -> None:
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = RATE
        for name, row in zip(NAMES, values, strict=True):
            file[name] = row
            file[name].attrs["units"] = "g"


def read_pyfive(path: Path) -> np.ndarray:
    import pyfive

    with pyfive.File(path) as file:
        return np.array([file[name][:] for name in NAMES])


def netcdf(path: Path, values: np.ndarray) -> None:
    import netCDF4

    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("time", N)
        times = file.createVariable("time", "f8", ("time",))
        times.units = "seconds since 2024-05-06 07:08:09"
        times[:] = np.arange(N) / RATE
        for name, row in zip(NAMES, values, strict=True):
            file.createVariable(name, "f8", ("time",), zlib=True)[:] = row
            file[name].units = "g"


def read_netcdf(path: Path) -> np.ndarray:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return np.array([file[name][:] for name in NAMES])


def frame(values: np.ndarray, *, time: bool = True) -> Any:
    import pandas as pd

    columns = {f"{name} [g]": row for name, row in zip(NAMES, values, strict=True)}
    return pd.DataFrame(({"time [s]": np.arange(N) / RATE} if time else {}) | columns)


def of_frame(read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    return lambda path: read(path)[[f"{name} [g]" for name in NAMES]].to_numpy().T


def pandas_does(name: str, **options: Any) -> Callable[[Path], Any]:
    def read(path: Path) -> Any:
        import pandas as pd

        return getattr(pd, name)(path, **options)

    return read


def two_rates(path: Path, values: np.ndarray) -> None:
    slow = values[:, ::4]
    with path.open("w") as file:
        file.write("Time [s],control [g],Time [s],response [g]\n")
        for i in range(N):
            there = i < slow.shape[1]
            late = f"{i / RATE * 4!r},{float(slow[1, i])!r}" if there else ","
            file.write(f"{i / RATE!r},{float(values[0, i])!r},{late}\n")


def uff(path: Path, values: np.ndarray) -> None:
    import pyuff

    sets = [
        pyuff.prepare_58(
            binary=1, func_type=1, id1=name, ver_num=0, load_case_id=0, num_pts=N,
            ord_data_type=4, orddenom_spec_data_type=0, rsp_node=i + 1, rsp_dir=3,
            rsp_ent_name=name,
            ref_ent_name="NONE", ref_node=0, ref_dir=0, data=row, x=np.arange(N) / RATE,
            abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=1.0 / RATE,
            abscissa_spec_data_type=17, abscissa_axis_units_lab="s",
            ordinate_spec_data_type=12, ordinate_axis_units_lab="g",
        )
        for i, (name, row) in enumerate(zip(NAMES, values, strict=True))
    ]  # fmt: skip
    with contextlib.redirect_stdout(io.StringIO()):
        pyuff.UFF(str(path)).write_sets(sets, "add")


def read_uff(path: Path) -> np.ndarray:
    import pyuff

    return np.array([one["data"] for one in pyuff.UFF(str(path)).read_sets()])


def npy(path: Path, values: np.ndarray) -> None:
    np.save(path, values.T)


def mdf(path: Path, values: np.ndarray) -> None:
    times, start = np.arange(N) / RATE, datetime(2024, 5, 6, 7, 8, 9, tzinfo=UTC)
    channels = [(n, "g", times, row) for n, row in zip(NAMES, values, strict=True)]
    write_mdf(path, [channels], start)


def read_mdf(path: Path) -> np.ndarray:
    import mdfreader

    file = mdfreader.Mdf(str(path))
    return np.array([file.get_channel_data(name) for name in NAMES])


def ide(path: Path, values: np.ndarray) -> None:
    write_ide(path, [(8, "A", "g", NAMES, RATE, values.astype("f4"))], 1714979289)


def read_ide(path: Path) -> np.ndarray:
    """Samples as their blocks hold them, by the parser of elements alone."""
    import idelib
    from ebmlite import loadSchema

    schema = loadSchema(str(Path(idelib.__file__).parent / "schemata" / "mide_ide.xml"))
    with schema.load(str(path)) as file:
        blocks = [one.dump() for one in file if one.name == "ChannelDataBlock"]
    parts = [np.frombuffer(bytes(one["ChannelDataPayload"]), "<f4") for one in blocks]
    return np.concatenate(parts).reshape(-1, len(NAMES)).T


def famos(path: Path, values: np.ndarray) -> None:
    write_famos(
        path, [(n, "g", row) for n, row in zip(NAMES, values, strict=True)], 1.0 / RATE,
        (6, 5, 2024, 7, 8, 9.25),
    )  # fmt: skip


def read_famos(path: Path) -> np.ndarray:
    """Samples as the last block holds them, of the layout that the writer gives it."""
    stored = path.read_bytes()[-1 - 8 * N * len(NAMES) : -1]
    return np.frombuffer(stored, "<f8").reshape(len(NAMES), N)


def rpc3(path: Path, values: np.ndarray) -> None:
    import rpc3 as package

    package.rpc3.progressbar = False
    channels = [
        package.Channel(name=name, unit="g", dt=1.0 / RATE, data=row)
        for name, row in zip(NAMES, values, strict=True)
    ]
    package.write(str(path), channels, datatype=int, pts_per_group=256)


def read_rpc3(path: Path) -> np.ndarray:
    import rpc3 as package

    package.rpc3.progressbar = False
    return np.array([np.asarray(one.data) for one in package.read(str(path))[0]])


def ods(path: Path, values: np.ndarray) -> None:
    binary = path.with_suffix(".btf")
    binary.write_bytes(values[1].astype("<f8").tobytes())
    there = f"<Werte>{atfx_component('B', 'ieeefloat8', N, 0, 8, 0)}</Werte>"
    columns = [
        ("time", "s", "Time", (0.0, 1.0 / RATE)),
        (NAMES[0], "g", "acceleration", atfx_explicit(values[0])),
        (NAMES[1], "g", "acceleration", f"<Art>explicit</Art>{there}"),
    ]
    path.write_text(
        atfx([("part", N, columns)], begin="20240506070809", files={"B": binary.name})
    )


def read_ods(path: Path) -> np.ndarray:
    from odsbox.proto import ods_pb2
    from wodson.atfx import AtfxStore

    with AtfxStore(path) as store:
        kinds = store.model().entities.values()
        kind = next(one for one in kinds if one.base_name == "AoLocalColumn")
        wanted = next(k for k, a in kind.attributes.items() if a.base_name == "values")
        statement = ods_pb2.SelectStatement()
        statement.columns.add(aid=kind.aid, attribute=wanted)
        (column,) = store.data_read(statement).matrices[0].columns
        arrays = column.unknown_arrays.values  # noqa: PD011  of a protocol buffer
        found = [list(one.double_array.values) for one in arrays]
        return np.array([one for one in found if len(one) == N])


_SAID = ", unit: g"
FORMATS: Mapping[str, Format] = {
    "WAV, 16 bits": Format("a.wav", "scipy", "soundfile", wav("int16"), read_sound, _SAID),
    "WAV, 24 bits": Format("a.wav", "wave", "soundfile", wav24, read_sound, _SAID),
    "WAV, 32 bits": Format("a.wav", "scipy", "soundfile", wav("int32"), read_sound, _SAID),
    "WAV, floats": Format("a.wav", "scipy", "soundfile", wav("float32"), read_sound, _SAID),
    "RF64, 24 bits": Format(
        "a.rf64", "soundfile", "soundfile", by_soundfile("RF64", "PCM_24"), read_sound, _SAID
    ),
    "HDF5": Format("a.h5", "h5py", "pyfive", hdf5, read_pyfive),
    "netCDF-4": Format("a.nc", "netCDF4", "netCDF4", netcdf, read_netcdf),
    "XLSX": Format(
        "a.xlsx", "pandas", "pandas", lambda p, v: frame(v).to_excel(p, index=False),
        of_frame(pandas_does("read_excel")),
    ),
    "CSV of two rates": Format(
        "a.csv", "own", "pandas", two_rates,
        of_frame(pandas_does("read_csv")),
        options=("--resample-hz", "2000"),
    ),
    "UFF 58, type 1, binary": Format("a.uff", "pyuff", "pyuff", uff, read_uff),
    ".npy": Format(
        "a.npy", "NumPy", "NumPy", npy, lambda p: np.load(p).T, _SAID,
        ("--sample-rate-hz", "2000"),
    ),
    "Feather": Format(
        "a.feather", "pandas", "pandas", lambda p, v: frame(v).to_feather(p),
        of_frame(pandas_does("read_feather")),
    ),
    "MDF 4": Format("a.mf4", "asammdf", "mdfreader", mdf, read_mdf),
    "enDAQ IDE": Format("a.ide", "ebmlite", "ebmlite, block by block", ide, read_ide),
    "imc FAMOS": Format(
        "a.raw", "byte by byte", "NumPy, at the last block", famos, read_famos
    ),
    "MTS RPC III": Format("a.rsp", "rpc3-file", "rpc3-file", rpc3, read_rpc3),
    "ASAM ATFX": Format("a.atfx", "byte by byte", "wodson", ods, read_ods),
}  # fmt: skip


def equal(path: Path, one: Format) -> str:
    """Return whether values equal those of another reader, in the unit of the file."""
    try:
        other = np.asarray(one.read(path), dtype=np.float64)
    except ImportError as error:
        return f"{error.name} not installed"
    raw = read_whole(path).raw
    each = [channel for channel in raw.groups[0].channels if not channel.problem]
    ours = [raw.source.read([channel.row], 0, channel.n_samples)[0] for channel in each]
    pairs = [(row, line[: row.size]) for row, line in zip(ours, other, strict=True)]
    if all(np.array_equal(row, line) for row, line in pairs):
        return "yes"
    alike = all(np.array_equal(row.astype("f4"), line.astype("f4")) for row, line in pairs)
    return "as single, which it rounds to" if alike else "no"


def commands(path: Path, one: Format, folder: Path) -> str:
    """Return which of the five commands took a file, and what the others said."""
    keys = {
        ".npy": ("a 1", "a 2"), ".wav": ("channel 1", "channel 2"),
        ".rf64": ("channel 1", "channel 2"),
    }.get(path.suffix, NAMES)  # fmt: skip
    more = {"--sample-rate-hz": "sample_rate: 2000 Hz", "--resample-hz": "resample: 2000 Hz"}
    processing = more[one.options[0]] if one.options else ""
    (folder / "testlog.yaml").write_text(
        "testlog: 1\nrecordings: .\nchannels:\n"
        f'  "{keys[0]}": {{role: control{one.log}}}\n'
        f'  "{keys[1]}": {{role: response{one.log}}}\n'
        + (f"processing: {{{processing}}}\n" if processing else "")
        + f"tests:\n  - {{id: 1, recording: {path.name}}}\n"
    )
    log, out = str(folder / "testlog.yaml"), str(folder / "out")
    calls = {
        "inspect": [str(path), *one.options],
        "process": [str(path), "--log", log, "--out", f"{out}/p", "--no-figures"],
        "batch": [log, "--out", f"{out}/b", "--no-figures", "--workers", "1"],
        "watch": [str(folder), "--log", log, "--out", f"{out}/w", "--settle", "0.1", "--every",
                  "0.1", "--idle", "1", "--workers", "1"],
        "convert": [str(path), f"{out}/c.h5", *one.options],
    }  # fmt: skip
    told = []
    for name, words in calls.items():
        done = CliRunner().invoke(build_app(), [name, *words])
        if done.exit_code:
            told.append(f"{name}: {done.exit_code} {done.output.strip().splitlines()[-1:]}")
    return "; ".join(told) or "all five"


def row(kind: str, one: Format, *, with_commands: bool) -> list[str]:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / one.name
        try:
            one.write(path, signals())
        except ImportError as error:
            return [kind, one.writer, f"{error.name} not installed"]
        told = equal(path, one)
        rate = RATE if "--sample-rate-hz" in one.options else None
        resample = RATE if "--resample-hz" in one.options else None
        with open_recording(path, sample_rate=Sampling(rate=rate, resample=resample)) as found:
            start = f"{found.start_time:%Y-%m-%d %H:%M:%S.%f}" if found.start_time else "-"
            units = found.channels[0].source_unit or "-"
            said = [
                str(found.n_samples),
                f"{found.sample_rate:g}",
                start.removesuffix(".000000"),
            ]
        done = commands(path, one, Path(name)) if with_commands else "not asked"
        return [kind, one.writer, one.reader, told, *said, units, done]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=[], help="parts of names of formats")
    parser.add_argument("--quick", action="store_true", help="without the commands")
    options = parser.parse_args()
    heads = ("format", "writer", "other reader", "equal", "rows", "rate [Hz]", "start", "unit",
             "inspect, process, batch, watch, convert")  # fmt: skip
    sys.stdout.write(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}\n")
    bad = 0
    for kind, one in FORMATS.items():
        if options.only and not any(part.lower() in kind.lower() for part in options.only):
            continue
        cells = row(kind, one, with_commands=not options.quick)
        bad += "no" in cells or cells[-1] not in {"all five", "not asked"}
        sys.stdout.write(f"| {' | '.join(cells)} |\n")
        sys.stdout.flush()
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
