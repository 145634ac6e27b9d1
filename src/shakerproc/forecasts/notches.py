r"""Notches: the least that limits or a fixture take from a drive, their edges and profiles.

Of all reductions :math:`D(f)` of a drive that bring the mean squares of linear responses down
to what they may be, the one that takes away the least, in decibels times octaves, clips the
mean square that each octave gives, weighted by prices :math:`\lambda_q` of the limits:

.. math:: \min_D \int D \, d \ln f \quad \text{with} \quad
    \int P_q 10^{-D / 10} \, d \ln f \le T_q, \qquad
    D = \max\left(0,\; 10 \lg \sum_q \lambda_q P_q\right)

with :math:`P_q = f |H_q|^2 W` for a drive of density :math:`W`: where :math:`D > 0`, the
derivative :math:`1 - \lambda P 10^{-D / 10}` of the Lagrangian is 0. A sweep passes the
frequencies one after the other, so that its largest value is clipped where it exceeds.

Where a fixture gives way, semi-empirical force limits say what it would let into the specimen:

.. math:: S_{FF} \le C^2 M_0^2 S_{AA}, \quad f < f_0; \qquad
    S_{FF} \le C^2 M_0^2 S_{AA} (f_0 / f)^2, \quad f \ge f_0

with the mass :math:`M_0` of the specimen and the frequency :math:`f_0` at which the force is
largest. The drive is notched where the apparent mass :math:`S_{FF} / S_{AA}` exceeds it [1]_.

References
----------
.. [1] NASA-HDBK-7004C, "Force Limited Vibration Testing", 2012, ch. 5.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.errors import LogError
from shakerproc.forecasts.motion import TestMotion
from shakerproc.forecasts.quantities import segment_of
from shakerproc.planning.drive import frequency_of_sweep, noise_profile
from shakerproc.spectra import cross_spectra
from shakerproc.spectra.profiles import profile_at
from shakerproc.testlog import BROADBAND, Test
from shakerproc.testlog.excitation import LEVELS, LevelUnit, Profile

HALVINGS: Final = 50
"""Halvings of the logarithm of a price: to rounding [-]."""

SWEEPS: Final = 20
"""How often the prices of several limits are found in turn [-]."""

DEEPEST_DB: Final = 60.0
"""Reduction that is looked at: a controller has no more range [dB]."""

BREAKPOINT_ERROR: Final = 0.1
"""By how much breakpoints may miss a reduction: a tenth of what controllers keep to [dB]."""

C_SQUARED: Final = 4.0
"""Factor :math:`C^2`, for which the handbook's cases give 2 to 5 [-]."""

FORCE_INTO: Final = "force"
"""Whose quantity is the force into the specimen."""

