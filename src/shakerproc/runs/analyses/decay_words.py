"""The curves of a decay in words: remarks, and the signature of a law."""

from collections.abc import Iterator, Sequence
from typing import Final

from shakerproc.numerals import numeral
from shakerproc.spectra.decays import DecayCurve, DecayLine, DecayReading, DecayTrend

DISPUTED: Final = 0.1
"""Share of stretches in which two methods may disagree without a remark [-]: their intervals,
each of 95 %, miss each other in less than one of a hundred by chance."""

BEATS: Final = 1.2
"""How far an amplitude may rise again, as a factor, before two modes are taken to beat [-]:
noise of a tenth of the amplitude, at which reading ends, rarely makes as much."""

HARMONIC: Final = 0.005
"""How far from a whole multiple a harmonic lies at most [-]: a mode shifts while it decays."""

HIGHEST: Final = 5
"""Highest harmonic that is looked for [-]."""


def remarks(curve: DecayCurve) -> Iterator[str]:
    """Yield what is odd about the curves of a mode."""
    name = f"{numeral(curve.line.frequency, 4)} Hz"
    if curve.problem:
        yield f"{name}: no curve: {curve.problem}"
        return
    disputed = curve.disputed
    if len(disputed) > DISPUTED * len(curve.fitted):
        sizes = [curve.fitted[i].amplitude for i in disputed]
        whole = [one.amplitude for one in curve.fitted]
        yield (
            f"{name}: the two methods disagree by more than their intervals in {len(disputed)} "
            f"of {len(curve.fitted)} stretches, at {min(sizes) / max(whole):.0%} to "
            f"{max(sizes) / max(whole):.0%} of the largest amplitude: another mode close by, "
            "or a frequency that shifts within a stretch"
        )
    if curve.rises > BEATS:
        yield (
            f"{name}: the amplitude comes back to {numeral(curve.rises)} times what it was: "
            "another mode lies close by, and the curves are those of both; a sensor at its "
            "node tells them apart"
        )
    shifts = [abs(one.frequency - curve.line.frequency) for one in curve.fitted]
    if max(shifts) > curve.reach:
        yield (
            f"{name}: the frequency shifts by {numeral(max(shifts))} Hz, and the filters pass "
            f"{numeral(curve.reach)} Hz to either side: amplitude and damping are too low there"
        )


def harmonic_of(line: DecayLine, lines: Sequence[DecayLine]) -> tuple[int, float] | None:
    """Return of which lower line a line may be a harmonic, and which one; None if of none."""
    for lower in lines:
        times = round(line.frequency / lower.frequency)
        off = abs(line.frequency / lower.frequency - times)
        if 2 <= times <= HIGHEST and off < HARMONIC * times:
            return times, lower.frequency
    return None


def signature(trend: DecayTrend, readings: Sequence[DecayReading]) -> str:
    """Return how frequency and damping go with amplitude, and which laws do that."""
    first, last = readings[0], readings[-1]
    frequency = (
        f"frequency {last.frequency:.5g} Hz at the smallest amplitude, "
        f"{first.frequency:.5g} Hz at the largest"
        if trend.shifts
        else "no trend of frequency with amplitude"
    )
    damping = (
        f"damping {numeral(100.0 * last.damping)} % there and "
        f"{numeral(100.0 * first.damping)} %"
        if trend.shifts and trend.damps
        else f"damping {numeral(100.0 * last.damping)} % at the smallest amplitude, "
        f"{numeral(100.0 * first.damping)} % at the largest"
        if trend.damps
        else "no trend of damping"
    )
    law = law_words(trend)
    return f"{frequency}; {damping}.{f' {law}' if law else ''}"


def law_words(trend: DecayTrend) -> str:
    """Return which laws would do that; empty where nothing changes."""
    shift = trend.shift if trend.shifts else 0.0
    found = (
        (trend.law == -1, "A part of the damping goes as 1/amplitude: dry friction "
         "(coulomb_friction)."),
        (trend.law == 1, "A part of the damping goes as amplitude: a quadratic law "
         "(quadratic_damping)."),
        (shift < 0.0 and trend.damps, "Softer at larger amplitude, with another damping: slip "
         "in a joint (jenkins, iwan, bouc_wen)."),
        (shift > 0.0, "Stiffer at larger amplitude: a gap or a hardening spring (gap, "
         "cubic_stiffness)."),
        (shift < 0.0, "Softer at larger amplitude: a softening spring (cubic_stiffness)."),
        (trend.damps, "Damping changes with amplitude, and stiffness does not."),
    )  # fmt: skip
    return next((text for holds, text in found if holds), "")
