"""Punch files of Nastran results: SORT1 and SORT2, real and complex; as recordings."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, final

import numpy as np

from shakerproc.data import Channel, ComplexArray, FloatArray, Recording, recording_of_arrays
from shakerproc.errors import ExchangeError
from shakerproc.exchange.modes import COMPONENTS
from shakerproc.exchange.nastran_decks import forces_of_deck

_QUANTITIES = {
    "$DISPLACEMENTS": ("displacement", "m"),
    "$VELOCITY": ("velocity", "m/s"),
    "$VELOCITIES": ("velocity", "m/s"),
    "$ACCELERATION": ("acceleration", "m/s^2"),
    "$ACCELERATIONS": ("acceleration", "m/s^2"),
    "$EIGENVECTOR": ("eigenvector", "1/sqrt(kg)"),
}

STRAY: Final = 1e-3
"""How far a time may stray from its place, in steps: punch holds seven digits."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PunchTable:
    """One quantity of all points that were punched.

    Attributes
    ----------
    quantity, unit : str
        ``displacement``, ``velocity``, ``acceleration`` or ``eigenvector``, in SI where the
        deck was.
    abscissa : {"time", "frequency", "mode"}
        What the results run over.
    at : (n_steps,) array
        [s], [Hz], or the number of the mode.
    points : tuple of int
        Node numbers.
    values : (n_points, 6, n_steps) array
        Three translations and three rotations of each point.
    eigenvalues : (n_steps,) array
        Squares of the natural frequencies of modes; none of other quantities [rad^2/s^2].
    """

    quantity: str
    unit: str
    abscissa: str
    at: FloatArray
    points: tuple[int, ...]
    values: FloatArray | ComplexArray
    eigenvalues: FloatArray = field(default_factory=lambda: np.zeros(0))


@dataclass(slots=True)
class _Gathered:
    """Values of one quantity read so far, in the order of the file."""

    unit: str
    abscissa: str
    complex: bool = False
    points: list[int] = field(default_factory=list)
    at: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    eigenvalues: dict[float, float] = field(default_factory=dict)


@dataclass(slots=True)
class _Header:
    """Dollar lines above a block of values."""

    quantity: str = ""
    unit: str = ""
    abscissa: str = ""
    fixed: float = float("nan")
    by_point: bool = False  # SORT2: the header names the point, the lines the time
    complex: bool = False
    eigenvalue: float = float("nan")


def read_punch(path: Path) -> tuple[PunchTable, ...]:
    """Return the tables of a punch file, one for each quantity.

    Raises
    ------
    ExchangeError
        If the file is cut off, holds something else, or misses values; the line is named.
    """
    gathered: dict[str, _Gathered] = {}
    header = _Header()
    try:
        with path.open(encoding="ascii") as lines:
            numbered = enumerate(lines, 1)
            number, line = 0, ""
            for number, line in numbered:
                if line.startswith("$"):
                    _note(header, line, path, number)
                else:
                    _take(gathered, header, line, _Place(path, number), numbered)
    except OSError as error:
        raise ExchangeError(f"{path.name}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ExchangeError(
            f"{path.name}: not a punch file: byte {error.start} is not plain text; give the "
            f".pch file that PUNCH in the case control writes"
        ) from error
    if gathered and line.startswith("$"):
        raise ExchangeError(
            f"{path.name}:{number}: the file ends after a heading; it is cut off"
        )
    if not gathered:
        raise ExchangeError(
            f"{path.name}: no displacements, velocities or accelerations; ask for them with "
            f"PUNCH in the case control, such as DISPLACEMENT(PUNCH,SORT1,REAL)=ALL"
        )
    tables = tuple(_table(path, quantity, rows) for quantity, rows in gathered.items())
    for other in tables[1:]:
        if other.values.shape != tables[0].values.shape:
            raise ExchangeError(
                f"{path.name}: {other.quantity} at {other.at.size} steps but "
                f"{tables[0].quantity} at {tables[0].at.size}: it is cut off"
            )
    return tables


