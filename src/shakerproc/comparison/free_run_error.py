"""The free-run error: measured less simulated, of every sensor of every test, as one number."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray

BLOCKS: Final = 12
"""Parts of a test that are left out in turn for a standard error: each long against the decay
of a resonance, and enough of them for the scatter of their sums [-]."""

_PADDING: Final = 2048
"""Zeros behind the samples, so that the filter's end does not reach round to the start [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Scored:
    """One test, measured and simulated from its measured input, never corrected on the way.

    Attributes
    ----------
    measured, simulated : (n_sensors, n) array
        What each sensor measured, and what the model says, in the unit of the sensor.
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        What counts: `from` to `to` of the test, or where it exceeds its noise [Hz].
    counted : (n,) array of bool
        Which samples count: the judged part; where a motion cannot be predicted for a whole
        test, what follows the first two periods of every window.
    """

    measured: FloatArray
    simulated: FloatArray
    sample_rate: float
    band: tuple[float, float]
    counted: NDArray[np.bool_]

    def within(self, counted: NDArray[np.bool_]) -> "Scored":
        """Return the test with only those of its samples counted that are true here.

        `counted` is an (n,) array of bool [-].
        """
        return replace(self, counted=self.counted & counted)


def free_run_error(tests: Sequence[Scored]) -> float:
    r"""Return the error of a model over tests and sensors.

    .. math:: e = \sqrt{\frac{1}{N} \sum_{i=1}^{N}
        \left(\frac{\mathrm{rms}(y_i - \hat y_i)}{\mathrm{rms}(y_i)}\right)^2}

    with one term for each sensor of each test.

    Parameters
    ----------
    tests : sequence of Scored
        Tests that took no part in the fit.

    Returns
    -------
    float
        Share of the response that the model does not explain; not a number without any
        sample that counts [-].
    """
    return pooled([relative_errors(test) for test in tests if test.counted.any()])


def pooled(shares: Sequence[FloatArray]) -> float:
    """Return the root of the mean square over tests and sensors of shares of them [-]."""
    both = np.concatenate(shares) if shares else np.zeros(0)
    return float(np.sqrt(np.mean(both**2))) if both.size else float("nan")


def relative_errors(test: Scored) -> FloatArray:
    """Return rms of measured less simulated over rms measured, (n_sensors,) array [-]."""
    left, whole = squares(test)
    return _ratio(left[:, test.counted].sum(axis=1), whole[:, test.counted].sum(axis=1))


def relative_residuals(test: Scored) -> FloatArray:
    """Return measured less simulated over measured rms, (n_sensors, n) array [-].

    Within the band, 0 where it does not count, and scaled so that the sum of the squares is the
    square of the test's error.
    """
    left = _left(test)
    kept = np.where(test.counted, in_band(left, test.sample_rate, test.band), 0.0)
    rms = measured_rms(test)[:, np.newaxis]
    count = len(rms) * max(1, int(np.count_nonzero(test.counted)))
    residuals: FloatArray = kept / np.where(rms > 0.0, rms, 1.0) / count**0.5
    return residuals


def measured_rms(test: Scored) -> FloatArray:
    """Return the rms of what was measured, in the band, (n_sensors,) array [unit]."""
    kept = in_band(test.measured, test.sample_rate, test.band)[:, test.counted]
    rms: FloatArray = np.sqrt(np.mean(kept**2, axis=1))
    return rms


def fall(before: Sequence[Scored], after: Sequence[Scored]) -> tuple[float, float]:
    """Return by how much the error falls from one model to another, and its standard error.

    Blocks of the tests are left out in turn (jackknife): a fall that hangs on one of them is
    uncertain.

    Parameters
    ----------
    before, after : sequence of Scored
        The same tests, the same samples counted, simulated with one model and the other.

    Returns
    -------
    (float, float)
        Error before less error after, and the standard error of that [-].

    References
    ----------
    .. [1] B. Efron and R. J. Tibshirani, "An Introduction to the Bootstrap", Chapman and Hall,
       1993, ch. 11.
    """
    was, now = (_by_block(tests) for tests in (before, after))
    falls = _without_one(was) - _without_one(now)
    n = falls.size
    spread = (n - 1.0) / n * float(np.sum((falls - falls.mean()) ** 2))
    return free_run_error(before) - free_run_error(after), spread**0.5


