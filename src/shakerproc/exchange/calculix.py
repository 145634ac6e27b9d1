"""Modes of CalculiX: its result file (.frd) and its printed output (.dat).

Shapes are for a unit mass, in the units of the input file, which neither states.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError

AXES: Final = ("x", "y", "z")
_HEAD: Final = re.compile(rb"^( {4}2C| {2}100C| -4 | {4}1PSTEP).*$", re.MULTILINE)
_END: Final = b"9999"  # the last line of a result file
_BEFORE, _WIDTH = 13, 12  # a mark of three and a node of ten characters, then the numbers
_WORDS: Final = {
    "eigenvalues": "E I G E N V A L U E   O U T P U T",
    "participations": "P A R T I C I P A T I O N   F A C T O R S",
    "shape": "E I G E N V A L U E    N U M B E R",
}
_SAME_RUN: Final = 1e-4
"""Departure of the frequencies of both files of a run: five digits after the point [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class CalculixModes:
    """Modes of a run.

    Attributes
    ----------
    nodes : tuple of int
        Those whose displacements were asked for.
    frequencies : (n_modes,) array
        [Hz].
    shapes : (n_nodes, 3, n_modes) array
        Along the global axes [1 / root of its unit of mass].
    positions : mapping of int to (x, y, z)
        Of all nodes of a result file [its unit of length].
    participations : mapping of str to (n_modes,) array
        In the motion of a base along ``x``, ``y`` or ``z``, where they were printed [root of
        its unit of mass].
    """

    nodes: tuple[int, ...]
    frequencies: FloatArray
    shapes: FloatArray
    positions: Mapping[int, tuple[float, float, float]]
    participations: Mapping[str, FloatArray]


@final
@dataclass(frozen=True, slots=True)
class _ResultFile:
    """A result file, and the message of its fault."""

    path: Path
    content: bytes

    def error(self, place: int, message: str) -> ExchangeError:
        line = self.content.count(b"\n", 0, place) + 1
        return ExchangeError(f"{self.path.name}:{line}: {message}")

    def block(self, after: int, count: int) -> tuple[FloatArray, FloatArray]:
        """Return nodes and three numbers of each from the first line that holds some.

        Raises
        ------
        ExchangeError
            If there are fewer than promised, or not in the columns of the format.
        """
        start = self.content.find(b"\n -1", after) + 1
        length = self.content.find(b"\n", start) + 1 - start
        lines = self.content[start : start + count * length]
        ended = self.content[start + count * length :].lstrip(b" ").startswith(b"-3")
        try:
            lines = lines if start > 0 and ended else b""
            nodes = _numbers_of(lines, 3, _BEFORE - 3, 1)[:, 0]
            return nodes, _numbers_of(lines, _BEFORE, _WIDTH, 3)
        except ValueError:
            raise self.error(
                after,
                f"not {count} nodes with three numbers each before the end of the block: the "
                f"file is cut off, damaged or binary. Let CalculiX write it again, as text",
            ) from None


def read_frd(path: Path) -> CalculixModes:
    """Return the modes of a result file, with participations of the printed file beside it.

    Raises
    ------
    ExchangeError
        If it holds none, is damaged or cut off; the line is named.
    """
    file = _ResultFile(path, _content(path))
    mode_shapes, steps = list(_shapes(file)), set(_steps(file))
    if file.content.rstrip().rpartition(b"\n")[2].strip() != _END:
        raise file.error(
            len(file.content.rstrip()),
            "the file is cut off: it does not end with 9999. Let CalculiX write it again, "
            "as text",
        )
    if not mode_shapes:
        raise ExchangeError(
            f"{path.name}: no displacements of modes; ask for them with U below *NODE FILE in "
            f"a step with *FREQUENCY"
        )
    if len(steps) > 1:
        raise ExchangeError(
            f"{path.name}: results of {len(steps)} steps; keep the step with *FREQUENCY alone"
        )
    nodes = mode_shapes[0][1]
    for i, (_, other, _) in enumerate(mode_shapes, 1):
        if not np.array_equal(nodes, other):
            raise ExchangeError(f"{path.name}: mode {i} has other nodes than mode 1")
    frequencies = np.array([one[0] for one in mode_shapes])
    printed = path.with_suffix(".dat")
    shares = _participations(printed, frequencies) if printed.is_file() else {}
    shapes = np.stack([shape for _, _, shape in mode_shapes], axis=-1)
    return CalculixModes(
        tuple(map(int, nodes)), frequencies, shapes, _positions(file), shares
    )  # fmt: skip


def read_dat(path: Path) -> CalculixModes:
    """Return the modes of a printed file: of the nodes that *NODE PRINT names, with U.

    Raises
    ------
    ExchangeError
        If it holds none, or is cut off.
    """
    lines = _content(path).decode("ascii", "replace").splitlines()
    frequencies, shares = _tables(path, lines)
    wanted = [i for i, line in enumerate(lines) if _WORDS["shape"] in line]
    shapes = [_rows(lines, at) for at in wanted]
    count = len(shapes[0]) if shapes else 0
    if not count or len(shapes) != frequencies.size or {len(s) for s in shapes} != {count}:
        raise ExchangeError(
            f"{path.name}: {frequencies.size} modes, and {len(shapes)} lists of displacements; "
            f"ask for them with U below *NODE PRINT, NSET=... in a step with *FREQUENCY. "
            f"Where you did, the file is cut off"
        )
    rows = np.array(shapes)
    return CalculixModes(
        tuple(map(int, rows[0, :, 0])), frequencies, np.moveaxis(rows[:, :, 1:4], 0, -1), {},
        shares,
    )  # fmt: skip


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ExchangeError(f"{path.name}: cannot be read: {error.strerror}") from error


def _shapes(file: _ResultFile) -> Iterator[tuple[float, FloatArray, FloatArray]]:
    """Yield frequency [Hz], nodes and shape of each mode.

    Raises
    ------
    ExchangeError
        If one is damaged, or complex.
    """
    head = b""
    for match in _HEAD.finditer(file.content):
        line = match[0]
        if line.startswith(b"  100C"):
            head = line
        elif line.startswith(b" -4  DISPI") and b"MODAL" in head:
            raise file.error(match.start(), "complex modes; those of a structure are real")
        elif line.startswith(b" -4  DISP ") and b"MODAL" in head:
            try:
                frequency, count = float(head[12:24]), int(head[24:36])
            except ValueError:
                raise file.error(
                    match.start(), "no frequency and number of nodes above the displacements"
                ) from None
            yield (frequency, *file.block(match.start(), count))


def _steps(file: _ResultFile) -> Iterator[bytes]:
    """Yield the number of the step of each mode."""
    step = b""
    for match in _HEAD.finditer(file.content):
        if match[0].startswith(b"    1PSTEP"):
            step = match[0].split()[-1]
        elif match[0].startswith(b"  100C") and b"MODAL" in match[0]:
            yield step


def _positions(file: _ResultFile) -> dict[int, tuple[float, float, float]]:
    """Return where the nodes are [unit of length of the file]."""
    for match in _HEAD.finditer(file.content):
        if match[0].startswith(b"    2C"):
            nodes, places = file.block(match.start(), int(match[0].split()[1]))
            rows = zip(nodes.astype(int).tolist(), places.tolist(), strict=True)
            return {node: (x, y, z) for node, (x, y, z) in rows}
    return {}


def _participations(path: Path, frequencies: FloatArray) -> Mapping[str, FloatArray]:
    """Return the participations that were printed beside a result file.

    Raises
    ------
    ExchangeError
        If its modes are others.
    """
    printed, shares = _tables(path, path.read_text("ascii", "replace").splitlines())
    tolerance = _SAME_RUN * np.max(frequencies, initial=0.0)
    if printed.size != frequencies.size or np.any(np.abs(printed - frequencies) > tolerance):
        raise ExchangeError(
            f"{path.name}: its modes are not those of {path.stem}.frd beside it; both are "
            f"written by one run. Run it again, or move {path.name} away"
        )
    return shares


def _tables(path: Path, lines: list[str]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return frequencies [Hz] and participations by direction.

    Raises
    ------
    ExchangeError
        If no eigenvalues are printed.
    """
    at = {name: i for i, line in enumerate(lines) for name in _WORDS if _WORDS[name] in line}
    rows = _rows(lines, at["eigenvalues"]) if "eigenvalues" in at else []
    if not rows:
        raise ExchangeError(
            f"{path.name}: no eigenvalues; it is printed by CalculiX in a step with *FREQUENCY"
        )
    shares = np.array(_rows(lines, at["participations"])) if "participations" in at else None
    frequencies = np.array([row[3] for row in rows])
    if shares is None or shares.shape != (len(rows), 7):
        return frequencies, {}
    return frequencies, dict(zip(AXES, shares[:, 1:4].T, strict=True))


def _rows(lines: list[str], after: int) -> list[list[float]]:
    """Return the first rows of numbers behind a line, up to the blank one that ends them."""
    rows: list[list[float]] = []
    for line in lines[after + 1 :]:
        try:
            numbers = [float(word) for word in line.split()]
        except ValueError:
            continue
        if numbers:
            rows.append(numbers)
        elif rows:
            break
    return rows


def _numbers_of(lines: bytes, start: int, width: int, columns: int) -> FloatArray:
    """Return the numbers of lines of one length that stand in columns of one width.

    Parameters
    ----------
    lines : bytes
        Lines that all end in a line feed and have as many characters as the first.
    start, width : int
        Characters before the first column, and of each.
    columns : int
        How many there are.

    Returns
    -------
    (n_lines, columns) array
        As they stand, in the units of the file.

    Raises
    ------
    ValueError
        If lines differ in length, or a column holds no number.
    """
    length = lines.find(b"\n") + 1
    end = start + width * columns
    if length <= end or len(lines) % length:
        raise ValueError("lines differ in length")
    characters = np.frombuffer(lines, np.uint8).reshape(-1, length)
    if np.any(characters[:, -1] != ord("\n")):
        raise ValueError("lines differ in length")
    cells = np.ascontiguousarray(characters[:, start:end]).view(f"S{width}")
    return cells.astype(float)
