r"""Drops of the control at a resonance: a specimen that pulls at the shaker there.

A specimen of mass :math:`m` on a table of mass :math:`M` that a force drives lowers the
acceleration of the table to

.. math:: \left|\frac{\ddot y}{\ddot y_0}\right| = \left|1 + \frac{m}{M} A(f)\right|^{-1},
    \qquad A(f_0) \approx \frac{1}{2 i \zeta}

with the transmissibility A of the specimen. It is lowest at the resonance :math:`f_0` that the
specimen has on a table that stands still, which is that of its response over the control. A
controller that does not keep up leaves the drop, whatever the level beside it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.runs.result import RunResult
from shakerproc.spectra.profiles import profile_at, surely_beyond
from shakerproc.testlog import Profile

HALF_OCTAVE: Final = 2.0**0.5
"""Reach of the surroundings of a resonance, over and under its frequency [-]."""

_RANDOM: Final = ("random", "sine on random")


@final
@dataclass(frozen=True, slots=True)
class ControlDrop:
    """A drop of the control.

    Attributes
    ----------
    channel : int
        Row of the response whose resonance it is.
    frequency : float
        [Hz].
    decibels : float
        Control over its surroundings, below 0 [dB].
    """

    channel: int
    frequency: float
    decibels: float


def drop_sentence(drop: ControlDrop, result: RunResult) -> str:
    """Return a drop in words, and what to do."""
    name, at = result.channels[drop.channel].name, numeral(drop.frequency, 4)
    return (
        f"the control drops by {-drop.decibels:.1f} dB at {at} Hz, a resonance of {name}: the "
        f"specimen pulls at the shaker there, and the controller does not make up for it. The "
        f"level of the log is not that at this resonance; control finer and slower there, or "
        f"state a notch that is meant in the profile"
    )


def control_drops(result: RunResult) -> list[ControlDrop]:
    """Return where the control drops by more than its alarm limit, the deepest first.

    Against its surroundings, an octave wide, in terms of the profile where there is one: the
    whole band may be too low, which is told as the level. Of a density a drop counts that
    chance does not make; of blows, shocks, decays and measured motions none is looked for.
    """
    if not result.controls or not result.responses:
        return []
    found = _of_density(result) if result.test.excitation in _RANDOM else _of_sweeps(result)
    kept: list[ControlDrop] = []
    for one in sorted(found, key=lambda drop: drop.decibels):
        if all(max(one.frequency, k.frequency) > HALF_OCTAVE * min(one.frequency, k.frequency)
               for k in kept):  # fmt: skip
            kept.append(one)
    return kept


def _of_density(result: RunResult) -> Iterator[ControlDrop]:
    lines = result.spectra.frequency
    wanted = _shape(result.test.profile, lines, density=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = result.psd[list(result.controls)].mean(axis=0) / wanted
    inside = np.isfinite(level) & (level > 0.0) & (lines > 0.0)
    inside &= (lines >= result.band[0]) & (lines <= result.band[1])
    lines, level = lines[inside], level[inside]
    limit = 10.0 ** (-result.test.processing.tolerance.alarm / 10.0)
    for row in result.responses:
        for one in result.response_peaks[row]:
            around = _surroundings(lines, np.log(level), one.peak.frequency)
            if around is None:
                continue
            part, smooth = around
            ratio = level[part] / np.exp(smooth)
            sure = surely_beyond(ratio / limit, result.spectra, above=False, anywhere=True)
            at = int(np.argmin(np.abs(lines[part] - one.peak.frequency)))
            if sure[at]:
                mean = float(np.mean(ratio[max(at - 1, 0) : at + 2]))
                yield ControlDrop(row, one.peak.frequency, 10.0 * np.log10(mean))


def _of_sweeps(result: RunResult) -> Iterator[ControlDrop]:
    for sweep in result.tracking.sweeps:
        order = np.argsort(sweep.frequency)
        lines, control = sweep.frequency[order], sweep.control[order]
        wanted = _shape(result.test.profile, lines, density=False)
        level = control / wanted
        known = np.isfinite(level) & (level > 0.0)
        lines, level = lines[known], level[known]
        for reading in result.swept:
            if reading.direction != sweep.direction:
                continue
            around = _surroundings(lines, np.log(level), reading.frequency)
            if around is None:
                continue
            part, smooth = around
            at = int(np.argmin(np.abs(lines[part] - reading.frequency)))
            drop = 20.0 * float(np.log10(level[part][at]) - smooth[at] / np.log(10.0))
            if drop < -result.test.processing.tolerance.alarm:
                yield ControlDrop(reading.channel, reading.frequency, drop)


def _shape(profile: Profile | None, lines: FloatArray, *, density: bool) -> FloatArray:
    """Return the profile at some frequencies, lowered by its notches; else 1 everywhere.

    `lines` are frequencies [Hz]; not a number beyond the profile.
    """
    if profile is None or profile.unit.endswith("/Hz") is not density:
        return np.ones(lines.shape)
    wanted = profile_at(lines, np.array(profile.frequency_hz), np.array(profile.level))
    for notch in profile.notches:
        meant = (lines >= notch.low) & (lines <= notch.high)
        wanted[meant] *= 10.0 ** (-notch.depth / (10.0 if density else 20.0))
    return wanted


def _surroundings(
    lines: FloatArray, level: FloatArray, frequency: float
) -> tuple[slice, FloatArray] | None:
    """Return the lines around a resonance, and the smooth level there.

    It is straight over the logarithm of the frequency, through the medians of both sides.

    Parameters
    ----------
    lines, level : (n,) arrays
        Rising frequencies [Hz], and the logarithm of the level [-].
    frequency : float
        Of the resonance [Hz].

    Returns
    -------
    part : slice
        Lines as far above as below: half an octave, or to the nearer end of the band.
    smooth : (n_part,) array
        Logarithm of the level [-].
        None where there are not two lines on each side of the resonance and its neighbours.
    """
    if lines.size < 2 or not lines[0] < frequency < lines[-1]:
        return None
    reach = min(HALF_OCTAVE, frequency / lines[0], lines[-1] / frequency)
    first, stop = np.searchsorted(lines, [frequency / reach, frequency * reach])
    at = int(np.argmin(np.abs(lines - frequency)))
    below, above = slice(first, at - 1), slice(at + 2, stop)
    if below.stop - below.start < 2 or above.stop - above.start < 2:
        return None
    octaves = np.log(lines)
    (x0, y0), (x1, y1) = (
        (float(np.mean(octaves[side])), float(np.median(level[side])))
        for side in (below, above)
    )
    part = slice(int(first), int(stop))
    return part, y0 + (octaves[part] - x0) * (y1 - y0) / (x1 - x0)
