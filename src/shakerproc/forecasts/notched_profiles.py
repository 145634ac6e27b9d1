"""Notched profiles: as a planned test has them, as a log writes them, and as CSV."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.errors import LogError
from shakerproc.forecasts.notches import corners_of
from shakerproc.planning.drive import noise_profile
from shakerproc.spectra.profiles import profile_at
from shakerproc.testlog import BROADBAND, Test
from shakerproc.testlog.excitation import LEVELS, LevelUnit, Profile

WRITTEN: Final[Mapping[str, tuple[str, float, str]]] = MappingProxyType({
    "(m/s^2)^2/Hz": ("g^2/Hz", STANDARD_GRAVITY**2, "level_g2_per_hz"),
    "m/s^2": ("g", STANDARD_GRAVITY, "level_g"),
    "N^2/Hz": ("N^2/Hz", 1.0, "level_n2_per_hz"),
    "N": ("N", 1.0, "level_n"),
    "(rad/s^2)^2/Hz": ("(rad/s^2)^2/Hz", 1.0, "level_rad2_per_s4_per_hz"),
    "rad/s^2": ("rad/s^2", 1.0, "level_rad_per_s2"),
    "(N m)^2/Hz": ("(N m)^2/Hz", 1.0, "level_n2_m2_per_hz"),
    "N m": ("N m", 1.0, "level_n_m"),
})
"""Unit that a profile is written in, its size in SI, and the key of JSON."""

_DIGITS: Final = 5  # of what is written, and simulated so


def profile_of_test(test: Test) -> Profile:
    """Return the profile that a planned test demands, flat where the log says one level.

    Raises
    ------
    LogError
        If the log does not say level and band.
    """
    if test.excitation in BROADBAND:
        shape = noise_profile(test)
        frequency, level = shape.frequency, shape.density
    elif test.profile is not None:
        frequency, level = test.profile.frequency_hz, test.profile.level
    elif test.band is not None and test.level is not None:
        frequency, level = test.band, (test.level, test.level)
    else:
        raise LogError(f"{test.source}: test {test.id}: no level and band; add them")
    name, unit = f"test {test.id}", _unit_of(test)
    none = (0.0,) * len(frequency)
    given = test.profile
    if given is not None:
        return replace(given, frequency_hz=tuple(frequency), level=tuple(level))
    return Profile(name, unit, tuple(frequency), tuple(level), none, none)


def _unit_of(test: Test) -> LevelUnit:
    """Return the unit of a profile of the same signal as the level of a test."""
    if test.profile is not None or test.level_unit is None:
        return "m/s^2" if test.profile is None else test.profile.unit
    kind = "density" if test.excitation in BROADBAND else "amplitude"
    signal = LEVELS[test.level_unit][1]
    return next(unit for unit, level in LEVELS.items() if level == (kind, signal))


def demand_at(test: Test, frequency: FloatArray) -> FloatArray:
    """Return what a planned test demands at frequencies inside its band [Hz], an array."""
    profile = profile_of_test(test)
    corners = np.array(profile.frequency_hz)
    inside = np.clip(frequency, corners[0], corners[-1])
    return profile_at(inside, corners, np.array(profile.level))


def notched_test(test: Test, frequency: FloatArray, reduction: FloatArray) -> Test:
    """Return a planned test with a reduction of its profile, straight between breakpoints.

    Parameters
    ----------
    test : Test
        As planned.
    frequency : (n_bins,) array
        Rising frequencies [Hz].
    reduction : (n_bins,) array
        What is taken away there [dB].
    """
    if not np.any(reduction):
        return test
    profile = profile_of_test(test)
    kept = corners_of(np.log2(frequency), reduction)
    corners = np.union1d(np.array(profile.frequency_hz), frequency[kept[1:-1]])
    corners = np.unique([_written(at) for at in corners])
    taken = np.interp(np.log2(corners), np.log2(frequency), reduction)
    per_decade = 10.0 if profile.unit.endswith("/Hz") else 20.0
    scale = WRITTEN[profile.unit][1]
    levels = demand_at(test, corners) * 10.0 ** (-taken / per_decade)
    level = tuple(scale * _written(one / scale) for one in levels)
    notched = replace(
        profile,
        name=f"test {test.id} notched",
        frequency_hz=tuple(float(one) for one in corners),
        level=level,
        alarm_db=(0.0,) * len(level),
        abort_db=(0.0,) * len(level),
        notches=(),
    )
    return replace(test, profile=notched, level=None, level_unit=None, level_text="")


def _written(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def profile_yaml(profile: Profile, note: str) -> str:
    """Return a profile as a log has it below ``profiles:``, with a comment above."""
    unit, scale, _ = WRITTEN[profile.unit]
    rows = [
        f"      - [{at:.{_DIGITS}g} Hz, {level / scale:.{_DIGITS}g} {unit}]"
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]
    head = [f"# {note}", "profiles:", f'  "{profile.name}":', "    breakpoints:"]
    return "\n".join([*head, *rows, ""])


def profile_csv(profile: Profile) -> str:
    """Return a profile as the CSV file that ``file:`` of a profile names."""
    unit, scale, _ = WRITTEN[profile.unit]
    rows = [
        f"{at:.{_DIGITS}g},{level / scale:.{_DIGITS}g}"
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]
    return "\n".join([f"frequency [Hz],demand [{unit}]", *rows, ""])
