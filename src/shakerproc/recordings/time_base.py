"""The one place that decides when samples were taken, by the times of a file.

Every statement is read in each unit that it may be in: the one it says, the one in the name of
the times, or those in which the rate is one of vibration. What all statements agree on counts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Final, final

from shakerproc.numerals import numeral
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import (
    AS_STATED,
    SILENT,
    UNKNOWN,
    Sampling,
    TimeAxis,
    TimeBase,
    TimeReading,
    Times,
)
from shakerproc.recordings.times import seconds_in, steps_of, strays, ticks_of, unit_in_name

LATE: Final = 1e-3
"""Gap between segments that is none [s]: programs write times of day to the millisecond."""

CONTRADICTION: Final = 1e-3
"""How far two statements of a rate may part before they contradict each other, relative."""

SAME_RATE: Final = 1e-7
"""How far the rates of channels may part, relative: 2 samples in 20 million."""

CLOCKS: Final = 1e-4
"""How far two recorders' rates may part that are one, relative: quartz is right to 50 ppm."""

SAME_AS_LOG: Final = 1e-4
"""How far the log may round the sample rate, relative."""

SLOWEST: Final = 20.0
"""Rate from which on a recording is one of vibration [Hz]: a step of 0.05 s without a unit may
be one of milliseconds, or a count."""

FASTEST: Final = 1e6
"""Rate of the fastest recorders of shocks [Hz]."""

ROUNDING: Final = 1e-12
"""How far rounding in the last binary digits takes a step that was a whole rate, relative."""

UNITS: Final = ("s", "ms", "us", "min", "h")
"""What times without a unit may be in, the most usual first."""

_SPECTRAL: Final = frozenset({
    "hz", "khz", "1/s", "rad/s", "rpm", "1/min", "cpm", "order", "orders", "1/m",
})  # fmt: skip
_FREQUENCY: Final = ("freq", "fr\u00e9q", "frec", "spectr", "order", "wavenumber")
"""How the names of quantities begin that are no times."""

_CALENDAR: Final[tuple[tuple[float, float, datetime], ...]] = (
    (946_684_800.0, 3_029_529_600.0, datetime(1970, 1, 1, tzinfo=UTC)),
    (3_029_529_600.0, 5_112_374_400.0, datetime(1904, 1, 1, tzinfo=UTC)),
)
"""Seconds that are a date between 2000 and 2066, counted from 1970 or, in LabVIEW, 1904."""

_DAYS: Final[tuple[tuple[float, float, datetime], ...]] = (
    (36_526.0, 60_632.0, datetime(1899, 12, 30, tzinfo=UTC)),
)
"""Days of a spreadsheet that are such a date."""


def follows(elapsed: float, duration: float, step: float) -> bool:
    """Return whether samples go on where those before end.

    Parameters
    ----------
    elapsed : float
        From the first sample of those before to the first of these [s].
    duration : float
        Of the samples before [s].
    step : float
        Time between samples [s]; 0 where it is not said.
    """
    return step > 0.0 and abs(elapsed - duration) <= max(step, LATE) + CLOCKS * duration


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Statement:
    """Statement of one place: its possible readings, or its fault.

    `tick` is what times are rounded to that repeat [unit]; they tell a start, and no rate.
    """

    axis: TimeAxis
    readings: tuple[TimeReading, ...] = ()
    doubt: float = 0.0
    problem: str = ""
    spectrum: bool = False
    tick: float = 0.0

    def reading_at(self, rate: float, doubt: float = 0.0) -> TimeReading | None:
        """Return the reading with a rate [Hz], which may be off by a relative doubt [-]."""
        most = max(CONTRADICTION, self.doubt + doubt)
        return next((r for r in self.readings if abs(r.rate / rate - 1.0) <= most), None)


