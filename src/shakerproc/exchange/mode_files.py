"""Modes as other programs write them: a table, UFF data set 55, Nastran punch."""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError
from shakerproc.exchange.nastran_punch import COMPONENTS, read_modes

RIGID: Final = 1e-4
"""Frequency up to which a mode is one of a rigid body, over the highest of the file: what
rounding leaves of zero eigenvalues [-]."""

_FREQUENCY: Final = "frequency_hz"
_DAMPING: Final = "damping_ratio"
_PARTICIPATION: Final = "participation"
_MODES_55: Final = (2,)  # analysis: normal modes


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModeTable:
    """Modes of a file.

    Attributes
    ----------
    places : tuple of str
        Columns of the table, or nodes with their directions, such as ``12/z``.
    frequencies : (n_modes,) array
        0 of rigid-body modes [Hz].
    shapes : (n_places, n_modes) array
        Normalised for a unit mass of the file.
    damping_ratios : (n_modes,) array, optional
        None where the file has none [-].
    participations : (n_modes,) array, optional
        In a base acceleration; None where the file has none [root of its unit of mass].
    """

    places: tuple[str, ...]
    frequencies: FloatArray
    shapes: FloatArray
    damping_ratios: FloatArray | None = None
    participations: FloatArray | None = None


def read_mode_file(path: Path) -> ModeTable:
    """Return the modes that a file holds, by its ending.

    Raises
    ------
    ExchangeError
        If it holds none, or cannot be used.
    """
    found = READERS[path.suffix.lower()](path)
    highest = float(np.max(found.frequencies, initial=0.0))
    frequencies = np.where(found.frequencies < RIGID * highest, 0.0, found.frequencies)
    return ModeTable(
        found.places, frequencies, found.shapes, found.damping_ratios, found.participations
    )


def _read_table(path: Path) -> ModeTable:
    """Return the modes of a table: a row for each, a column for each place.

    Raises
    ------
    ExchangeError
        If it is none; the line is named.
    """
    try:
        rows = list(csv.reader(path.read_text("utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ExchangeError(f"{path.name}: cannot be read as a table: {error}") from error
    header = [name.strip() for name in rows[0]] if rows else []
    known = {_FREQUENCY, _DAMPING, _PARTICIPATION}
    places = tuple(name for name in header if name not in known)
    if _FREQUENCY not in header or not places or len(rows) < 2:
        raise ExchangeError(
            f"{path.name}: expected a table with a row for each mode and the columns "
            f"{_FREQUENCY}, {_DAMPING} and one for each point"
        )
    twice = next((name for name in header if header.count(name) > 1), None)
    if twice is not None:
        raise ExchangeError(f"{path.name}:1: the column {twice!r} stands twice")
    values = np.array([_numbers(path, i, row, header) for i, row in enumerate(rows[1:], 2)])
    columns = dict(zip(header, values.T, strict=True))
    return ModeTable(
        places,
        columns[_FREQUENCY],
        np.array([columns[name] for name in places]),
        columns.get(_DAMPING),
        columns.get(_PARTICIPATION),
    )


def _numbers(path: Path, line: int, row: Sequence[str], header: Sequence[str]) -> list[float]:
    """Return the numbers of a line of a table.

    Raises
    ------
    ExchangeError
        If one is none, or there are more or fewer than columns.
    """
    if len(row) != len(header):
        raise ExchangeError(f"{path.name}:{line}: {len(row)} values for {len(header)} columns")
    found = []
    for name, text in zip(header, row, strict=True):
        try:
            found.append(float(text))
        except ValueError:
            found.append(math.nan)
        if not math.isfinite(found[-1]):
            raise ExchangeError(
                f"{path.name}:{line}: expected a number for {name!r}, got {text!r}"
            )
    return found


def _read_uff(path: Path) -> ModeTable:
    """Return the normal modes of the data sets 55 of a universal file.

    Raises
    ------
    ExchangeError
        If it holds none, or shapes that are complex or of different nodes.
    """
    import pyuff  # a quarter of a second, for this format alone

    try:
        file = pyuff.UFF(str(path))
        every = [
            file.read_sets(int(i))
            for i in np.flatnonzero(np.asarray(file.get_set_types()) == 55)
        ]
    except Exception as error:  # pyuff raises what it likes
        raise ExchangeError(f"{path.name}: pyuff cannot read it: {error}") from error
    sets = [one for one in every if one["analysis_type"] in _MODES_55]
    if not sets:
        other = " (complex ones are not read)" if every else ""
        raise ExchangeError(f"{path.name}: no data set 55 with normal modes{other}")
    nodes = [int(node) for node in sets[0]["node_nums"]]
    for one in sets:
        if [int(node) for node in one["node_nums"]] != nodes:
            raise ExchangeError(
                f"{path.name}: mode {one['mode_n']} has other nodes than mode 1"
            )
        if np.iscomplexobj(one["r1"]) or not one["modal_m"] > 0.0:
            raise ExchangeError(
                f"{path.name}: mode {one['mode_n']} is complex or has no modal mass, so that "
                f"its shape cannot be normalised. Export real shapes with modal masses"
            )
    directions = COMPONENTS[: min(int(one["n_data_per_node"]) for one in sets)]
    shapes = np.array([_shape_55(one, len(directions)) for one in sets]).T
    return ModeTable(
        tuple(f"{node}/{axis}" for node in nodes for axis in directions),
        np.array([float(one["freq"]) for one in sets]),
        shapes,
        np.array([float(one["modal_damp_vis"]) for one in sets]),
    )


def _shape_55(one: Mapping[str, Any], count: int) -> FloatArray:
    """Return the mass-normalised shape of a data set, (n_nodes * count,) array."""
    parts = np.array([one[f"r{i + 1}"] for i in range(count)], float)
    return np.asarray(parts.T.ravel() / np.sqrt(float(one["modal_m"])))


def _read_punch(path: Path) -> ModeTable:
    """Return the eigenvectors of a punch file, as Nastran normalises them: for unit mass."""
    found = read_modes(path)
    places = tuple(f"{point}/{axis}" for point in found.points for axis in COMPONENTS)
    frequencies = np.sqrt(np.maximum(found.eigenvalues, 0.0)) / (2.0 * np.pi)
    return ModeTable(
        places, frequencies, np.asarray(found.values.real).reshape(len(places), -1)
    )


READERS: Final[Mapping[str, Callable[[Path], ModeTable]]] = MappingProxyType({
    ".csv": _read_table,
    ".uff": _read_uff,
    ".unv": _read_uff,
    ".pch": _read_punch,
})
"""Readers of files with modes, by their endings."""
