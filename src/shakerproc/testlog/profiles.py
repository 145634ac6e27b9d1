"""Breakpoint profiles: demand, alarm and abort lines of a test, from the log or a CSV file."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final, TypeAlias, final

from shakerproc.errors import LogError
from shakerproc.numerals import numeral
from shakerproc.testlog.excitation import LEVELS, LevelUnit, Profile, ProfileNotch
from shakerproc.testlog.fields import MisfitError, csv_cells
from shakerproc.testlog.processing import Tolerance
from shakerproc.testlog.schema import ProfileSection, TestSection
from shakerproc.units import is_unit_of, near_miss, quoted, to_si

MOST_BYTES: Final = 1_000_000
"""Largest file of a profile that is read [byte]."""

SLOPE: Final = re.compile(
    r"^\s*([+-]?(?:\d+\.?\d*|\.\d+))\s*dB\s*/\s*oct(?:ave)?\s*$", re.IGNORECASE
)
"""A slope that stands where a level may, such as ``-3 dB/oct``."""

_HEADER: Final = re.compile(r"^(?P<name>[^\[(]*)[\[(](?P<unit>[^\])]*)[\])]\s*$")
_WANTED: Final = '"frequency [Hz],demand [g^2/Hz]" and, if need be, "alarm [dB],abort [dB]"'

Raise: TypeAlias = Callable[[int, str], Exception]
"""From the number of a breakpoint and what is wrong with it to the error with its place."""

MOST_DECADES: Final = 12
"""Over how many powers of ten one slope of a profile may lead."""

_UNITS: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind != "rms")

_SHOWN: Final[Mapping[str, str]] = {"(m/s^2)^2/Hz": "g^2/Hz", "m/s^2": "g"}


@final
@dataclass(frozen=True, slots=True)
class Written:
    """A breakpoint as text: quantities with units, a slope where a level may stand."""

    frequency: str
    level: str
    alarm: str = ""
    abort: str = ""


def read_breakpoints(path: Path) -> tuple[list[Written], Raise]:
    """Return the breakpoints of a CSV file, and how errors about them say where they are.

    Raises
    ------
    LogError
        If it is no table of breakpoints.
    """
    lines = _lines(path)
    number, header = lines[0]
    columns = _columns(f"{path}:{number}", header)

    def place(row: int, message: str) -> Exception:
        at = lines[min(row + 1, len(lines) - 1)][0]
        return LogError(f"{path}:{at}: {message}")

    written = []
    for i, (_, cells) in enumerate(lines[1:]):
        if len(cells) != len(header):
            raise LogError(
                f"{path}:{lines[i + 1][0]}: expected {len(header)} cells, got {len(cells)}"
            )
        cell = {name: _cell(cells[at], unit) for name, (at, unit) in columns.items()}
        written.append(
            Written(
                cell["frequency"], cell["demand"], cell.get("alarm", ""), cell.get("abort", "")
            )
        )
    return written, place


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return the number and the cells of every line that holds something.

    Raises
    ------
    LogError
        If the file is no text, empty, or larger than any profile.
    """
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise LogError(
            f"{path}: expected breakpoints, got more than 1 MB; name the profile's file"
        )
    lines = [row for row in csv_cells(raw, path, comments=True) if any(row[1])]
    if not lines:
        raise LogError(f"{path}: expected a header {_WANTED}, got an empty file")
    return lines


