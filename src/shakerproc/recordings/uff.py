"""Read UFF: the time records (dataset 58, text or binary)."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import ArraySource
from shakerproc.errors import RecordingError, SpectraError
from shakerproc.geometry.data_sets import DataSet, UffError, data_sets
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup
from shakerproc.recordings.time_axis import TimeAxis, half_digit
from shakerproc.recordings.time_base import ROUNDING
from shakerproc.recordings.uff_records import GENERAL, Record, record_of

LARGEST: Final = 1 << 30
KIND: Final = 58
FUNCTIONS: Final = (
    "functions of no stated type", "time responses", "auto spectra", "cross spectra",
    "frequency response functions", "transmissibilities", "coherences", "autocorrelations",
    "cross-correlations", "power spectral densities", "energy spectral densities",
    "probability densities", "spectra", "cumulative frequency distributions",
    "peaks and valleys", "stress cycles", "strain cycles", "orbits", "mode indicators",
    "force patterns", "partial powers", "partial coherences", "eigenvalues", "eigenvectors",
    "shock response spectra", "impulse responses of filters", "multiple coherences",
    "order functions", "phase compensations",
)  # fmt: skip
"""What the records of kind 58 hold, by the number of their type."""

_EXACT: Final = re.compile(r"sample rate ([0-9.eE+-]{1,30}) Hz")


def read_uff(path: Path, run: str) -> RawFile:
    """Return the time records of a universal file as channels.

    Raises
    ------
    RecordingError
        If it holds none, or a record is not as long as it says.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise RecordingError(
                f"{run}: more than {LARGEST >> 20} MB are too many to hold in memory. "
                "Export the recording as TDMS instead."
            )
        content = path.read_bytes()
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error
    try:
        found = list(data_sets(content))
        every = [record_of(content, one) for one in found if one.kind == KIND]
    except UffError as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error
    records = [record for record in every if record.is_recording]
    others = _told([r for r in every if not r.is_recording], found)
    if not records:
        message = (
            f"{run}: no time record (dataset 58 with function type 1, or 0 over a time); the "
            f"file holds {others or 'no datasets'}. Export the time histories, not the spectra."
        )
        raise SpectraError(message, others) if every else RecordingError(message)
    longest = max(record.promised for record in records)
    channels = tuple(
        _channel(record, name, row, longest)
        for row, (record, name) in enumerate(zip(records, _names(records), strict=True))
    )
    most = max(record.values.size for record in records)
    values = np.full((len(records), most), np.nan)
    for row, record in enumerate(records):
        values[row, : record.values.size] = record.values
    notes = [
        f"The file is not whole: it ends inside {shown(c.name)}, {c.n_samples} of "
        f"{c.promised} values."
        for c, record in zip(channels, records, strict=True)
        if record.cut
    ]
    general = sum(record.function == GENERAL for record in records)
    if general:
        notes.append(f"{general} records of no stated type are over a time: they are channels.")
    filled = sum(record.filled > 0 for record in records)
    if filled:
        notes.append(
            f"Zeros that only fill the last line of {filled} records, beyond the values that "
            "they promise, are left out."
        )
    if others:
        notes.append(f"Left out, no time records: {others}.")
    return RawFile((RawGroup("", channels),), ArraySource(values), tuple(notes))


def _told(records: Sequence[Record], found: Sequence[DataSet]) -> str:
    """Return how many records of what, and which other datasets, a file holds besides."""
    functions = Counter(
        ("complex " if r.is_complex and r.function <= 1 else "")
        + (FUNCTIONS[r.function] if r.function < len(FUNCTIONS) else f"type {r.function}")
        for r in records
    )
    kinds = Counter(one.kind for one in found if one.kind != KIND)
    parts = [f"{what} ({count})" for what, count in functions.items()]
    parts += [f"dataset {kind} ({count})" for kind, count in sorted(kinds.items())]
    return ", ".join(parts)


def _channel(record: Record, name: str, row: int, longest: int) -> RawChannel:
    """Return a record as a channel; where it does not say its length it is as the others."""
    return RawChannel(
        name=name,
        row=row,
        n_samples=record.values.size,
        promised=record.promised if record.promised >= 0 else max(longest, 1),
        unit="" if record.unit in {"NONE", "None"} else record.unit,
        axes=_axes(record, name),
    )


def _names(records: Sequence[Record]) -> list[str]:
    """Return the first description that tells the records apart."""
    told = [r for r in records if r.texts]
    for kind in ("id1", "place", "id4"):
        names = [{"id1": r.texts[0], "place": r.place, "id4": r.texts[3]}[kind] for r in told]
        if names and all(n and n != "NONE" for n in names) and len(set(names)) == len(names):
            rest = [f"record {number + 1}" for number in range(len(told), len(records))]
            return names + rest
    return [f"record {number + 1}" for number in range(len(records))]


def _axes(record: Record, name: str) -> tuple[TimeAxis, ...]:
    """Return what a record states of its abscissa; the format prints its step to six digits."""
    if not record.texts:
        return (TimeAxis("record", problem="the file ends inside its header"),)
    axis = TimeAxis(
        f"the step of record {shown(name, 30)}" if record.times is None
        else f"the abscissa of record {shown(name, 30)}",
        step=None if record.times is not None else record.step,
        times=record.times,
        start=record.start,
        quantity=record.abscissa,
        unit=record.abscissa_unit,
        digit=half_digit(record.step_text),
        start_digit=half_digit(record.start_text),
    )  # fmt: skip
    exact = _EXACT.search(record.texts[4])
    if exact is None or not _is_float(exact[1]) or record.times is not None:
        return (axis,)
    rate = float(exact[1])
    step = max(record.step, 0.0)
    if rate > 0.0 and abs(step * rate - 1.0) <= rate * axis.digit + ROUNDING:
        return (TimeAxis("id line 5", rate=rate), axis)
    return (axis,)


def _is_float(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
