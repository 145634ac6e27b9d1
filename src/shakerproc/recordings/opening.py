"""Open a recording, whatever its format: by the readers of shakerproc and of packages."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import units
from shakerproc.data import (
    BadRows,
    Channel,
    ChannelUse,
    FloatArray,
    Recording,
    SampleSource,
    SkippedRows,
    SourceFile,
)
from shakerproc.errors import RecordingError
from shakerproc.late import loaded, without
from shakerproc.recordings.choosing import (
    WHOLE,
    Chosen,
    FilePart,
    choose_channels,
    choose_part,
    missing_channels,
    unused_channels,
    with_numbers,
)
from shakerproc.recordings.guard import AGAIN, first_bytes, foreign, kept_open, shown
from shakerproc.recordings.own_process import opened_apart
from shakerproc.recordings.raw import AS_STATED, RawChannel, RawFile, RawGroup, Reader, Sampling
from shakerproc.recordings.resampling import ResampledSource, common_length, resampled_length
from shakerproc.recordings.si import UnitScale, doubtful_units, scale_of
from shakerproc.recordings.source_files import FileHash, WatchedFile, open_regular
from shakerproc.recordings.time_base import CLOCKS
from shakerproc.recordings.timing import Timing, common_timing, with_time_bases

GROUP: Final = "shakerproc.readers"
"""Entry points of packages that bring readers: the name is the ending of the files, without its
dot, and the value a function from the path and the name of the run to a `RawFile`."""


_ROOM: Final = "shakerproc.recordings"
_INSTEAD: Final = "export it as TDMS, HDF5 or CSV"


@final
@dataclass(frozen=True, slots=True)
class FormatReader:
    """Reader of a format, loaded when a file of it is opened.

    Attributes
    ----------
    endings : str
        Of the files, in small letters.
    place : str
        Of the function from path and run to a `RawFile`, below `shakerproc.recordings`.
    packages : str
        The module of others that reads the files, and what it loads besides.
    name, extra : str
        The format, and the extra that brings the module; empty where shakerproc needs it.
    own_process : bool
        Whether a process of its own reads each file: what is not Python may end it.
    """

    endings: str
    place: str
    packages: str = ""
    name: str = ""
    extra: str = ""
    own_process: bool = False

    def __call__(self, path: Path, run: str) -> RawFile:
        """Return the channels of a file.

        Raises
        ------
        RecordingError
            If it cannot be read, or the package is not installed.
        """
        module = self.packages.split()[0].partition(".")[0] if self.extra else ""
        if module and (lacks := without(module, self.name, self.extra, _INSTEAD)):
            raise RecordingError(f"{run}: {lacks}")
        place = f"{_ROOM}.{self.place}"
        if self.own_process:
            return opened_apart(path, run, place, *self.packages.split())
        raw_file: RawFile = loaded(place)(path, run)
        return raw_file


@final
class Readers(Mapping[str, Reader]):
    """Readers of files, by the ending in small letters.

    Those of installed packages are looked for when all are listed, or when an ending is asked
    for that shakerproc does not know.
    """

    def __init__(self, formats: Sequence[FormatReader]) -> None:
        self._known = {ending: one for one in formats for ending in one.endings.split()}
        self._installed: dict[str, EntryPoint] | None = None

    def __getitem__(self, ending: str) -> Reader:
        if ending not in self._known:
            return of_entry(self._entries()[ending])
        return self._known[ending]

    def __iter__(self) -> Iterator[str]:
        return iter({**self._known, **self._entries()})

    def __len__(self) -> int:
        return len({**self._known, **self._entries()})

    @property
    def known(self) -> Mapping[str, FormatReader]:
        """The readers of shakerproc itself, by ending."""
        return dict(self._known)

    def _entries(self) -> dict[str, EntryPoint]:
        """Return the first entry point for each ending that shakerproc does not read."""
        if self._installed is None:
            entries: dict[str, EntryPoint] = {}
            for entry in entry_points(group=GROUP):
                ending = f".{entry.name.lower()}"
                if ending not in self._known:
                    entries.setdefault(ending, entry)
            self._installed = entries
        return self._installed


def of_entry(entry: EntryPoint) -> Reader:
    """Return the reader that an entry point names, whatever it raises turned into one line.

    Raises
    ------
    RecordingError
        If it cannot be loaded, or is no function.
    """
    where = f"entry point {entry.name} ({entry.value})"
    try:
        reader = entry.load()
    except Exception as error:
        text = " ".join(str(error).split()) or "no reason given"
        raise RecordingError(
            f"{where}: {type(error).__name__}: {text}. Correct the package, or remove it."
        ) from error
    if not callable(reader):
        raise RecordingError(f"{where}: is no function. Name one that reads a file.")
    return _guarded(reader, where)


def _guarded(reader: Callable[[Path, str], object], where: str) -> Reader:
    """Return a reader whose failures are one line that says where."""

    def read(path: Path, run: str) -> RawFile:
        with foreign(run, where):
            made = reader(path, run)
        if isinstance(made, RawFile):
            return made
        raise RecordingError(
            f"{run}: {where}: returned {type(made).__name__}, not a RawFile of "
            "shakerproc.recordings.raw. Correct the package."
        )

    return read


def read_dat(path: Path, run: str) -> RawFile:
    """Return the channels of a file of MDF 2 or 3, of imc FAMOS, or else of a table of text.

    These formats share the ending; their first bytes tell them apart.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    start = first_bytes(path, run, 8)
    ending = next((of[0] for mark, of in BEGINNINGS.items() if start.startswith(mark)), "")
    return READERS[ending if ending in {".mf4", ".raw"} else ".csv"](path, run)