def time_base(
    axes: Sequence[TimeAxis],
    start_time: datetime | None = None,
    said: Sampling = AS_STATED,
) -> TimeBase:
    """Return the time base by the statements of a file, or the problem with them.

    Parameters
    ----------
    axes : sequence of TimeAxis
        What the file states, one for each place.
    start_time : datetime, optional
        When time 0 of the axes is.
    said : Sampling
        What the log says, by which two readings are told apart.
    """
    base = _agreed([_statement(axis, said.unit) for axis in axes], start_time, said)
    try:
        _ = base.first
    except (OverflowError, ValueError):
        problem = f"{axes[0].where} begins at {base.start:g} s, which is no time"
        return TimeBase(problem=problem)
    return base


def _agreed(
    every: Sequence[_Statement], start_time: datetime | None, said: Sampling
) -> TimeBase:
    """Return the time base on which all statements agree."""
    rounded = next((s for s in every if s.tick), None)
    if rounded is not None:
        others = _agreed([s for s in every if not s.tick], start_time, said)
        return _with_ticks(others, rounded, said)
    telling = [s for s in every if s.readings or s.problem]
    if not telling:
        return replace(UNKNOWN, start_time=start_time)
    wrong = next((s for s in telling if s.problem), None)
    if wrong is not None:
        base = TimeBase(problem=wrong.problem, start_time=start_time, spectrum=wrong.spectrum)
        return _uneven(wrong, base) if wrong.readings else base
    best = min(telling, key=lambda s: s.doubt)
    ways = [r for r in best.readings if all(s.reading_at(r.rate, best.doubt) for s in telling)]
    if said.rate is not None and len(ways) > 1:
        most = max(SAME_AS_LOG, best.doubt)
        ways = [r for r in ways if abs(r.rate / said.rate - 1.0) <= most] or ways
    if len(ways) == 1:
        return _agreed_base(telling, best, ways[0], start_time)
    if ways:
        problem = _undecided(best, ways)
    else:
        problem, ways = _contradiction(telling)
    return TimeBase(
        doubt=best.doubt, problem=problem, readings=tuple(ways), start_time=start_time
    )


def _with_ticks(base: TimeBase, rounded: _Statement, said: Sampling) -> TimeBase:
    """Return a time base with the start that rounded times tell, held against their ticks.

    They contradict a rate by which they would stray by more than what they are rounded to.
    """
    times, where = rounded.axis.times, rounded.axis.where
    rate = base.sample_rate or said.rate
    way = rounded.readings[0]
    if times is None or (not base.is_silent and base.sample_rate is None):
        return base
    ticks = f"{where} repeats its times, which are rounded to {rounded.tick:g} {way.unit}"
    about = f": about {way.rate:.6g} samples in a second" if rounded.doubt else ""
    note = f"The start is good to {rounded.tick:g} {way.unit}, to which {where} is rounded."
    ticked = replace(
        base,
        start=float(times[:1][0]) * way.seconds,
        start_doubt=rounded.tick * way.seconds,
        start_time=way.start_time or base.start_time,
        readings=base.readings or (rounded.readings if rounded.doubt else ()),
        note=f"{base.note} {note}".strip(),
    )
    if rate is not None:
        off = strays(times, 1.0 / (rate * way.seconds))
        if off > rounded.tick + CLOCKS * times.size / (rate * way.seconds):
            problem = (
                f"{ticks}, and stray by {numeral(off)} {way.unit} from {rate:.9g} Hz{about}"
            )
            return replace(ticked, sample_rate=None, problem=problem)
    return ticked if base.sample_rate else replace(ticked, problem=f"{SILENT}; {ticks}{about}")


def _uneven(wrong: _Statement, base: TimeBase) -> TimeBase:
    """Return the time base of times that advance, but not evenly."""
    if len(wrong.readings) > 1:
        problem = f"{base.problem}, and {_undecided(wrong, wrong.readings, mean=True)}"
        return replace(base, problem=problem, readings=wrong.readings)
    way, times = wrong.readings[0], wrong.axis.times
    return replace(
        base,
        readings=(way,),
        times=times,
        start=float(times[:1][0]) * way.seconds if times is not None else 0.0,
        start_time=way.start_time or base.start_time,
        note=_taken_for(wrong, way),
    )


