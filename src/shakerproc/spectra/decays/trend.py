"""Whether frequency and damping of a decay change with its amplitude, and by which law."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.decays.reading import Reading

LEAST: Final = 5
"""Readings that a trend needs at least [-]: three beyond a constant and a power."""

SHARED: Final = 2.0
"""How much of the scatter is left out as each reading shares half its stretch with the one
before [-]: as if every other reading were."""

SURE: Final = 0.99
"""Probability that chance shows no trend [-]: of a hundred decays of a linear structure one
does."""

EXPLAINED: Final = 0.98
"""Share of the change of damping that a law explains at least to be named [-]."""

MUCH: Final = 1.3
"""Least factor between the smallest and the largest damping of which a law is named [-]: a gap
or a cubic spring changes the ratio by less with no damping of its own."""

FLOOR: Final = 0.02
"""Error of a damping beside its interval when laws are compared, over its value [-]: laws of
smooth curves are known no better."""


@final
@dataclass(frozen=True, slots=True)
class DecayTrend:
    """How a mode depends on its amplitude.

    Attributes
    ----------
    shift : float
        Frequency at the largest amplitude less that at the smallest, over that [-].
    shifts : bool
        Whether the frequency changes by more than its intervals allow.
    exponent : float
        Mean exponent p where the damping ratio goes as amplitude to the power p [-].
    damps : bool
        Whether the damping changes by more than its intervals allow.
    law : int
        Power n where the damping is a constant and amplitude to the power n: -1 or 1; 0 where
        neither explains it.
    """

    shift: float
    shifts: bool
    exponent: float
    damps: bool
    law: int


def trend_of(readings: Sequence[Reading], beside: Sequence[Reading] = ()) -> DecayTrend | None:
    """Return how a mode depends on its amplitude; None where too few readings tell.

    Parameters
    ----------
    readings : sequence of Reading
        Of one method along the decay, each sharing half of its stretch with the one before.
    beside : sequence of Reading
        Those of a model: then the trend is that of frequency over the model's and of damping
        less the model's, at amplitudes that both have.
    """
    used = [one for one in readings if one.damping > 0.0]
    base = at_amplitudes(beside, [one.amplitude for one in used]) if beside else None
    if base is not None:
        used = [one for one, known in zip(used, base.known, strict=True) if known]
    if len(used) < LEAST:
        return None
    amplitude, frequency, damping, frequency_error, damping_error = columns_of(used)
    floor = FLOOR * damping
    exponent = float(np.polyfit(np.log(amplitude), np.log(damping), 1)[0])
    least = (MUCH - 1.0) * float(damping.min())
    if base is not None:
        frequency = frequency / base.frequency
        frequency_error = (frequency_error + base.frequency_error) / base.frequency
        damping, damping_error = damping - base.damping, damping_error + base.damping_error
    damps = _changes(damping, damping_error)
    errors = np.hypot(damping_error, floor)
    return DecayTrend(
        shift=float(frequency[0] / frequency[-1] - 1.0),
        shifts=_changes(frequency, frequency_error),
        exponent=exponent,
        damps=damps,
        law=_law(amplitude, damping, errors) if damps and np.ptp(damping) > least else 0,
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Readings at given amplitudes.

    Attributes
    ----------
    frequency, damping : (n_known,) array
        Between the readings, straight over the logarithm of amplitude [Hz], [-].
    frequency_error, damping_error : (n_known,) array
        Half the widths of their intervals [Hz], [-].
    known : (n,) array of bool
        Which of the amplitudes the readings reach.
    """

    frequency: FloatArray
    damping: FloatArray
    frequency_error: FloatArray
    damping_error: FloatArray
    known: NDArray[np.bool_]


def at_amplitudes(readings: Sequence[Reading], amplitudes: Sequence[float]) -> Curve:
    """Return the readings at amplitudes between their smallest and their largest.

    `amplitudes` are in the unit of the readings.
    """
    amplitude, *others = columns_of(readings)
    rising = np.argsort(amplitude)
    wanted = np.asarray(amplitudes, float)
    known = (wanted >= amplitude.min()) & (wanted <= amplitude.max())
    place, along = np.log(amplitude[rising]), np.log(wanted[known])
    frequency, damping, *errors = (np.interp(along, place, row[rising]) for row in others)
    return Curve(frequency, damping, errors[0], errors[1], known)


def columns_of(readings: Sequence[Reading]) -> tuple[FloatArray, ...]:
    """Return amplitude, frequency, damping and the half widths of both intervals as arrays."""
    names = ("amplitude", "frequency", "damping", "frequency_error", "damping_error")
    return tuple(np.array([getattr(one, name) for one in readings]) for name in names)


def _changes(values: FloatArray, errors: FloatArray) -> bool:
    """Return whether values differ by more than half their 95 % intervals allow."""
    weights = (1.96 / errors) ** 2
    mean = float(weights @ values / weights.sum())
    scatter = float(weights @ (values - mean) ** 2) / SHARED
    return scatter > float(scipy.special.chdtri(values.size - 1, 1.0 - SURE))


def _law(amplitude: FloatArray, damping: FloatArray, errors: FloatArray) -> int:
    """Return the power n of the law a + b A^n, b above 0, that explains damping; 0 of none."""
    weights = 1.0 / errors**2
    mean = float(weights @ damping / weights.sum())
    whole = float(weights @ (damping - mean) ** 2)
    root = np.sqrt(weights)
    explained = {}
    for power in (-1, 1):
        design = np.stack([np.ones(amplitude.size), amplitude**power], axis=1)
        found, *_ = np.linalg.lstsq(design * root[:, np.newaxis], damping * root, rcond=None)
        left = float(weights @ (damping - design @ found) ** 2)
        explained[power] = 1.0 - left / whole if found[1] > 0.0 else 0.0
    best = max(explained, key=lambda power: explained[power])
    return best if explained[best] >= EXPLAINED else 0