_ARROW: Final = "pyarrow.parquet pandas pint"

READERS: Final = Readers((
    FormatReader(".tdms", "tdms.reader:read_tdms"),
    FormatReader(".csv .txt", "csv:read_csv"),
    FormatReader(".dat", "opening:read_dat"),
    FormatReader(".lvm", "lvm:read_lvm"),
    FormatReader(".mat", "matlab:read_mat"),
    FormatReader(".npz", "numpy_file:read_npz"),
    FormatReader(".npy", "numpy_file:read_npy"),
    FormatReader(".uff .unv .uf58", "uff:read_uff"),
    FormatReader(
        ".parquet", "parquet:read_parquet", _ARROW, "Parquet", "parquet", own_process=True
    ),
    FormatReader(
        ".feather .arrow",
        "feather:read_feather",
        _ARROW,
        "Feather",
        "parquet",
        own_process=True,
    ),
    FormatReader(".h5 .hdf5 .nc .nc4", "hdf5:read_hdf5", "h5py", own_process=True),
    FormatReader(".xlsx", "csv:read_xlsx", "openpyxl", "XLSX", "xlsx"),
    FormatReader(".mf4 .mdf", "mdf:read_mdf", "asammdf", "MDF", "recorders", own_process=True),
    FormatReader(".ide", "ide:read_ide", "idelib", "IDE", "recorders"),
    FormatReader(
        ".raw", "famos:read_famos", "imctermite", "imc FAMOS", "recorders", own_process=True
    ),
    FormatReader(".rsp .rpc .rpc3", "rpc3:read_rpc3"),
    FormatReader(".wav .rf64", "wav:read_wav"),
    FormatReader(".atfx", "atfx:read_atfx"),
))
"""What opens a file, by its ending in small letters, below `shakerproc.recordings`."""