def read_modes(path: Path) -> PunchTable:
    """Return the eigenvectors of a punch file.

    Raises
    ------
    ExchangeError
        If it holds none, or as `read_punch` does.
    """
    for table in read_punch(path):
        if table.abscissa == "mode" and table.quantity in {"eigenvector", "displacement"}:
            return table
    raise ExchangeError(
        f"{path.name}: no eigenvectors; ask for them with VECTOR(PUNCH,SORT1,REAL)=ALL"
    )


@final
@dataclass(frozen=True, slots=True)
class _Place:
    path: Path
    line: int

    def error(self, message: str) -> ExchangeError:
        return ExchangeError(f"{self.path.name}:{self.line}: {message}")


def _note(header: _Header, line: str, path: Path, number: int) -> None:
    words = line[:72].split()
    if words[0] in _QUANTITIES:
        header.quantity, header.unit = _QUANTITIES[words[0]]
        return
    if "OUTPUT" in words:
        header.complex = words[0] != "$REAL"
        if "MAGNITUDE-PHASE" in line:
            raise ExchangeError(
                f"{path.name}:{number}: magnitude and phase; punch IMAG instead of PHASE"
            )
    for word, abscissa in (("$TIME", "time"), ("$FREQUENCY", "frequency")):
        if words[0] == word:
            header.fixed, header.abscissa, header.by_point = float(words[2]), abscissa, False
    if words[0] == "$EIGENVALUE" and "MODE" in words:
        header.eigenvalue, header.fixed = float(words[2]), float(words[-1])
        header.abscissa, header.by_point = "mode", False
    if line.startswith("$POINT ID"):
        header.fixed, header.by_point = (
            float(line[:72].split("=", 1)[1].split(maxsplit=1)[0]),
            True,
        )
        header.abscissa = "frequency" if "FREQUENCY" in line else "time"


def _take(
    gathered: dict[str, _Gathered],
    header: _Header,
    line: str,
    place: _Place,
    following: Iterator[tuple[int, str]],
) -> None:
    if not (header.quantity and header.abscissa):
        raise place.error(
            f"{line[:20].strip()!r} stands before any heading of displacements, velocities or "
            f"accelerations over time or frequency; only such punch files are read"
        )
    rows = gathered.setdefault(header.quantity, _Gathered(header.unit, header.abscissa))
    rows.complex = header.complex
    try:
        lead = float(line[:18].rstrip(" GSHELM\n")) if line[:18].strip() else float("nan")
        values = [float(line[18:36]), float(line[36:54]), float(line[54:72])]
        for _ in range(3 if header.complex else 1):
            number, more = next(following)
            if not more.startswith("-CONT-"):
                raise ExchangeError(
                    f"{place.path.name}:{number}: {more[:20].strip()!r} stands where the "
                    f"continuation of line {place.line} was wanted"
                )
            values += [float(more[18:36]), float(more[36:54]), float(more[54:72])]
    except StopIteration:
        raise place.error("the file ends in the middle of a point; punch it again") from None
    except ValueError:
        raise place.error(
            "a number is missing or cut off; the file is damaged or was not written as punch"
        ) from None
    rows.points.append(int(header.fixed if header.by_point else lead))
    rows.at.append(lead if header.by_point else header.fixed)
    rows.values += values
    if header.abscissa == "mode":
        rows.eigenvalues[header.fixed] = header.eigenvalue


def _table(path: Path, quantity: str, rows: _Gathered) -> PunchTable:
    points = np.array(rows.points)
    at = np.array(rows.at)
    names, which_point = np.unique(points, return_inverse=True)
    steps, which_step = np.unique(at, return_inverse=True)
    if at.size != names.size * steps.size:
        raise ExchangeError(
            f"{path.name}: {quantity} of {names.size} points at {steps.size} steps should be "
            f"{names.size * steps.size} results, the file holds {at.size}. It is cut off, or "
            f"holds several subcases; punch one subcase whole"
        )
    flat = np.array(rows.values).reshape(at.size, -1)
    parts = flat[:, :6] + 1j * flat[:, 6:] if rows.complex else flat
    values = np.empty((names.size, 6, steps.size), dtype=parts.dtype)
    values[which_point, :, which_step] = parts
    eigenvalues = np.array([rows.eigenvalues[step] for step in steps if rows.eigenvalues])
    return PunchTable(
        quantity, rows.unit, rows.abscissa, steps, tuple(int(n) for n in names), values,
        eigenvalues,
    )  # fmt: skip