def _agreed_base(
    every: Sequence[_Statement],
    best: _Statement,
    way: TimeReading,
    start_time: datetime | None,
) -> TimeBase:
    """Return the time base of statements that agree on one reading."""
    timed = next((s for s in every if s.axis.times is not None), None)
    placed = timed or next((s for s in every if s.axis.start), None)
    seconds = way.seconds
    if placed is not None:
        seconds = (placed.reading_at(way.rate, best.doubt) or way).seconds
    first = timed.axis.times[:1] if timed is not None and timed.axis.times is not None else None
    start = float(first[0]) if first is not None else placed.axis.start if placed else 0.0
    notes = [_taken_for(best, way), _rounded(best, way)]
    return TimeBase(
        sample_rate=way.rate,
        doubt=best.doubt,
        problem="",
        readings=(way,),
        start=start * seconds,
        start_doubt=(placed.axis.start_digit if placed else 0.0) * seconds,
        start_time=way.start_time or start_time,
        note=" ".join(note for note in notes if note),
    )


def _statement(axis: TimeAxis, unit: str) -> _Statement:
    """Return the statement of one place; `unit` is that of times that state none."""
    strange = _no_time(axis)
    if strange or axis.problem:
        return _Statement(axis, problem=strange or axis.problem, spectrum=bool(strange))
    if axis.rate is not None:
        return _of_rate(axis, axis.rate)
    said = axis.unit.strip() or unit_in_name(axis.name) or unit
    if said and not seconds_in(said):
        known = f"{axis.where} is in {shown(said, 20)}, not in s, ms, us, ns, min, h or d"
        return _Statement(axis, problem=known)
    if axis.times is not None:
        return _of_times(axis, axis.times, said)
    return _Statement(axis) if axis.step is None else _of_step(axis, axis.step, said)


def _of_rate(axis: TimeAxis, rate: float) -> _Statement:
    """Return the statement of a rate [Hz]."""
    if 0.0 < rate < math.inf and math.isfinite(1.0 / rate):
        return _Statement(axis, (TimeReading("", rate),))
    return _Statement(axis, problem=f"{axis.where} gives a rate of {rate:g} Hz, which is none")


def _of_times(axis: TimeAxis, times: Times, unit: str) -> _Statement:
    """Return the statement of times in a unit, or in none that is told."""
    steps = steps_of(times, axis.where, unit)
    first = float(times[:1][0]) if times.size else 0.0
    ticks = ticks_of(times) if steps.problem and times.size > 1 else None
    if ticks is not None:
        ways = _ways(unit, ticks.step or ticks.tick, first)
        ways = tuple(replace(way, rate=_whole(way.rate, ticks.doubt)) for way in ways)
        return _Statement(axis, ways, ticks.doubt, steps.problem, tick=ticks.tick)
    ways = _ways(unit, steps.step, first) if steps.step else ()
    ways = tuple(replace(way, rate=_whole(way.rate, steps.doubt)) for way in ways)
    return _Statement(axis, ways, steps.doubt, steps.problem)


def _of_step(axis: TimeAxis, step: float, unit: str) -> _Statement:
    """Return the statement of a step in a unit, or in none that is told.

    A recorder's clock is divided by whole numbers: one within what is printed is meant.
    """
    rate = 1.0 / step if step else math.inf
    if not (math.isfinite(step) and step > 0.0 and math.isfinite(rate)):
        problem = f"{axis.where} is {step:g} {unit or 's'}, which is no sample interval"
        return _Statement(axis, problem=problem)
    doubt = axis.digit / step + ROUNDING
    close = doubt if doubt <= SAME_AS_LOG else ROUNDING
    ways = tuple(replace(w, rate=_whole(w.rate, close)) for w in _ways(unit, step, None))
    exact = ways[0].rate == round(ways[0].rate)
    return _Statement(axis, ways, 0.0 if exact else doubt)


def _no_time(axis: TimeAxis) -> str:
    """Return why an axis is none of time; empty where it is one."""
    quantity, unit = axis.quantity.strip(), axis.unit.strip()
    if unit.casefold() in _SPECTRAL or quantity.casefold().startswith(_FREQUENCY):
        said = " in ".join(shown(text, 30) for text in (quantity, unit) if text)
        return f"it is a spectrum, not samples over time: its abscissa is {said}"
    return ""