BEGINNINGS: Final = {
    b"TDSm": (".tdms",), b"PAR1": (".parquet",), b"ARROW1": (".feather", ".arrow"),
    b"\x89HDF": (".h5", ".hdf5", ".nc", ".nc4", ".mat"), b"MATLAB ": (".mat",),
    b"MDF ": (".mf4", ".mdf", ".dat"), b"UnFinMF ": (".mf4", ".mdf", ".dat"),
    b"|CF,": (".raw", ".dat"), b"\x1aE\xdf\xa3": (".ide",), b"RIFF": (".wav",),
    b"FORMAT\0": (".rsp", ".rpc", ".rpc3"), b"\x93NUMPY": (".npy",), b"LabVIEW": (".lvm",),
    b"    -1\n": (".uff", ".unv", ".uf58"), b"    -1\r": (".uff", ".unv", ".uf58"),
    b"PK\x03\x04": (".xlsx", ".npz"),
}  # fmt: skip
"""How files of a format begin, with the endings that have it read."""

_REMEDY: Final = (
    "Repair the file, or have such rows skipped: processing: {bad_rows: skip} in the log (or "
    "--bad-rows skip)."
)
NO_ROLE: Final = "no role fits its unit; a log can give it one"
IGNORED: Final = "role: ignore in the log"

