"""Modes as other programs write them: table, UFF data set 55, Nastran punch, OP2, CalculiX."""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import ExchangeError
from shakerproc.exchange.calculix import CalculixModes, read_dat, read_frd
from shakerproc.exchange.modes import (
    COMPONENTS,
    DAMPING,
    FREQUENCY,
    PARTICIPATION,
    ModeTable,
)
from shakerproc.exchange.nastran_op2 import read_op2
from shakerproc.exchange.nastran_punch import read_modes
from shakerproc.geometry import Place
from shakerproc.geometry.data_sets import UffError, data_sets
from shakerproc.geometry.universal import Units, units_of, wireframe_of

RIGID: Final = 1e-4
"""Frequency up to which a mode is one of a rigid body, over the highest of the file: what
rounding leaves of zero eigenvalues [-]."""

_NORMAL, _COMPLEX = 2, 3  # analyses of data set 55 with modes

REAL: Final = 0.8
"""Least share of a complex shape that is real in the phase of its modal A: consistent-mode
indicators of 80 % and more are modes identified with high confidence (R. S. Pappa, K. B.
Elliott and A. Schenk, J. Guidance, Control, Dynamics 16, 852-858, 1993) [-]."""


def read_mode_file(path: Path) -> ModeTable:
    """Return the modes that a file holds, by its ending.

    Raises
    ------
    ExchangeError
        If it holds none, or cannot be used.
    """
    table = READERS[path.suffix.lower()](path)
    highest = float(np.max(table.frequencies, initial=0.0))
    frequencies = np.where(table.frequencies < RIGID * highest, 0.0, table.frequencies)
    return replace(table, frequencies=frequencies)


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
    known = {FREQUENCY, DAMPING, PARTICIPATION}
    places = tuple(name for name in header if name not in known)
    if FREQUENCY not in header or not places or len(rows) < 2:
        raise ExchangeError(
            f"{path.name}: expected a table with a row for each mode and the columns "
            f"{FREQUENCY}, {DAMPING} and one for each point"
        )
    twice = next((name for name in header if header.count(name) > 1), None)
    if twice is not None:
        raise ExchangeError(f"{path.name}:1: the column {twice!r} stands twice")
    values = np.array([_numbers(path, i, row, header) for i, row in enumerate(rows[1:], 2)])
    columns = dict(zip(header, values.T, strict=True))
    return ModeTable(
        places,
        columns[FREQUENCY],
        np.array([columns[name] for name in places]),
        columns.get(DAMPING),
        {"": columns[PARTICIPATION]} if PARTICIPATION in columns else {},
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
    values = []
    for name, text in zip(header, row, strict=True):
        try:
            values.append(float(text))
        except ValueError:
            values.append(math.nan)
        if not math.isfinite(values[-1]):
            raise ExchangeError(
                f"{path.name}:{line}: expected a number for {name!r}, got {text!r}"
            )
    return values


def _read_uff(path: Path) -> ModeTable:
    """Return the modes of the data sets 55 of a universal file; normal ones, else complex ones.

    Raises
    ------
    ExchangeError
        If it holds none, or shapes that cannot be scaled, are not real or of different nodes.
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
    kinds = [[one for one in every if one["analysis_type"] == k] for k in (_NORMAL, _COMPLEX)]
    sets = kinds[0] or kinds[1]
    if not sets:
        raise ExchangeError(f"{path.name}: no data set 55 with normal or complex modes")
    nodes = [int(node) for node in sets[0]["node_nums"]]
    for one in sets:
        if [int(node) for node in one["node_nums"]] != nodes:
            raise ExchangeError(
                f"{path.name}: mode {one['mode_n']} has other nodes than mode 1"
            )
    directions = COMPONENTS[: min(int(one["n_data_per_node"]) for one in sets)]
    of_kind = _normal_mode if kinds[0] else _complex_mode
    frequencies, damping, shapes = zip(
        *(of_kind(path, one, len(directions)) for one in sets), strict=True
    )
    positions, units = _geometry(path, nodes, directions)
    return ModeTable(
        tuple(f"{node}/{axis}" for node in nodes for axis in directions),
        np.array(frequencies),
        np.array(shapes).T / np.sqrt(units.mass),
        np.array(damping),
        positions=positions,
        units="SI" if units.said else "nothing",
    )


def _normal_mode(
    path: Path, one: Mapping[str, Any], count: int
) -> tuple[float, float, FloatArray]:
    """Return frequency [Hz], damping ratio and mass-normalised shape of a normal mode.

    Raises
    ------
    ExchangeError
        If it is complex or has no modal mass.
    """
    if np.iscomplexobj(one["r1"]) or not one["modal_m"] > 0.0:
        raise ExchangeError(
            f"{path.name}: mode {one['mode_n']} is complex or has no modal mass, so that "
            f"its shape cannot be normalised. Export real shapes with modal masses"
        )
    shape = _shape_55(one, count).real / np.sqrt(float(one["modal_m"]))
    return float(one["freq"]), float(one["modal_damp_vis"]), shape


def _complex_mode(
    path: Path, one: Mapping[str, Any], count: int
) -> tuple[float, float, FloatArray]:
    r"""Return frequency [Hz], damping ratio and mass-normalised shape of a complex mode.

    .. math:: \phi = \psi \sqrt{2 i \operatorname{Im} \lambda / a}

    by modal A of the receptance :math:`\psi \psi / (a (i \omega - \lambda))`.

    Raises
    ------
    ExchangeError
        If modal A is 0, or the mode is no real one.
    """
    where, pole = f"{path.name}: mode {one['mode_n']}", complex(one["eig"])
    if not one["modal_a"] or not pole.imag > 0.0:
        raise ExchangeError(
            f"{where} has no modal A, so that its shape is not scaled. Measure force and "
            f"acceleration in one place (driving point), and give both its position in the log"
        )
    shape = _shape_55(one, count) * np.sqrt(2j * pole.imag / complex(one["modal_a"]))
    real = float(np.sum(shape.real**2) / np.sum(np.abs(shape) ** 2))
    if real < REAL:
        raise ExchangeError(
            f"{where} at {abs(pole) / (2.0 * np.pi):.4g} Hz is real to {real:.0%} only, and "
            f"modes of a structure are real. Leave it out of the file"
        )
    return abs(pole) / (2.0 * np.pi), -pole.real / abs(pole), shape.real


def _shape_55(one: Mapping[str, Any], count: int) -> ComplexArray:
    """Return the shape of a data set as it stands, (n_nodes * count,) array."""
    return np.array([one[f"r{i + 1}"] for i in range(count)], complex).T.ravel()


def _geometry(
    path: Path, nodes: Sequence[int], directions: Sequence[str]
) -> tuple[dict[str, Place], Units]:
    """Return where places are [m], and the units of the file.

    Places are those of nodes whose axes are those of the whole structure.

    Raises
    ------
    ExchangeError
        If the geometry of the file is not what it says, or the file is cut off.
    """
    content = path.read_bytes()
    try:
        uff_sets = list(data_sets(content))
        units = units_of(content, uff_sets)
        wireframe, _ = wireframe_of(content, uff_sets, units)
    except UffError as error:
        raise ExchangeError(f"{path.name}: {error}") from error
    if uff_sets[-1].cut:
        line = content.count(b"\n", 0, uff_sets[-1].start)
        raise ExchangeError(
            f"{path.name}:{line}: the file is cut off in this data set; write it again"
        )
    known = [n for n in nodes if n in wireframe.nodes and n not in wireframe.axes]
    places = {f"{node}/{axis}": wireframe.nodes[node] for node in known for axis in directions}
    return places, units


def _read_punch(path: Path) -> ModeTable:
    """Return the eigenvectors of a punch file, as Nastran normalises them: for unit mass."""
    punched = read_modes(path)
    places = tuple(f"{point}/{axis}" for point in punched.points for axis in COMPONENTS)
    frequencies = np.sqrt(np.maximum(punched.eigenvalues, 0.0)) / (2.0 * np.pi)
    shapes = np.asarray(punched.values.real).reshape(len(places), -1)
    return ModeTable(places, frequencies, shapes, units="no units")


def _read_op2(path: Path) -> ModeTable:
    """Return the eigenvectors of an OP2 file, for unit mass."""
    modes = read_op2(path)
    places = tuple(f"{node}/{axis}" for node in modes.nodes for axis in COMPONENTS)
    return ModeTable(
        places,
        modes.frequencies,
        modes.shapes.reshape(len(places), -1),
        positions={
            f"{node}/{axis}": place
            for node, place in modes.positions.items()
            for axis in COMPONENTS
        },
        units="no units",
    )


def _of_calculix(read: Callable[[Path], CalculixModes]) -> Callable[[Path], ModeTable]:
    """Return a reader of modes that CalculiX normalised: for unit mass."""

    def reader(path: Path) -> ModeTable:
        table = read(path)
        directions = COMPONENTS[: table.shapes.shape[1]]
        return ModeTable(
            tuple(f"{node}/{axis}" for node in table.nodes for axis in directions),
            table.frequencies,
            table.shapes.reshape(-1, table.frequencies.size),
            participations=table.participations,
            positions={
                f"{node}/{axis}": table.positions[node]
                for node in table.nodes
                if node in table.positions
                for axis in directions
            },
            units="no units",
        )

    return reader


READERS: Final[Mapping[str, Callable[[Path], ModeTable]]] = MappingProxyType({
    ".csv": _read_table,
    ".uff": _read_uff,
    ".unv": _read_uff,
    ".pch": _read_punch,
    ".op2": _read_op2,
    ".frd": _of_calculix(read_frd),
    ".dat": _of_calculix(read_dat),
})
"""Readers of files with modes, by their endings."""