def _ways(unit: str, step: float, first: float | None) -> tuple[TimeReading, ...]:
    """Return how a step may be read, of times that begin with `first` where they are known.

    `step` and `first` are in `unit`, or in one that is not told.
    """
    if unit:
        return (_dated(_reading(unit, step), first),)
    if first is not None:
        dated = [_dated(_reading(u, step), first) for u in ("s", "ms", "us", "ns", "d")]
        for way in dated:
            if way.start_time is not None and SLOWEST <= way.rate <= FASTEST:
                return (way,)
    usual = _reading(UNITS[0], step)
    if SLOWEST < usual.rate <= FASTEST:
        return (usual,)
    others = [_reading(other, step) for other in UNITS[1:]]
    return (usual, *(way for way in others if SLOWEST < way.rate <= FASTEST))


def _reading(unit: str, step: float) -> TimeReading:
    seconds = seconds_in(unit)
    return TimeReading(unit, _whole(1.0 / (step * seconds), ROUNDING), seconds)


def _dated(way: TimeReading, first: float | None) -> TimeReading:
    """Return a reading with the date that its times count from, where they are dates."""
    if first is None:
        return way
    table = _DAYS if way.unit == "d" else _CALENDAR
    value = first if way.unit == "d" else first * way.seconds
    zero = next((zero for low, high, zero in table if low <= value < high), None)
    return way if zero is None else replace(way, start_time=zero)


def _whole(rate: float, doubt: float) -> float:
    """Return the whole rate within a relative doubt [-] of one [Hz], or that itself."""
    whole = float(round(rate)) if math.isfinite(rate) else 0.0
    return whole if whole and abs(rate / whole - 1.0) <= doubt else rate


def _undecided(best: _Statement, ways: Sequence[TimeReading], *, mean: bool = False) -> str:
    """Return between which readings the file does not decide."""
    sentences = [f"{way.rate:.6g} Hz in {way.unit}" for way in ways]
    listed = " or ".join(
        [", ".join(sentences[:-1]), sentences[-1]] if len(sentences) > 1 else sentences
    )
    return f"{best.axis.where} states no unit: it is {'a mean of ' * mean}{listed}"


def _contradiction(every: Sequence[_Statement]) -> tuple[str, list[TimeReading]]:
    """Return which rates the places state, and these, that of most places first."""
    places: dict[str, list[str]] = {}
    for one in every:
        places.setdefault(f"{one.readings[0].rate:.6g} Hz", []).append(one.axis.where)
    listed = ", ".join(f"{rate} ({', '.join(there)})" for rate, there in places.items())
    often = max(places, key=lambda rate: len(places[rate]))
    first = next(one for one in every if one.axis.where == places[often][0])
    return f"the file contradicts itself: {listed}", [TimeReading("", first.readings[0].rate)]


def _taken_for(best: _Statement, way: TimeReading) -> str:
    """Return the note on a reading that was preferred to another."""
    if best.axis.unit.strip() or unit_in_name(best.axis.name) or not way.unit:
        return ""
    if way.start_time is not None:
        return (
            f"The times of {best.axis.where} are read as {way.unit} since "
            f"{way.start_time:%Y-%m-%d}, by their size."
        )
    return ""


def _rounded(best: _Statement, way: TimeReading) -> str:
    """Return the rates that a step may stand for that is rounded in print."""
    if best.axis.step is None or best.doubt <= SAME_AS_LOG:
        return ""
    low, high = way.rate / (1.0 + best.doubt), way.rate * (1.0 + best.doubt)
    whole = range(math.ceil(low), min(math.floor(high), math.ceil(low) + 1000) + 1)
    likely = max(whole, key=lambda rate: math.gcd(rate, 10**9 << 20), default=None)
    such = "" if likely is None else f", perhaps {likely} Hz"
    return (
        f"{best.axis.where} is rounded in print to {best.axis.step:g} {way.unit}: the rate is "
        f"{low:.6g} to {high:.6g} Hz{such}; {way.rate:.6g} Hz is used. Put the exact one in "
        "the log: sample_rate."
    )
