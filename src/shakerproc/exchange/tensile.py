"""Tensile runs of files, and the stiffness of a joint: as the thesis took it, and bounded."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import final

import numpy as np
from scipy import stats

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError
from shakerproc.numerals import numeral

_DISPLACEMENT = (
    "displacement",
    "extension",
    "elongation",
    "weg",
    "dehnung",
    "travel",
    "stroke",
)
_FORCE = ("force", "load", "kraft", "standardkraft")
_TO_METRE = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254}
_TO_NEWTON = {"n": 1.0, "kn": 1e3, "mn": 1e6, "lbf": 4.4482216152605, "kip": 4448.2216152605}

THESIS_SAMPLE = 200
"""The thesis reads force and displacement at this sample of each run, from 1."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class TensileRun:
    """One pull of a specimen.

    Attributes
    ----------
    name : str
        Name of the run, from its file.
    specimen : str
        Name of the folder that holds the file.
    displacement : (n_samples,) array
        [m].
    force : (n_samples,) array
        [N].
    """

    name: str
    specimen: str
    displacement: FloatArray
    force: FloatArray


def read_tensile(path: Path) -> TensileRun:
    """Return the run in a CSV file or text export with a heading that names its units.

    Semicolons, tabs and commas part the columns; a decimal comma is understood where columns
    are not parted by commas; lines before the heading and a row of units below it may stand.

    Raises
    ------
    ExchangeError
        If a column, its unit or a number is missing; file and line are named.
    """
    lines = _lines(path)
    heading = next((i for i, line in enumerate(lines) if _is_heading(line)), None)
    if heading is None:
        raise ExchangeError(
            f"{path.name}: no line names a displacement and a force; write a heading such as "
            f"displacement_mm,force_n above the numbers"
        )
    separator = max(";\t,", key=lines[heading].count)
    titles = [title.strip(' "') for title in lines[heading].split(separator)]
    first = heading + 1
    units = [""] * len(titles)
    if first < len(lines) and not re.search(r"\d", lines[first]):
        units = [unit.strip(' "[]()') for unit in lines[first].split(separator)]
        first += 1
    where = f"{path.name}:{heading + 1}"
    columns = [
        _column(where, titles, units, quantity)
        for quantity in ((_DISPLACEMENT, _TO_METRE), (_FORCE, _TO_NEWTON))
    ]
    rows = [
        [_number(path, i, line.split(separator), column, separator) for column, _ in columns]
        for i, line in enumerate(lines[first:], first + 1)
        if line.strip(f" {separator}")
    ]
    if len(rows) < 2:
        raise ExchangeError(f"{path.name}: {len(rows)} rows of numbers, at least 2 are needed")
    values = np.array(rows).T
    return TensileRun(
        name=path.stem,
        specimen=path.resolve().parent.name,
        displacement=values[0] * columns[0][1],
        force=values[1] * columns[1][1],
    )


def _lines(path: Path) -> list[str]:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ExchangeError(f"{path.name}: cannot be read: {error.strerror}") from error
    if b"\0" in raw[:4096]:
        raise ExchangeError(f"{path.name}: not a text file; export the run as text or CSV")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return raw.decode(encoding).splitlines()
        except UnicodeDecodeError:
            continue
    raise ExchangeError(f"{path.name}: neither UTF-8 nor Windows text; export it as UTF-8")


def _is_heading(line: str) -> bool:
    low = line.lower()
    return any(w in low for w in _DISPLACEMENT) and any(w in low for w in _FORCE)


def _column(
    where: str,
    titles: list[str],
    units: list[str],
    quantity: tuple[tuple[str, ...], dict[str, float]],
) -> tuple[int, float]:
    words, factors = quantity
    column = next(i for i, t in enumerate(titles) if any(w in t.lower() for w in words))
    title = titles[column]
    written = units[column] if column < len(units) and units[column] else ""
    if not written:
        match = re.search(r"[\[(_ ,]\s*([A-Za-zµ]+)\s*[\])]?\s*$", title)
        written = match.group(1) if match else ""
    if written.lower() not in factors:
        raise ExchangeError(
            f"{where}: column {title!r} has no unit that is known here"
            f"{f' ({written!r})' if written else ''}; write one of {', '.join(factors)} into "
            f"the heading, such as {words[0]}_{next(iter(factors))}"
        )
    return column, factors[written.lower()]


def _number(path: Path, line: int, cells: list[str], column: int, separator: str) -> float:
    text = cells[column].strip(' "') if column < len(cells) else ""
    if separator != ",":
        text = text.replace(",", ".")
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ExchangeError(
            f"{path.name}:{line}: column {column + 1} holds {text!r}, a number was wanted; "
            f"delete the line or repair the export"
        )
    return value


@final
@dataclass(frozen=True, slots=True)
class Slope:
    """Stiffness over a range of force, with its 95 % bounds [N/m]."""

    value: float
    low: float
    high: float