def _columns(place: str, header: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Return position and unit of each column: frequency, demand, alarm, abort.

    Raises
    ------
    LogError
        If a column has no unit, is not known, stands twice or is missing.
    """
    columns: dict[str, tuple[int, str]] = {}
    for i, cell in enumerate(header):
        match = _HEADER.match(cell)
        name = match["name"].strip().lower() if match else ""
        if match is None or name not in {"frequency", "demand", "alarm", "abort"}:
            raise LogError(f"{place}: expected a header {_WANTED}, got {quoted(cell)}")
        if name in columns:
            raise LogError(f"{place}: expected one column {name}, got two")
        columns[name] = (i, match["unit"].strip())
    if not {"frequency", "demand"} <= columns.keys():
        raise LogError(f"{place}: expected a header {_WANTED}, got {', '.join(header)}")
    return columns


def _cell(text: str, unit: str) -> str:
    """Return a cell with its unit; a slope says its own, and an empty one nothing."""
    return text if not text or SLOPE.match(text) else f"{text} {unit}"


@final
@dataclass(frozen=True, slots=True)
class _ProfileRow:
    """A breakpoint as it is written: a level, or a slope from the breakpoint beside it."""

    frequency: float
    level: float | None
    slope: float
    alarm: float | None = None
    abort: float | None = None


def profile_of(
    name: str, section: ProfileSection, read: Callable[[str], Path], tolerance: Tolerance
) -> Profile:
    """Return a profile of the log.

    Parameters
    ----------
    name : str
        Its name in the log.
    section : ProfileSection
        What the log says of it.
    read : callable
        From a path as the log writes it to the file below the log's folder.
    tolerance : Tolerance
        Alarm and abort where the profile says none.

    Raises
    ------
    MisfitError
        If the breakpoints make no lines.
    """
    if (section.breakpoints is None) == (section.file is None):
        raise MisfitError('expected either "breakpoints" or "file"')
    written, place = _written(section, read)
    unit = _unit_of([row.level for row in written], place)
    rows = [_row(i, row, unit, place) for i, row in enumerate(written)]
    return _joined(name, section, rows, unit, place, tolerance=tolerance)


def _written(
    section: ProfileSection, read: Callable[[str], Path]
) -> tuple[list[Written], Raise]:
    """Return the breakpoints as they are written, and how errors say where they are.

    Raises
    ------
    MisfitError
        If the file is not there, or not below the log's folder.
    """
    if section.breakpoints is not None:
        return [Written(at, level) for at, level in section.breakpoints], _misfit
    try:
        path = read(section.file or "")
    except ValueError as error:
        raise MisfitError(str(error), "file") from error
    if not path.is_file():
        raise MisfitError(f"no file {path}", "file")
    return read_breakpoints(path)


def _misfit(row: int, text: str) -> Exception:
    return MisfitError(text, "breakpoints", row)


def _joined(
    name: str,
    section: ProfileSection,
    rows: Sequence[_ProfileRow],
    unit: LevelUnit,
    place: Raise,
    *,
    tolerance: Tolerance,
) -> Profile:
    """Return the profile of rows that are in order."""
    if len(rows) < 2:
        raise place(0, f"expected at least two breakpoints, got {len(rows)}")
    for i, (one, two) in enumerate(pairwise(rows), 1):
        if two.frequency <= one.frequency:
            what = "twice" if two.frequency == one.frequency else f"after {one.frequency:g} Hz"
            raise place(
                i,
                f"expected breakpoints at rising frequencies, got {two.frequency:g} Hz {what}",
            )
    alarm = tolerance.alarm if section.alarm is None else section.alarm
    abort = max(tolerance.abort, alarm) if section.abort is None else section.abort
    alarms = _stepwise_tolerances([row.alarm for row in rows], alarm)
    aborts = _stepwise_tolerances([row.abort for row in rows], abort)
    for i, (near, far) in enumerate(zip(alarms, aborts, strict=True)):
        if near > far:
            raise place(i, f"expected alarm at most abort, got {near:g} dB and {far:g} dB")
    frequency = tuple(row.frequency for row in rows)
    return Profile(
        name=name,
        unit=unit,
        frequency_hz=frequency,
        level=_levels(rows, unit, place),
        alarm_db=alarms,
        abort_db=aborts,
        notches=_notches(section, frequency),
    )


def _notches(section: ProfileSection, frequency: Sequence[float]) -> tuple[ProfileNotch, ...]:
    """Return the notches that the plan allows.

    Raises
    ------
    MisfitError
        If one does not rise, or lies outside the profile.
    """
    for i, notch in enumerate(section.notches):
        if notch.low >= notch.high:
            raise MisfitError("expected from below to", "notches", i, "to")
        if notch.high < frequency[0] or notch.low > frequency[-1]:
            raise MisfitError(
                f"expected a notch within the profile, {frequency[0]:g} to {frequency[-1]:g} "
                f"Hz, got {notch.low:g} to {notch.high:g} Hz",
                "notches",
                i,
            )
    return tuple(ProfileNotch(n.low, n.high, n.depth) for n in section.notches)


def _stepwise_tolerances(values: Sequence[float | None], first: float) -> tuple[float, ...]:
    """Return tolerances that hold from their breakpoint up to the next one that has its own."""
    held, tolerances = first, []
    for value in values:
        held = held if value is None else value
        tolerances.append(held)
    return tuple(tolerances)


def _levels(rows: Sequence[_ProfileRow], unit: LevelUnit, place: Raise) -> tuple[float, ...]:
    """Return the level of every breakpoint, slopes followed from the one beside it.

    A slope leads here from the breakpoint before; those before the first level lead from here
    to the breakpoint after.
    """
    known = [i for i, row in enumerate(rows) if row.level is not None]
    if not known:
        raise place(0, "expected at least one breakpoint with a level, got slopes alone")
    per_decade = 10.0 if unit.endswith("/Hz") else 20.0
    levels = [row.level for row in rows]
    order = [(i, i + 1) for i in range(known[0] - 1, -1, -1)]
    order += [(i, i - 1) for i in range(known[0] + 1, len(rows))]
    for i, beside in order:
        neighbour = levels[beside]
        if levels[i] is None and neighbour is not None:
            octaves = math.log2(rows[i].frequency / rows[beside].frequency)
            exponent = rows[i].slope * octaves / per_decade
            if abs(exponent) > MOST_DECADES:
                raise place(
                    i,
                    f"expected a slope over at most {MOST_DECADES} decades of level, got "
                    f"{rows[i].slope:g} dB/oct over {numeral(abs(octaves))} octaves",
                )
            levels[i] = neighbour * 10.0**exponent
    return tuple(level for level in levels if level is not None)


def _row(i: int, written: Written, unit: LevelUnit, place: Raise) -> _ProfileRow:
    """Return a breakpoint in SI.

    Raises
    ------
    Exception
        What `place` makes of a number that is none, or not above 0.
    """
    slope = SLOPE.match(written.level)
    try:
        at = to_si(written.frequency, "Hz")
        alarm, abort = (
            to_si(text, "dB") if text else None for text in (written.alarm, written.abort)
        )
        level = None if slope is not None else _level(at, written.level, unit)
    except ValueError as error:
        raise place(i, str(error)) from error
    numbers = {"frequency": at, "level": level, "alarm": alarm, "abort": abort}
    for what, number in numbers.items():
        if number is not None and not 0.0 < number < math.inf:
            said = quoted(getattr(written, what))
            raise place(i, f"expected {what} of more than 0, got {said} at {at:g} Hz")
    return _ProfileRow(at, level, 0.0 if slope is None else float(slope[1]), alarm, abort)


def _level(at: float, level: str, unit: LevelUnit) -> float:
    """Return a level in SI; of a sine, a displacement or velocity is made an acceleration.

    Raises
    ------
    ValueError
        If its unit is another than that of the rest.
    """
    omega = 2.0 * math.pi * at
    for wanted, factor in (("m", omega**2), ("m/s", omega)) if unit == "m/s^2" else ():
        try:
            return to_si(level, wanted) * factor
        except ValueError:
            continue
    return to_si(level, unit)


def _unit_of(levels: Sequence[str], place: Raise) -> LevelUnit:
    """Return the unit that the first level is written in, in SI.

    Raises
    ------
    Exception
        What `place` makes of a level that is none.
    """
    for i, level in enumerate(levels):
        if SLOPE.match(level):
            continue
        unit = re.sub(r"^\s*[+-]?[0-9.]*(?:[eE][+-]?\d+)?\s*", "", level)
        for wanted in _UNITS:
            if unit and is_unit_of(unit, wanted):
                return wanted
        if unit and (is_unit_of(unit, "m") or is_unit_of(unit, "m/s")):
            return "m/s^2"
        raise place(
            i,
            "expected a density such as 0.04 g^2/Hz, an amplitude such as 2 g or 1 mm, or a "
            f"slope such as -3 dB/oct, got {quoted(level)}",
        )
    return "(m/s^2)^2/Hz"


def fitting_profile(
    profiles: Mapping[str, Profile], section: TestSection, level_unit: LevelUnit | None
) -> Profile | None:
    """Return the profile that a test names, if it names one.

    Raises
    ------
    MisfitError
        If there is none of that name, or it is not for this kind of excitation or level.
    """
    if section.profile is None:
        return None
    if section.profile not in profiles:
        meant = near_miss(section.profile, list(profiles))
        known = ", ".join(profiles) or "none"
        text = f'; did you mean "{meant}"?' if meant else f"; the log has {known}"
        raise MisfitError(
            f"no profile {quoted(section.profile)} under profiles{text}", "profile"
        )
    profile = profiles[section.profile]
    density = profile.unit.endswith("/Hz")
    kinds = ("random", "sine on random") if density else ("sine sweep",)
    if section.excitation not in kinds:
        raise MisfitError(
            f"expected excitation: {' or '.join(kinds)} for a profile in "
            f"{_SHOWN.get(profile.unit, profile.unit)}, got "
            f"{section.excitation or 'none'}",
            "profile",
        )
    if level_unit is not None and not level_unit.endswith("rms"):
        raise MisfitError(
            "expected no level beside a profile, which says it at every frequency, but an rms "
            "value at most; take one of them out",
            "level",
        )
    return profile
