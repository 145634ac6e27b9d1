"""Read UFF: the time records (dataset 58, text or binary) through pyuff."""

import math
import re
from collections import Counter
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc.data import ArraySource
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, foreign, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup

LARGEST: Final = 1 << 30
TIME_RESPONSE: Final = 1
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
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error
    records, others = _records(path, run)
    if not records:
        raise RecordingError(
            f"{run}: no time record (dataset 58, function type 1) among {others} datasets. "
            "Export the time histories, not the spectra."
        )
    names = _names(records)
    channels = []
    for row, (record, name) in enumerate(zip(records, names, strict=True)):
        promised = int(record["num_pts"])
        if record["data"].size > promised:
            raise RecordingError(
                f"{run}: record {shown(name)} holds {record['data'].size} values but says "
                f"{promised}. {AGAIN}"
            )
        rate, problem = _rate(record)
        channels.append(
            RawChannel(
                name=name,
                row=row,
                n_samples=record["data"].size,
                promised=promised,
                unit=_unit(record),
                sample_rate=rate,
                rate_problem=problem,
            )
        )
    longest = max(record["data"].size for record in records)
    values = np.full((len(records), longest), np.nan)
    for row, record in enumerate(records):
        values[row, : record["data"].size] = record["data"]
    notes = []
    if others:
        notes.append(f"{others} datasets that are no time records are left out.")
    if any(c.n_samples < c.promised for c in channels):
        notes.append("The file is not whole: a record is shorter than it says.")
    return RawFile((RawGroup("", tuple(channels)),), ArraySource(values), tuple(notes))


def _records(path: Path, run: str) -> tuple[list[dict[str, Any]], int]:
    """Return the time records and how many other datasets there are."""
    import pyuff

    with foreign(run, "reading the datasets"):
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
        records = []
        for number, kind in enumerate(kinds):
            if kind != 58:
                continue
            record = file.read_sets(number)
            if record["func_type"] == TIME_RESPONSE and not np.iscomplexobj(record["data"]):
                records.append(record)
    return records, len(kinds) - len(records)


def _names(records: list[dict[str, Any]]) -> list[str]:
    """Return the first description that tells the records apart."""
    for field in ("id1", "rsp_ent_name", "id4"):
        names = [str(record.get(field, "")).strip() for record in records]
        if all(name and name != "NONE" for name in names) and max(Counter(names).values()) == 1:
            return names
    return [f"record {number + 1}" for number in range(len(records))]


def _unit(record: dict[str, Any]) -> str:
    text = str(record.get("ordinate_axis_units_lab", "")).strip()
    return "" if text in {"NONE", "None"} else text


def _rate(record: dict[str, Any]) -> tuple[float | None, str]:
    """Return the rate of an evenly spaced record; the format rounds its step to six digits."""
    step = float(record["abscissa_inc"])
    if record["abscissa_spacing"] != 1 or not math.isfinite(step) or step <= 0.0:
        return None, f"the step of record {shown(record['id1'], 30)} is {step:g} s"
    rate = 1.0 / step
    doubt = 0.5e-5 / (step / 10.0 ** math.floor(math.log10(step))) + 1e-12
    exact = _EXACT.search(str(record.get("id5", "")))
    candidates = [float(exact[1])] if exact and _is_float(exact[1]) else []
    candidates.append(float(round(rate)))
    for candidate in candidates:
        if candidate > 0.0 and abs(rate / candidate - 1.0) <= doubt:
            return candidate, ""
    return rate, ""


def _is_float(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