def standard_error(tests: Sequence[Scored]) -> float:
    """Return the standard error of `free_run_error`, by leaving out blocks in turn [-]."""
    errors = _without_one(_by_block(tests))
    n = errors.size
    return float(np.sqrt((n - 1.0) / n * np.sum((errors - errors.mean()) ** 2)))


def in_band(samples: FloatArray, sample_rate: float, band: tuple[float, float]) -> FloatArray:
    """Return samples within a band, along the last axis, an array like them.

    Their mean, which is in no band, does not meet the zeros behind them as a step.

    Parameters
    ----------
    samples : (..., n) array
        Any unit.
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Limits, in the middle of flanks of a tenth of them [Hz].
    """
    n = samples.shape[-1]
    length = scipy.fft.next_fast_len(n + _PADDING, real=True)
    centred = samples - samples.mean(axis=-1, keepdims=True)
    spectrum: ComplexArray = scipy.fft.rfft(centred, length)
    spectrum *= edges(scipy.fft.rfftfreq(length, 1.0 / sample_rate), band)
    kept: FloatArray = scipy.fft.irfft(spectrum, length)[..., :n]
    return kept


def edges(frequency: FloatArray, band: tuple[float, float]) -> FloatArray:
    """Return 1 within a band and 0 outside, with cosine flanks of a tenth of its limits.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Frequencies [Hz].
    band : (float, float)
        Limits, in the middle of the flanks [Hz].

    Returns
    -------
    (n_frequencies,) array
        Gain [-].
    """
    low, high = band
    rise = np.clip((frequency / low - 0.9) / 0.2, 0.0, 1.0)
    fall = np.clip((frequency / high - 0.9) / 0.2, 0.0, 1.0)
    gain: FloatArray = 0.25 * (1.0 - np.cos(np.pi * rise)) * (1.0 + np.cos(np.pi * fall))
    return gain


def squares(test: Scored) -> tuple[FloatArray, FloatArray]:
    """Return squares of measured less simulated and of measured, within the band.

    What does not count is 0 before the filter, so that a run-in is not smeared into what does.
    """
    left = _left(test)
    rows = np.concatenate([left, test.measured])
    kept = in_band(rows, test.sample_rate, test.band) ** 2
    return kept[: len(left)], kept[len(left) :]


def _left(test: Scored) -> FloatArray:
    """Return measured less simulated where it counts, without its mean, and 0 elsewhere.

    A constant is in no band; beside zeros it would be a step, which is in every one.
    """
    left = np.where(test.counted, test.measured - test.simulated, 0.0)
    mean = left.sum(axis=1, keepdims=True) / max(1, np.count_nonzero(test.counted))
    return np.where(test.counted, left - mean, 0.0)


def _ratio(left: FloatArray, whole: FloatArray) -> FloatArray:
    """Return roots of ratios: 0 of nothing is 0, anything of nothing is infinite."""
    known = whole > 0.0
    nothing = np.where(left > 0.0, np.inf, 0.0)
    ratio: FloatArray = np.sqrt(np.where(known, left / np.where(known, whole, 1.0), nothing))
    return ratio


def _by_block(tests: Sequence[Scored]) -> list[tuple[FloatArray, FloatArray]]:
    """Return for each test the sums of both squares, (n_sensors, BLOCKS) arrays."""
    found = []
    for test in tests:
        where = np.flatnonzero(test.counted)
        if not where.size:
            continue
        first = np.linspace(0, where.size, min(BLOCKS, where.size) + 1).astype(int)[:-1]
        left, whole = (np.add.reduceat(rows[:, where], first, axis=1) for rows in squares(test))
        found.append((left, whole))
    return found


def _without_one(sums: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Return the error without each of the blocks in turn, (n_blocks,) array."""
    whole = [_ratio(left.sum(axis=1), size.sum(axis=1)) for left, size in sums]
    errors = []
    for i, (left, size) in enumerate(sums):
        for k in range(left.shape[1]):
            rest = (np.delete(rows, k, axis=1).sum(axis=1) for rows in (left, size))
            errors.append(pooled([*whole[:i], _ratio(*rest), *whole[i + 1 :]]))
    return np.array(errors)