def recording_of_punch(path: Path, deck: Path | None = None) -> Recording:
    """Return the results of a punch file as a recording in memory.

    Channels are called like ``node 2 acceleration x``. Components that are zero throughout,
    such as those of a node that is held, are left out and counted in a note. Units are those
    of a deck in SI, as `shakerproc nastran write` makes them; then displacements are relative
    to the base.

    Parameters
    ----------
    path : Path
        The punch file.
    deck : Path, optional
        The deck that made it; its forces over the masses they act on become channels called
        like ``control F/m node 2`` [m/s²], the controls of what follows. Where the base is
        shaken this is its acceleration with the sign turned.

    Raises
    ------
    ExchangeError
        If the file is damaged, runs over frequency, or its time steps are not equal.
    """
    tables = read_punch(path)
    if tables[0].abscissa != "time" or np.iscomplexobj(tables[0].values):
        raise ExchangeError(
            f"{path.name}: results over {tables[0].abscissa}, a recording runs over time; "
            f"punch a transient solution"
        )
    rate = _sample_rate(path, tables[0].at)
    channels, rows = [], []
    left_out = 0
    for table in tables:
        for point, values in zip(table.points, table.values, strict=True):
            for component, samples in zip(COMPONENTS, values, strict=True):
                if np.any(samples != 0.0):
                    channels.append(_channel(table, point, component))
                    rows.append(samples)
                else:
                    left_out += 1
    if not rows:
        raise ExchangeError(f"{path.name}: every result is zero; was a load applied?")
    for node, (time, force, mass) in (forces_of_deck(deck) if deck else {}).items():
        name, unit = f"control F/m node {node}", "m/s^2"
        channels.append(Channel(name=name, unit=unit, source_name=name, source_unit=unit))
        rows.append(np.interp(tables[0].at, time, force / mass))
    recording = recording_of_arrays(path.stem, channels, np.array(rows), rate)
    note = f"{left_out} components that are zero throughout are left out"
    return replace(recording, path=path, notes=(note,) if left_out else ())


def _channel(table: PunchTable, point: int, component: str) -> Channel:
    angular = component.startswith("about")
    unit = table.unit.replace("m", "rad", 1) if angular else table.unit
    name = f"node {point} {table.quantity} {component}"
    return Channel(name=name, unit=unit, source_name=name, source_unit=unit)


def _sample_rate(path: Path, times: FloatArray) -> float:
    """Return samples per second [Hz].

    Raises
    ------
    ExchangeError
        If the steps are not equal.
    """
    if times.size < 2:
        raise ExchangeError(f"{path.name}: {times.size} time steps, at least 2 are needed")
    step = (times[-1] - times[0]) / (times.size - 1)
    ideal = times[0] + step * np.arange(times.size)
    # printed with seven digits, late times are rounded more coarsely than early ones
    allowed = np.maximum(STRAY * step, 1e-6 * np.abs(times))
    wrong = np.flatnonzero(np.abs(times - ideal) > allowed)
    if wrong.size:
        place = float(times[wrong[0]])
        raise ExchangeError(
            f"{path.name}: the time steps are not equal (at {place:g} s); let Nastran write "
            f"equal steps with NLSTEP and FIXED"
        )
    return round_rate(1.0 / float(step))


def round_rate(rate: float) -> float:
    """Return a rate without the rounding of printed times: a whole number where it is near.

    `rate` is in [Hz].
    """
    near = float(round(rate))
    return near if near > 0.0 and abs(rate - near) < 1e-6 * rate else rate
