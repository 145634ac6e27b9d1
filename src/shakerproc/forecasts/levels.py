"""Levels of tests: how strongly each shakes, and which of them are one level."""

from collections.abc import Sequence
from math import sqrt
from typing import Final

import numpy as np

from shakerproc.comparison import Measured
from shakerproc.comparison.part import AROUND
from shakerproc.numerals import numeral
from shakerproc.planning.drive import noise_profile
from shakerproc.planning.planned import level_text
from shakerproc.testlog import BROADBAND, Test
from shakerproc.testlog.excitation import LEVELS

ONE_LEVEL_DB: Final = 1.0
"""Difference up to which tests are of one level: what controllers keep to [dB]."""


def amplitude_of(test: Test) -> float | None:
    """Return the rms of the drive that a log demands; None where it does not say it [SI]."""
    if test.excitation in BROADBAND and (test.profile or test.level):
        return noise_profile(test).rms
    if test.profile is not None:
        return max(test.profile.level) / sqrt(2.0)
    if test.level is None or test.level_unit is None:
        return None
    kind = LEVELS[test.level_unit][0]
    return test.level / sqrt(2.0) if kind == "amplitude" else test.level


def amplitude_of_measured(measured: Measured) -> float:
    """Return the rms of the drive that was demanded, or measured where none was [SI]."""
    demanded = amplitude_of(measured.test)
    return drive_rms(measured) if demanded is None else demanded


def drive_rms(measured: Measured) -> float:
    """Return the rms of the measured drive in the part that is compared [SI]."""
    return float(np.std(measured.input[measured.start : measured.stop]))


def decibels(ratio: float) -> float:
    """Return a ratio of amplitudes in decibels [dB]."""
    return 20.0 * float(np.log10(ratio))


def grouped(tests: Sequence[Measured]) -> list[list[Measured]]:
    """Return the tests of each level, the lowest level first."""
    found: list[list[Measured]] = []
    for test in sorted(tests, key=amplitude_of_measured):
        here = amplitude_of_measured(test)
        first = amplitude_of_measured(found[-1][0]) if found else 0.0
        if not first or decibels(here / first) > ONE_LEVEL_DB:
            found.append([])
        found[-1].append(test)
    return found


def driven_alike(one: Test, other: Test) -> bool:
    """Return whether tests are of one kind of excitation, and sweeps of one direction."""
    return one.excitation == other.excitation and _rises(one) == _rises(other)


def _rises(test: Test) -> bool:
    """Return whether a test sweeps upwards, or not at all."""
    return test.from_hz is None or test.to_hz is None or test.from_hz <= test.to_hz


def nearest_level(tests: Sequence[Measured], to: Test, amplitude: float) -> list[Measured]:
    """Return the tests of the level next to an amplitude [SI], driven alike if any is."""
    alike = [test for test in tests if driven_alike(test.test, to)] or list(tests)
    apart = [abs(decibels(amplitude_of_measured(test) / amplitude)) for test in alike]
    first = amplitude_of_measured(alike[apart.index(min(apart))])
    return [
        test
        for test in alike
        if abs(decibels(amplitude_of_measured(test) / first)) <= ONE_LEVEL_DB
    ]


def excited_band(test: Test) -> tuple[float, float] | None:
    """Return the band that a test excites [Hz]; None where its log does not say it."""
    if test.band is None and test.frequency_hz is not None:
        low, high = (share * test.frequency_hz for share in AROUND)
        return low, high
    return test.band


def raised_level_text(test: Test, decibel: float = 0.0) -> str:
    """Return the level of a test as a log writes it, so many decibels higher [dB]."""
    if test.level is None or test.level_unit is None:
        named = f"profile {test.profile.name}" if test.profile else "its level"
        return f"{named} {decibel:+.1f} dB" if decibel else named
    if not decibel:
        return test.level_text
    power = 2.0 if LEVELS[test.level_unit][0] == "density" else 1.0
    return level_text(test.level * 10.0 ** (power * decibel / 20.0), test.level_unit)


def in_order(levels: Sequence[Sequence[Measured]]) -> str:
    """Return the levels that were run, for people."""
    return ", ".join(
        group[0].test.level_text or numeral(drive_rms(group[0])) for group in levels
    )
