"""Properties and scaling of the channels, through npTDMS, which never sees the file itself."""

import io
import logging
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from nptdms import TdmsFile
from nptdms.base_segment import RawChannelDataChunk
from nptdms.log import log_manager
from nptdms.scaling import get_scaling
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, foreign, shown

MOST_SCALES: Final = 64
MOST_COEFFICIENTS: Final = 4096
RAW: Final = 0xFFFFFFFF
_ENTRY: Final = re.compile(
    r"Scale_Type|(?:Linear|Polynomial|RTD|Strain|Table|Thermistor|Thermocouple|Add|Subtract"
    r"|AdvancedAPI|Reciprocal|Map)_[A-Za-z0-9_ ]+(?:\[\d{1,4}\])?"
)
_TYPE: Final = re.compile(r"NI_Scale\[(\d+)\]_Scale_Type")
_SINGLE: Final = ("Linear", "Polynomial", "Table", "RTD", "Strain", "Thermistor")
"""Kinds of scales with one input."""

_warnings: ContextVar[list[str] | None] = ContextVar("npTDMS warnings", default=None)


def _keep(record: logging.LogRecord) -> bool:
    kept = _warnings.get()
    if kept is not None and record.levelno >= logging.WARNING:
        kept.append(record.getMessage())
    return kept is None


for _logger in log_manager.loggers.values():
    _logger.addFilter(_keep)


@contextmanager
def no_warnings(run: str) -> Iterator[None]:
    """Turn the warnings of npTDMS into an error.

    Raises
    ------
    RecordingError
        If npTDMS warned.
    """
    kept: list[str] = []
    token = _warnings.set(kept)
    try:
        yield
    finally:
        _warnings.reset(token)
    serious = [text for text in kept if not text.startswith("Error decoding string")]
    if serious:
        raise RecordingError(f"{run}: npTDMS warns: {shown(serious[0], 160)}. {AGAIN}")


@final
@dataclass(frozen=True, slots=True, eq=False)
class Scaling:
    """How raw numbers become values.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    steps : object, optional
        npTDMS' scaling; None where the raw numbers are the values.
    """

    run: str
    steps: Any = None

    def values(self, raw: Mapping[int | None, NDArray[Any]]) -> NDArray[Any]:
        """Return the values of raw numbers, given by the scale that they feed.

        Raw numbers are without unit [-], the values in that of the channel.
        """
        if self.steps is None:
            return next(iter(raw.values()))
        data = raw.get(None)
        chunk = (
            RawChannelDataChunk(None, dict(raw))
            if data is None
            else RawChannelDataChunk(data, None)
        )
        with foreign(self.run, "scaling the raw numbers"):
            scaled: NDArray[Any] = self.steps.scale(chunk)
        return scaled


Properties = Mapping[str, Any]


def read_properties(index: bytes, run: str) -> dict[str, Properties]:
    """Return the properties of every object, by path, from the metadata of the file."""
    with no_warnings(run), foreign(run, "reading the properties"):
        file = TdmsFile.read_metadata(io.BytesIO(index))
        properties: dict[str, Properties] = {"/": file.properties}
        for group in file.groups():
            properties[group.path] = group.properties
            properties |= {channel.path: channel.properties for channel in group.channels()}
    return properties


def read_scaling(
    run: str, where: str, levels: tuple[Properties, Properties, Properties]
) -> Scaling:
    """Return the scaling of a channel from its own properties, its group's and the file's.

    Raises
    ------
    RecordingError
        If the scales are more than a channel can have, feed on themselves or miss a number.
    """
    for properties in levels:
        problem = scale_problem(properties)
        if problem:
            raise RecordingError(f"{run}: channel {shown(where)}: {problem}. {AGAIN}")
    with no_warnings(run), foreign(run, f"reading the scales of channel {shown(where)}"):
        return Scaling(run, get_scaling(*levels))


def scale_problem(properties: Properties) -> str:
    """Return the fault in the scales of an object; empty where there is none."""
    count = properties.get("NI_Number_Of_Scales", MOST_SCALES)
    if not isinstance(count, int | float) or not 0 <= count <= MOST_SCALES:
        return f"NI_Number_Of_Scales is {shown(count, 30)}; 0 to {MOST_SCALES} are possible"
    for name, value in properties.items():
        if name.startswith("NI_Scale["):
            problem = _entry_problem(name, value, int(count))
            if problem:
                return problem
    return _link_problem(properties)


def _entry_problem(name: str, value: Any, count: int) -> str:
    """Return the fault in one property of a scale."""
    number, _, entry = name[9:].partition("]_")
    if not number.isdecimal() or len(number) > 4 or int(number) >= count:
        return f"{shown(name)} is a scale beyond the {count} that there should be"
    if _ENTRY.fullmatch(entry) is None:
        return f"{shown(name)} is no property of a scale"
    if entry.endswith("_Size") and not _is_count(value):
        return f"{shown(name)} is {shown(value, 30)}; 0 to {MOST_COEFFICIENTS} are possible"
    if entry.endswith("Input_Source") and value != RAW and not _is_below(value, int(number)):
        return f"{shown(name)} is {shown(value, 30)}; a scale can only use one before it"
    if isinstance(value, float) and not math.isfinite(value):
        return f"{shown(name)} is {value}"
    return ""


def _link_problem(properties: Properties) -> str:
    """Return which scale after the first names no source, or an empty text.

    npTDMS would take the raw numbers for it.
    """
    for name, kind in properties.items():
        match = _TYPE.fullmatch(name)
        if match is None or match[1] == "0" or kind not in _SINGLE:
            continue
        if f"NI_Scale[{match[1]}]_{kind}_Input_Source" not in properties:
            return f"scale {match[1]} does not say what it scales"
    return ""


def unused_scales(properties: Properties) -> list[int]:
    """Return the scales whose result nothing uses, though one of their kind is never written.

    The last scale gives the values; every other should lead to it.
    """
    matches = [_TYPE.fullmatch(name) for name in properties]
    typed = {int(match[1]) for match in matches if match is not None}
    if properties.get("NI_Scaling_Status") == "scaled" or not typed:
        return []
    used = {
        v for n, v in properties.items() if n.startswith("NI_Scale[") and "Input_Source" in n
    }
    return sorted(typed - used - {max(typed)})


def _is_count(value: object) -> bool:
    return isinstance(value, int | np.integer) and 0 <= int(value) <= MOST_COEFFICIENTS


def _is_below(value: object, number: int) -> bool:
    return isinstance(value, int | np.integer) and 0 <= int(value) < number