PROFILE_UNITS: Final[Mapping[str, tuple[str, float, str]]] = MappingProxyType({
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

PER_OCTAVE: Final = 48
"""Bins in an octave: half a decibel along an edge of 24 dB/oct [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """A limit of a mean square.

    Attributes
    ----------
    power : (n_bins,) array
        What each bin of the full drive gives to it [unit^2].
    allowed : float
        What the sum may be [unit^2].
    """

    power: FloatArray
    allowed: float


def reduction_of(
    octaves: FloatArray, bounds: Sequence[Bound], least: FloatArray, slope: float
) -> FloatArray:
    """Return the least reduction that keeps limits of mean squares, (n_bins,) array [dB].

    Parameters
    ----------
    octaves : (n_bins,) array
        Logarithm to base 2 of the frequency of each bin, evenly rising [-].
    bounds : sequence of Bound
        The limits.
    least : (n_bins,) array
        Reduction that is needed anyway [dB].
    slope : float
        Steepest edge [dB/oct].
    """
    prices = np.zeros(len(bounds))

    def reduced(prices: FloatArray) -> FloatArray:
        total = sum((p * b.power for p, b in zip(prices, bounds, strict=True)), start=0.0)
        clipped = 10.0 * np.log10(np.maximum(total, 1.0)) * np.ones_like(octaves)
        return with_edges(octaves, np.minimum(np.maximum(clipped, least), DEEPEST_DB), slope)

    for _ in range(SWEEPS if len(bounds) > 1 else 1):
        for i, bound in enumerate(bounds):
            prices[i] = 0.0
            if _residual_power(bound, reduced(prices)) <= bound.allowed:
                continue
            largest = float(np.max(bound.power))
            low, high = -np.log(largest), DEEPEST_DB * np.log(10.0) / 10.0 - np.log(largest)
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                prices[i] = np.exp(middle)
                enough = _residual_power(bound, reduced(prices)) <= bound.allowed
                low, high = (low, middle) if enough else (middle, high)
            prices[i] = np.exp(high)
    return reduced(prices)


def _residual_power(bound: Bound, reduction: FloatArray) -> float:
    """Return the mean square that a reduction leaves [unit^2]."""
    return float(np.sum(bound.power * 10.0 ** (-reduction / 10.0)))


def with_edges(octaves: FloatArray, reduction: FloatArray, slope: float) -> FloatArray:
    """Return the least reduction above another one that is nowhere steeper, (n,) array [dB].

    Parameters
    ----------
    octaves : (n,) array
        Logarithm to base 2 of frequencies that rise [-].
    reduction : (n,) array
        What is taken away at least [dB].
    slope : float
        Steepest edge [dB/oct].
    """
    fall = slope * octaves
    rising = np.maximum.accumulate(reduction + fall) - fall
    falling = np.maximum.accumulate((reduction - fall)[::-1])[::-1] + fall
    return np.maximum(rising, falling)


def corners_of(octaves: FloatArray, reduction: FloatArray) -> list[int]:
    """Return the points between which a reduction is straight within 0.1 dB, both ends in.

    Parameters
    ----------
    octaves : (n,) array
        Logarithm to base 2 of the frequencies [-].
    reduction : (n,) array
        What is taken away [dB].

    References
    ----------
    .. [1] D. H. Douglas and T. K. Peucker, "Algorithms for the reduction of the number of
       points required to represent a digitized line", Cartographica 10, 112-122, 1973.
    """
    kept, parts = {0, octaves.size - 1}, [(0, octaves.size - 1)]
    while parts:
        first, last = parts.pop()
        between = np.arange(first + 1, last)
        if not between.size:
            continue
        line = np.interp(octaves[between], octaves[[first, last]], reduction[[first, last]])
        missed = np.abs(reduction[between] - line)
        at = int(between[np.argmax(missed)])
        if missed.max() > BREAKPOINT_ERROR:
            kept.add(at)
            parts += [(first, at), (at, last)]
    return sorted(kept)


def force_limited(
    frequency: FloatArray, apparent_mass: FloatArray, mass: float, slope: float
) -> FloatArray:
    """Return the reduction of a drive that a semi-empirical force limit asks for.

    Parameters
    ----------
    frequency : (n_bins,) array
        Rising frequencies [Hz].
    apparent_mass : (n_bins,) array
        Mean square of force over acceleration [kg^2].
    mass : float
        Mass of the specimen [kg].
    slope : float
        Steepest edge [dB/oct].

    Returns
    -------
    (n_bins,) array
        What is taken away [dB].
    """
    first = frequency[np.argmax(apparent_mass)]
    allowed = C_SQUARED * mass**2 * np.minimum(1.0, first / frequency) ** 2
    over = 10.0 * np.log10(np.maximum(apparent_mass / allowed, 1.0))
    return with_edges(np.log2(frequency), over, slope)


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
    """Return the demand of a planned test at frequencies inside its band [Hz], an array."""
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
    scale = PROFILE_UNITS[profile.unit][1]
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
    unit, scale, _ = PROFILE_UNITS[profile.unit]
    rows = [
        f"      - [{at:.{_DIGITS}g} Hz, {level / scale:.{_DIGITS}g} {unit}]"
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]
    head = [f"# {note}", "profiles:", f'  "{profile.name}":', "    breakpoints:"]
    return "\n".join([*head, *rows, ""])


def profile_csv(profile: Profile) -> str:
    """Return a profile as the CSV file that ``file:`` of a profile names."""
    unit, scale, _ = PROFILE_UNITS[profile.unit]
    rows = [
        f"{at:.{_DIGITS}g},{level / scale:.{_DIGITS}g}"
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]
    return "\n".join([f"frequency [Hz],demand [{unit}]", *rows, ""])


def edges_of_bins(band: tuple[float, float]) -> FloatArray:
    """Return the edges of bins of equal width in octaves, (n_bins + 1,) array [Hz].

    `band` is what a test excites [Hz].
    """
    octaves = float(np.log2(band[1] / band[0]))
    return np.geomspace(*band, max(2, round(PER_OCTAVE * octaves)) + 1)


def centres_of_bins(band: tuple[float, float]) -> FloatArray:
    """Return the middles of the bins of a band [Hz], (n_bins,) array [Hz]."""
    edges = edges_of_bins(band)
    return np.sqrt(edges[:-1] * edges[1:])


def passage(test: Test, motion: TestMotion, samples: FloatArray) -> FloatArray:
    r"""Return how a quantity follows the drive of one motion, bin by bin, (n_bins,) array.

    Of noise the mean square of the gain of the linear system nearest to it,
    :math:`|H_1|^2 = |S_{xy} / S_{xx}|^2`: what is not coherent with the drive at a frequency
    no notch there takes away [1]_. Of a sweep the largest size while it passes the bin.

    Parameters
    ----------
    test : Test
        What drives: random or a sine sweep.
    motion : TestMotion
        Its drive.
    samples : (n,) array
        The quantity.

    References
    ----------
    .. [1] J. S. Bendat, "Nonlinear System Techniques and Applications", Wiley, 1998, ch. 1.
    """
    band = test.band or (1.0, 0.5 * motion.sample_rate)
    edges = edges_of_bins(band)
    if test.excitation == "sine sweep":
        shares = np.arange(samples.size) / samples.size
        at = np.searchsorted(edges, frequency_of_sweep(test, shares), "right") - 1
        largest = np.zeros(edges.size - 1)
        inside = np.clip(at, 0, largest.size - 1)
        np.maximum.at(largest, inside, np.abs(samples - np.mean(samples)))
        return largest
    rows = np.array([motion.drive, samples])
    spectra = cross_spectra(
        rows, motion.sample_rate, segment=segment_of(samples.size), window="hann", inputs=[0]
    )
    cross = np.abs(spectra.between([0], [1])[0, 0])
    gain = cross / np.maximum(spectra.density[0], np.finfo(float).tiny)
    squares = np.where(spectra.frequency <= band[1], gain, 0.0) ** 2
    step = float(spectra.frequency[1] - spectra.frequency[0])
    whole = step * (np.cumsum(squares) - 0.5 * squares)
    return np.asarray(np.diff(np.interp(edges, spectra.frequency, whole)) / np.diff(edges))
