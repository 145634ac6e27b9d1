"""Read response functions, or the spectra of which they are made, from a table or a MAT file.

A column of a table is a part of a function: ``12/z to 1/z real [m/s^2/N]``, ``... imag``, or
``... magnitude`` and ``... phase [deg]``; ``... coherence`` belongs to it. A cross spectrum has
the parts ``12/z to 1/z cross real [m/s^2*N/Hz]`` and ``... imag``, an auto spectrum is
``1/z auto [N^2/Hz]``.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.matlab import mat_variables
from shakerproc.recordings.opening import READERS
from shakerproc.recordings.raw import RawChannel, RawFile
from shakerproc.recordings.response_functions import Function, FunctionFile, Kind

_FREQUENCY: Final = re.compile(
    r"(?:frequency|freq|f)\s*(?:_hz|[\[(]\s*hz\s*[\])])?", re.IGNORECASE
)
_COLUMN: Final = re.compile(
    r"(?P<response>.+?)(?:\s+(?:to|over)\s+(?P<input>.+?))?[\s,:]+(?P<cross>cross\s+)?"
    r"(?P<part>real|re|imag(?:inary)?|im|magnitude|mag|abs|amplitude|phase|coherence|auto|psd)"
    r"\.?\s*(?:[\[(](?P<unit>.*)[\])])?",
    re.IGNORECASE,
)
_PARTS: Final = {
    "re": "real", "im": "imag", "imaginary": "imag", "mag": "magnitude", "abs": "magnitude",
    "amplitude": "magnitude", "psd": "auto",
}  # fmt: skip
_LAYOUT: Final = (
    "Expected a column frequency [Hz], and for each function columns such as "
    "'12/z to 1/z real [m/s^2/N]' and '12/z to 1/z imag', or magnitude and phase [deg]"
)
_ALONE: Final[Mapping[str, Kind]] = {"coherence": "coherence", "auto": "auto spectrum"}
"""Parts that are a whole function."""

_ARRAYS: Final = {
    "frequency": ("frequency", "freq", "f", "frequency_hz"),
    "values": ("frf", "h", "h1", "frfs", "functions"),
    "coherence": ("coherence", "coh", "gamma2"),
    "cross": ("cross", "gyx", "gxy", "csd"),
    "auto": ("auto", "gxx", "psd"),
}  # fmt: skip


_Key: TypeAlias = tuple[str, str, Kind]
"""Response, input and kind of a function."""


@final
@dataclass(slots=True, eq=False)
class _Parts:
    """The columns of a function: which, and in which unit."""

    columns: dict[str, int] = field(default_factory=dict)
    unit: str = ""
    angle: str = "deg"


def read_table_functions(path: Path, run: str) -> FunctionFile:
    """Return the functions of a table, of text or of whatever a recording may be a table of.

    Raises
    ------
    RecordingError
        If it is no such table.
    """
    raw = READERS[path.suffix.lower()](path, run)
    try:
        return _of_table(raw, run)
    finally:
        raw.source.close()


def _of_table(raw: RawFile, run: str) -> FunctionFile:
    """Return the functions of a table that is open.

    Raises
    ------
    RecordingError
        If it holds no frequencies, no functions, or columns of several lengths.
    """
    if raw.refusal:
        raise RecordingError(f"{run}: {raw.refusal} Repair the file.")
    channels = [c for c in raw.groups[0].channels if c.row >= 0]
    at = next((c for c in channels if _FREQUENCY.fullmatch(c.alias or c.name)), None)
    if at is None:
        raise RecordingError(f"{run}: no column of frequencies. {_LAYOUT}.")
    found, others = _columns([c for c in channels if c is not at])
    if not found:
        raise RecordingError(
            f"{run}: no response functions in the columns {', '.join(others[:8])}. {_LAYOUT}."
        )
    if short := [c.name for c in channels if c.n_samples != at.n_samples]:
        raise RecordingError(f"{run}: {shown(short[0])} is shorter than other columns. {AGAIN}")
    values = raw.source.read(range(1 + max(c.row for c in channels)), 0, at.n_samples)
    functions = [
        _of_parts(key, parts, values, values[at.row], run) for key, parts in found.items()
    ]
    notes = [f"Columns that are no response functions: {', '.join(others[:20])}."]
    return FunctionFile(tuple(functions), {}, tuple(notes * bool(others)))


def _columns(
    channels: Sequence[RawChannel],
) -> tuple[dict[_Key, _Parts], list[str]]:
    """Return the columns of each function, and the columns of none."""
    by_key: dict[_Key, _Parts] = {}
    others = []
    for channel in channels:
        header = channel.alias or channel.name
        match = _COLUMN.fullmatch(header)
        part = match["part"].lower() if match else ""
        part = _PARTS.get(part, part)
        if match is None or (match["input"] is None) != (part == "auto"):
            others.append(shown(header, 40))
            continue
        kind = _ALONE.get(part, "cross spectrum" if match["cross"] else "response function")
        key = match["response"], match["input"] or match["response"], kind
        parts = by_key.setdefault(key, _Parts())
        parts.columns[part] = channel.row
        unit = (match["unit"] or channel.unit).strip()
        if part == "phase":
            parts.angle = unit or "deg"
        elif unit:
            parts.unit = unit
    return by_key, others


def _of_parts(
    key: _Key, parts: _Parts, values: FloatArray, lines: FloatArray, run: str
) -> Function:
    """Return the function that columns are parts of.

    Raises
    ------
    RecordingError
        If a part is missing.
    """
    there, (response, driven, kind) = parts.columns, key
    where = f"{response} to {driven}"
    up, down = _UNITS[kind](parts.unit)
    if kind in _ALONE.values():
        (row,) = there.values()
        complex_values: ComplexArray = values[row].astype(np.complex128)
    elif {"real", "imag"} <= set(there):
        complex_values = values[there["real"]] + 1j * values[there["imag"]]
    elif {"magnitude", "phase"} <= set(there):
        turn = np.pi / 180.0 if parts.angle.casefold().startswith("deg") else 1.0
        complex_values = values[there["magnitude"]] * np.exp(1j * turn * values[there["phase"]])
    else:
        raise RecordingError(f"{run}: {where} has only {', '.join(there)}. {_LAYOUT}.")
    return Function(where, kind, response, driven, up, down, lines, complex_values)


def units_of(ratio: str) -> tuple[str, str]:
    """Return the units of response and input in one of a function.

    Examples
    --------
    >>> units_of("m/s^2/N"), units_of("(m/s^2)/N"), units_of("g/g"), units_of("")
    (('m/s^2', 'N'), ('m/s^2', 'N'), ('g', 'g'), ('', ''))
    """
    up, _, down = ratio.replace(" per ", "/").rpartition("/")
    return up.strip(" ()"), down.strip(" ()")


def _units_of_cross(product: str) -> tuple[str, str]:
    """Return the units of response and input in one of a cross spectrum, ``m/s^2*N/Hz``."""
    plain = re.sub(r"\s*/\s*hz$", "", product.strip(), flags=re.IGNORECASE)
    match = re.fullmatch(r"(.+?)\s*[*·\s]\s*([^*·\s]+)", plain)
    return (match[1].strip(" ()"), match[2].strip(" ()")) if match else ("", "")


def _units_of_auto(square: str) -> tuple[str, str]:
    """Return the unit of a channel, twice, in that of its auto spectrum, ``N^2/Hz``."""
    match = re.fullmatch(r"(.+?)(?:\^2|²)(?:\s*/\s*hz)?", square.strip(), re.IGNORECASE)
    return (match[1].strip(" ()"),) * 2 if match else ("", "")


_UNITS: Final[Mapping[Kind, Callable[[str], tuple[str, str]]]] = {
    "response function": units_of, "coherence": units_of, "cross spectrum": _units_of_cross,
    "auto spectrum": _units_of_auto,
}  # fmt: skip


def read_mat_functions(path: Path, run: str) -> FunctionFile:
    """Return the functions of a MAT file: an array of them, and a vector of frequencies.

    The array ``frf`` (or ``H``) has an axis for the frequencies, ``f``, and before or behind it
    one for the responses and perhaps one for the inputs; ``coherence`` likewise. In place of
    ``frf`` there may be cross spectra ``Gyx``, likewise, and auto spectra ``Gxx`` of inputs.
    Texts ``responses``, ``inputs``, ``response_unit`` and ``input_unit`` name them.

    Raises
    ------
    RecordingError
        If it holds no such arrays.
    """
    content = mat_variables(path, run)
    by_name = {name.casefold(): value for name, value in content.items()}
    arrays = {
        what: next((by_name[name] for name in names if name in by_name), None)
        for what, names in _ARRAYS.items()
    }
    lines, auto = arrays["frequency"], arrays["auto"]
    kind: Kind = "response function" if _is_numeric(arrays["values"]) else "cross spectrum"
    values = arrays["values" if kind == "response function" else "cross"]
    if not _is_numeric(lines) or not _is_numeric(values):
        raise RecordingError(
            f"{run}: expected an array frf (or H) of response functions, or Gyx and Gxx of "
            "spectra, and a vector f of frequencies [Hz]. The file holds "
            f"{', '.join(sorted(content))[:160]}."
        )
    frequency = np.asarray(lines, dtype=np.float64).reshape(-1)
    shape = _with_lines_last(np.asarray(values), frequency.size, run).shape
    names = [
        [text or f"{key} {i}" for i, text in enumerate(_texts(by_name, key, count), 1)]
        for key, count in zip(("response", "input"), shape, strict=False)
    ]
    units = [
        _texts(by_name, f"{key}_unit", len(of))
        for key, of in zip(("response", "input"), names, strict=True)
    ]
    functions = list(_cells(values, frequency, names, units, kind, run))
    if _is_numeric(arrays["coherence"]):
        functions += _cells(arrays["coherence"], frequency, names, units, "coherence", run)
    if kind == "cross spectrum" and _is_numeric(auto):
        of = [names[1], [""]], [units[1], [""]]
        functions += _cells(auto, frequency, *of, "auto spectrum", run)
    return FunctionFile(tuple(functions), {})


def _is_numeric(array: Any) -> bool:
    return isinstance(array, np.ndarray) and array.dtype.kind in "iufc"


def _with_lines_last(values: NDArray[Any], n: int, run: str) -> ComplexArray:
    """Return functions as (n_responses, n_inputs, n_lines).

    Raises
    ------
    RecordingError
        If not exactly one end of the axes is as long as there are frequencies.
    """
    shape = values.shape
    if len(shape) not in {2, 3} or (shape[0] == n) == (shape[-1] == n):
        raise RecordingError(
            f"{run}: the functions are {' x '.join(map(str, shape))} numbers for {n} "
            "frequencies. Save them as frequencies x responses x inputs."
        )
    if shape[0] == n:
        values = np.moveaxis(values, 0, -1)
    return values.reshape(values.shape[0], -1, n).astype(np.complex128)


def _texts(content: Mapping[str, Any], key: str, count: int) -> list[str]:
    """Return the texts of each channel of a side; empty ones where there are none."""
    value = next((content[name] for name in (key, f"{key}s") if name in content), None)
    texts = [text.strip() for text in value] if isinstance(value, list) else []
    if len(texts) == 1:
        texts *= count
    return texts if len(texts) == count else [""] * count


def _cells(  # noqa: PLR0917
    values: Any,
    lines: FloatArray,
    names: Sequence[Sequence[str]],
    units: Sequence[Sequence[str]],
    kind: Kind,
    run: str,
) -> Iterator[Function]:
    """Yield the functions of an array.

    Raises
    ------
    RecordingError
        If it has others than the names.
    """
    matrix = _with_lines_last(np.asarray(values), lines.size, run)
    count = len(names[0]), len(names[1])
    if matrix.shape[:2] != count:
        raise RecordingError(
            f"{run}: {kind} of {matrix.shape[0]} x {matrix.shape[1]} channels beside functions "
            f"of {count[0]} x {count[1]}. Save both for the same channels."
        )
    for response, up, row in zip(names[0], units[0], matrix, strict=True):
        for driven, down, one in zip(names[1], units[1], row, strict=True):
            where = f"{response} to {driven}"
            yield Function(where, kind, response, driven, up, down, lines, one)