Decision: TypeAlias = Callable[[RawGroup, Sequence[ChannelUse] | None], Sequence[ChannelUse]]
"""From a group and what the log says to what its channels are used as."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ScaledSource(SampleSource):
    """Samples of another source, each row times a factor and from a sample of its own on."""

    source: SampleSource
    factors: FloatArray
    begins: NDArray[np.int64]
    file: SourceFile

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        with np.errstate(all="ignore"):  # what is no number stays none; health says so
            samples = self._placed(rows, start, stop)
            for line, factor in enumerate(self.factors[list(rows)]):
                if factor != 1.0:
                    samples[line] *= factor
        return samples

    def _placed(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        """Return samples, each row shifted to the first of the common rows."""
        begins = self.begins[list(rows)]
        if not begins.size or np.all(begins == begins[0]):
            shift = int(begins[0]) if begins.size else 0
            return self.source.read(rows, start + shift, stop + shift)
        out = np.empty((len(rows), max(0, stop - start)))
        for begin in np.unique(begins):
            same_start = np.flatnonzero(begins == begin).tolist()
            out[same_start] = self.source.read(
                [rows[i] for i in same_start], start + int(begin), stop + int(begin)
            )
        return out

    def close(self) -> None:
        """Close the other source, and the file that was watched."""
        self.source.close()
        self.file.close()


@final
@dataclass(frozen=True, slots=True, eq=False)
class WholeFile:
    """A file that was read once, for whatever is to be known of it.

    Attributes
    ----------
    path : Path
        The file.
    run : str
        Opens every message.
    file : WatchedFile
        The file, watched.
    raw : RawFile
        What its format says.
    """

    path: Path
    run: str
    file: WatchedFile
    raw: RawFile

    @property
    def contents(self) -> tuple[tuple[RawGroup, ...], tuple[str, ...]]:
        """The groups as the file describes them, and notes."""
        raw = with_time_bases(self.raw, AS_STATED)
        return raw.groups, raw.notes


def read_whole(
    path: Path | str, *, run: str | None = None, hashed: bool | Sequence[FileHash] = False
) -> WholeFile:
    """Return a file as it is, read or opened once; arguments as of `open_recording`.

    Raises
    ------
    RecordingError
        If it cannot be read, or changes meanwhile.
    """
    path = Path(path)
    name = run or path.name
    reader = _reader(path, name)
    file = WatchedFile(path, name, hashed=hashed)
    return kept_open(
        file, lambda file: WholeFile(path, name, file, _unchanged(reader, file, path, name))
    )


def open_recording(
    path: Path | str,
    *,
    uses: Sequence[ChannelUse] | None = None,
    decide: Decision | None = None,
    sample_rate: float | Sampling | None = None,
    part: FilePart = WHOLE,
    run: str | None = None,
    hashed: bool | Sequence[FileHash] = False,
    bad_rows: BadRows = "refuse",
) -> Recording:
    """Return the recording in a file; its samples are read when they are asked for, in SI.

    Parameters
    ----------
    path : Path or str
        The file; its ending says the format.
    uses : sequence of ChannelUse, optional
        What the log says of the channels; by default all channels of the group that hold
        numbers are served, unknown units as they stand in the file.
    decide : callable, optional
        From the group and `uses` to what its channels are used as, where the log does not say
        it all.
    sample_rate : float or Sampling, optional
        What the log says [Hz], which counts where the file does not say it; or all that the
        log says of the time axis.
    part : FilePart
        Which group and measurement, where the file holds several.
    run : str, optional
        Opens every message; by default the name of the file.
    hashed : bool or sequence of Seen
        Whether to hash the file before anything of it is read, so that what is made of it can
        be filed under `Recording.sha256`; or hashes that are known, as `WatchedFile` takes.
    bad_rows : str
        ``refuse`` a text file with lines that are no rows of numbers, or ``skip`` them.

    Raises
    ------
    RecordingError
        If the file cannot be used as the log wants it, or changes meanwhile. One line that
        names the file, the place, and what to do.
    """
    return recording_in(
        read_whole(path, run=run, hashed=hashed), uses=uses, decide=decide,
        sample_rate=sample_rate, part=part, bad_rows=bad_rows,
    )  # fmt: skip


def recording_in(
    whole: WholeFile,
    *,
    uses: Sequence[ChannelUse] | None = None,
    decide: Decision | None = None,
    sample_rate: float | Sampling | None = None,
    part: FilePart = WHOLE,
    bad_rows: BadRows = "refuse",
) -> Recording:
    """Return the recording in a file that was read, as `open_recording` does.

    Raises
    ------
    RecordingError
        If the file cannot be used as the log wants it, or changes meanwhile.
    """
    path, name, file, raw = whole.path, whole.run, whole.file, whole.raw
    try:
        said = sample_rate if isinstance(sample_rate, Sampling) else Sampling(sample_rate)
        raw = with_time_bases(raw, said)
        if raw.skipped is not None and bad_rows != "skip":
            raise RecordingError(f"{name}: {raw.refusal} {_REMEDY}")
        among, note = choose_part(raw, part, uses, name)
        wanted = uses if decide is None else decide(among, uses)
        chosen = choose_channels(among, wanted, name)
        recording = _recording(path, name, raw, file, chosen, said)
        unused = unused_channels(
            raw, among, chosen, wanted, NO_ROLE if uses is None else IGNORED
        )
        return replace(
            recording,
            in_file=len(with_numbers(among)),
            unused=unused,
            notes=(*recording.notes, *([note] if note else []), *_absent(among, wanted)),
        )
    except BaseException:
        raw.source.close()
        file.close()
        raise


def _absent(among: RawGroup, said: Sequence[ChannelUse] | None) -> list[str]:
    """Return which channels of every test this recording goes without."""
    absent = missing_channels(among, said or ())
    if not absent:
        return []
    names = ", ".join(shown(use.key) for use in absent)
    return [f"Channels of the log that this recording has not were left out: {names}."]


def _unchanged(reader: Reader, file: WatchedFile, path: Path, run: str) -> RawFile:
    """Return a file, opened; where reading fails as it changed meanwhile, that is the error.

    Raises
    ------
    RecordingError
        If it cannot be used; where it begins like a file of another ending, for that.
    """
    try:
        return reader(path, run)
    except RecordingError as error:
        file.check()
        start, ending = first_bytes(path, run, 16), path.suffix.lower()
        known = next((of for mark, of in BEGINNINGS.items() if start.startswith(mark)), None)
        if known is None or ending in known or ending not in READERS.known:
            raise
        raise RecordingError(
            f"{run}: begins like a file of the ending {known[0]}, not of {path.suffix}. Rename "
            "it, or export it again."
        ) from error


def contents(path: Path | str) -> tuple[tuple[RawGroup, ...], tuple[str, ...]]:
    """Return the groups of a file as it describes them, and notes: also of an unusable one.

    Raises
    ------
    RecordingError
        If the file cannot be read at all.
    """
    whole = read_whole(path)
    try:
        return whole.contents
    finally:
        whole.raw.source.close()
        whole.file.close()


def _reader(path: Path, run: str) -> Reader:
    if path.is_dir():
        raise RecordingError(f"{run}: {path} is a folder. Give a recording inside it.")
    if not path.exists():
        raise RecordingError(f"{run}: no file {path}{_near(path)}")
    open_regular(path, run).close()
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise RecordingError(
            f"{run}: no reader for {path.suffix or 'a file without ending'}. "
            f"Shakerproc reads {', '.join(READERS)}; export the recording as one of these, or "
            "rename it to .txt where it is a table of text."
        )
    if not path.stat().st_size:
        raise RecordingError(f"{run}: the file is empty (0 bytes). {AGAIN}")
    return reader


def _near(path: Path) -> str:
    try:
        names = sorted(entry.name for entry in path.parent.iterdir())
    except OSError:
        return ", and no such folder either."
    near = units.near_miss(path.name, names)
    return f"; did you mean {shown(near)}?" if near else "."


def _lower_rates(timing: Timing, count: int) -> list[float | None]:
    """Return the rate of each channel that was taken at a lower one than is served [Hz]."""
    if not timing.lines:
        return [None] * count
    # a clock that is a little slow makes no channel a slow one
    slow = timing.sample_rate * (1.0 - CLOCKS)
    return [line.rate if line.rate < slow else None for line in timing.lines]


def _recording(  # noqa: PLR0917
    path: Path,
    run: str,
    raw: RawFile,
    file: SourceFile,
    chosen: Sequence[Chosen],
    said: Sampling,
) -> Recording:
    timing = common_timing(chosen, said, run)
    n_samples, expected, length_note = (
        (*resampled_length(chosen, timing.lines, timing.start, timing.sample_rate), "")
        if timing.lines
        else common_length(chosen, timing.begins, run)
    )
    scales = [scale_of(channel, use, run) for channel, use in chosen]
    rows = [channel.row for channel, _ in chosen]
    factors, begins = np.ones(1 + max(rows)), np.zeros(1 + max(rows), dtype=np.int64)
    factors[rows] = [scale.factor for scale in scales]
    begins[rows] = timing.begins
    source = raw.source
    if timing.lines:
        of_rows = dict(zip(rows, timing.lines, strict=True))
        source = ResampledSource(source, of_rows, timing.sample_rate, timing.start)
    notes = [*raw.notes, *timing.notes, length_note, *(scale.note for scale in scales)]
    notes += doubtful_units(chosen)
    return Recording(
        run=run,
        channels=tuple(
            replace(_channel(channel, use, scale), own_rate=rate)
            for (channel, use), scale, rate in zip(
                chosen, scales, _lower_rates(timing, len(chosen)), strict=True
            )
        ),
        sample_rate=timing.sample_rate,
        rate_doubtful=timing.doubtful,
        rate_doubt=timing.doubt,
        n_samples=n_samples,
        source=ScaledSource(source, factors, begins, file),
        rows=tuple(rows),
        path=path,
        start_time=timing.start_time,
        expected_samples=expected,
        skipped=_placed(raw.skipped, timing),
        notes=tuple(note for note in notes if note),
        file=file,
    )


def _placed(skipped: SkippedRows | None, timing: Timing) -> SkippedRows | None:
    """Return where bad rows lie among the common rows."""
    if skipped is None:
        return None
    first, last = timing.of_common(skipped.first), timing.of_common(skipped.last)
    return replace(skipped, first=first, last=last)


def _channel(channel: RawChannel, use: ChannelUse | None, scale: UnitScale) -> Channel:
    return Channel(
        name=(use.name if use else None) or channel.name,
        unit=scale.unit,
        source_name=channel.name,
        source_unit=scale.said,
        role=use.role if use else None,
        at=use.at if use else None,
        uncertainty=use.calibration.uncertainty if use and use.calibration else None,
    )