@final
@dataclass(frozen=True, slots=True)
class JointStiffness:
    """Stiffness of one specimen, from its runs.

    Attributes
    ----------
    specimen : str
        Which specimen.
    secants : tuple of float
        Force over displacement of every run at the sample or force asked for [N/m].
    slopes : tuple of Slope
        Slope of every run over the range of force [N/m].
    thesis : float
        Sum of the last forces over sum of the last displacements [N/m].
    slope : Slope
        Mean slope of the last runs, the bounds from their scatter [N/m].
    converged : bool
        False where the runs that count still stiffen from one to the next.
    """

    specimen: str
    secants: tuple[float, ...]
    slopes: tuple[Slope, ...]
    thesis: float
    slope: Slope
    converged: bool


def joint_stiffness(
    runs: Sequence[TensileRun],
    *,
    last: int = 3,
    sample: int = THESIS_SAMPLE,
    force: float | None = None,
    low_share: float = 0.2,
    high_share: float = 0.8,
) -> JointStiffness:
    """Return the stiffness of one specimen from its runs in order.

    Parameters
    ----------
    runs : sequence of TensileRun
        Of one specimen, first to last.
    last : int
        How many of the last runs count.
    sample : int
        Where the secant is taken, from 1, unless `force` is given.
    force : float, optional
        Where the secant is taken instead [N].
    low_share, high_share : float
        Range of the slope, as shares of each run's largest force [-].

    Returns
    -------
    JointStiffness
        [N/m].

    Raises
    ------
    ValueError
        If there are too few runs or samples for what was asked.
    """
    if len(runs) < last:
        raise ValueError(f"{len(runs)} runs of {runs[0].specimen}, the last {last} were wanted")
    points = [_point(run, sample, force) for run in runs]
    slopes = tuple(slope(run, low_share, high_share) for run in runs)
    counted = np.array(points[-last:])
    return JointStiffness(
        specimen=runs[0].specimen,
        secants=tuple(f / x for x, f in points),
        slopes=slopes,
        thesis=float(counted[:, 1].sum() / counted[:, 0].sum()),
        slope=_mean_slope(np.array([s.value for s in slopes[-last:]])),
        converged=not _still_stiffens(slopes[-last:]),
    )


def slope(run: TensileRun, low_share: float = 0.2, high_share: float = 0.8) -> Slope:
    """Return the slope of force over displacement in a range of force, with 95 % bounds [N/m].

    Parameters
    ----------
    run : TensileRun
        One run.
    low_share, high_share : float
        Range, as shares of the run's largest force [-].

    Raises
    ------
    ValueError
        If fewer than 3 samples lie in the range.
    """
    largest = float(np.max(run.force))
    within = (run.force >= low_share * largest) & (run.force <= high_share * largest)
    if np.count_nonzero(within) < 3:
        raise ValueError(
            f"{run.name}: {np.count_nonzero(within)} samples between {low_share:.0%} and "
            f"{high_share:.0%} of {numeral(largest, 4)} N, at least 3 are needed"
        )
    line = stats.linregress(run.displacement[within], run.force[within])
    reach = stats.t.ppf(0.975, np.count_nonzero(within) - 2) * line.stderr
    return Slope(float(line.slope), float(line.slope - reach), float(line.slope + reach))


def indistinguishable(specimens: Sequence[JointStiffness], *, last: int = 3) -> bool:
    """Return whether the specimens cannot be told apart by their stiffness.

    Then the test may have measured its grips: steel and plastic differ. One-way
    analysis of variance of the last runs' slopes, at the 5 % level.
    """
    if len(specimens) < 2:
        return False
    groups = [[s.value for s in one.slopes[-last:]] for one in specimens]
    return bool(stats.f_oneway(*groups).pvalue > 0.05)


def _point(run: TensileRun, sample: int, force: float | None) -> tuple[float, float]:
    """Return displacement and force where the secant is taken.

    Raises
    ------
    ValueError
        If the run does not reach the sample or the force.
    """
    if force is None:
        if len(run.force) < sample:
            raise ValueError(
                f"{run.name}: {len(run.force)} samples, a secant was wanted at {sample}; "
                f"choose a force instead"
            )
        return float(run.displacement[sample - 1]), float(run.force[sample - 1])
    reached = np.flatnonzero(run.force >= force)
    if not reached.size:
        raise ValueError(
            f"{run.name}: the force reaches {numeral(np.max(run.force), 4)} N, the secant asks "
            f"for {numeral(force, 4)} N"
        )
    first = int(reached[0])
    before = max(first - 1, 0)
    place = np.interp(force, run.force[[before, first]], run.displacement[[before, first]])
    return float(place), force


def _mean_slope(values: FloatArray) -> Slope:
    mean = float(np.mean(values))
    if values.size < 2:
        return Slope(mean, float("nan"), float("nan"))
    spread = float(np.std(values, ddof=1) / np.sqrt(values.size))
    reach = float(stats.t.ppf(0.975, values.size - 1)) * spread
    return Slope(mean, mean - reach, mean + reach)


def _still_stiffens(slopes: Sequence[Slope]) -> bool:
    """Return whether every run that counts is stiffer than the last, beyond its bounds."""
    steps = pairwise(slopes)
    return len(slopes) > 1 and all(after.low > before.high for before, after in steps)
