"""The floor of the free-run error: what the noise of a test alone makes of it."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.errors import Pair
from shakerproc.comparison.free_run_error import (
    Scored,
    edges,
    measured_rms,
    pooled,
    relative_errors,
    standard_error,
)
from shakerproc.comparison.noise import LEFT, NOT_REFUTED, UNKNOWN, Noise, Refuted
from shakerproc.comparison.noise_sources import smoothed
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import FloatArray
from shakerproc.spectra import psd

BEATEN_BY: Final = 2.0
"""Standard errors below a floor at which an error refutes it (a starting value) [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """Noise of one test.

    Attributes
    ----------
    share : (n_sensors,) array
        Noise over response, both rms within the band of the error; not a number where it is
        unknown [-].
    source : str
        Where it was taken from.
    refuted : Refuted
        Sources that were beaten by more than two standard errors, and so are no floor.
    """

    share: FloatArray
    source: str
    refuted: Refuted = NOT_REFUTED


def floor_shares(test: Scored, noise: Noise, moved: FloatArray) -> FloatArray:
    r"""Return the error that the true model would have, (n_sensors,) array.

    .. math:: \sqrt{\int G_{nn} \, df + \mathrm{rms}(\Delta \hat y)^2}
        \Big/ \mathrm{rms}(y)

    within the band of the error: the noise of the sensor, and what noise of the input makes of
    the simulated response.

    Parameters
    ----------
    test : Scored
        A test, measured and simulated.
    noise : Noise
        Of the test.
    moved : (n_draws, n_sensors, n) array
        By how much the simulated response moves under `noise.drawn` on the input [unit].

    Returns
    -------
    (n_sensors,) array
        Share of the response; not a number where the noise is unknown [-].
    """
    return over_draws(floor_draws(test, noise, moved))


def floor_draws(test: Scored, noise: Noise, moved: FloatArray) -> FloatArray:
    """Return the noise floor of every draw by itself, (n_draws, n_sensors) array [-]."""
    own = sensor_shares(test, noise)
    draws = [relative_errors(replace(test, simulated=test.measured - one)) for one in moved]
    return np.array([np.hypot(own, passed) for passed in draws])


def over_draws(draws: FloatArray) -> FloatArray:
    """Return the rms over draws, (n_sensors,) array [-]."""
    shares: FloatArray = np.sqrt(np.mean(draws**2, axis=0))
    return shares


def sensor_shares(test: Scored, noise: Noise) -> FloatArray:
    """Return the noise of the responses alone over the response, (n_sensors,) array [-]."""
    if not noise.known:
        return np.full(len(test.measured), np.nan)
    gain = edges(noise.frequency, test.band) ** 2
    own = np.sum(noise.responses * gain, axis=1) * float(noise.frequency[0])
    rms = measured_rms(test)
    shares: FloatArray = np.sqrt(own) / np.where(rms > 0.0, rms, np.nan)
    return shares


def floor_of(prediction: Prediction, refuted: Refuted = NOT_REFUTED) -> Floor:
    """Return the noise floor of a test under a model."""
    noise = prediction.measured.noise
    share = floor_shares(prediction.scored, noise, prediction.moved)
    return Floor(share, noise.source, refuted)


def density_of(prediction: Prediction, pair: Pair) -> FloatArray:
    """Return noise at the bins of a pair, (n_sensors, n_frequencies) array [unit^2/Hz]."""
    measured = prediction.measured
    moved = prediction.moved[:, :, prediction.scored.counted]
    passed = np.mean([_density(one, measured.sample_rate, pair) for one in moved], axis=0)
    return np.asarray(measured.noise.responses_at(pair.frequency) + passed)


def _density(rows: FloatArray, sample_rate: float, pair: Pair) -> FloatArray:
    """Return smoothed densities at the bins of a pair, (n_rows, n_frequencies) array."""
    cross = smoothed(rows, sample_rate)
    return np.array([np.interp(pair.frequency, cross.frequency, row) for row in psd(cross)])


def with_more_refuted(
    test: Scored, noise: Noise, draws: FloatArray | None, refuted: Refuted
) -> Refuted:
    """Return the sources of noise that are refuted, by an error on what was held out besides.

    Noise that the simulation of a model beats on what it was not fitted to is less: that of
    the responses, or else what that of the input makes of the simulated response in every
    draw. In a few draws the motion may part, which it did not in the test. Of the last source
    of the input as much stays as makes the error that was left.

    Parameters
    ----------
    test : Scored
        What was held out of a test, measured and simulated.
    noise : Noise
        Of the test.
    draws : (n_draws, n_sensors) array or None
        Noise over response, that of the input included (see `floor_draws`) [-].
    refuted : Refuted
        What was refuted before.
    """
    if is_beaten(test, sensor_shares(test, noise)):
        return replace(refuted, responses=_with(refuted.responses, noise.source))
    driven = noise.input_source != UNKNOWN
    if driven and draws is not None and all(is_beaten(test, one) for one in draws):
        if noise.input_source not in {LEFT, *refuted.inputs}:
            return replace(refuted, inputs=_with(refuted.inputs, noise.input_source))
        if refuted.share == 1.0:  # once: a better model would ask for another search
            return replace(refuted, share=_room(test, noise, draws))
    return refuted


def _room(test: Scored, noise: Noise, draws: FloatArray) -> float:
    """Return the share of the noise of the input that makes an error [-].

    (e^2 - n^2) / (f^2 - n^2) of error e, floor f over all draws, and n, sensors' part of both.
    """
    own, left = sensor_shares(test, noise), relative_errors(test)
    of_sensors, error, floor = (pooled([one]) ** 2 for one in (own, left, over_draws(draws)))
    return max(error - of_sensors, 0.0) / (floor - of_sensors)


def _with(names: tuple[str, ...], more: str) -> tuple[str, ...]:
    return names if more in names else (*names, more)


def is_beaten(test: Scored, shares: FloatArray) -> bool:
    """Return whether shares of noise exceed an error beyond its uncertainty.

    Parameters
    ----------
    test : Scored
        A test, measured and simulated.
    shares : (n_sensors,) array
        Noise over response; where one is not a number, nothing is beaten [-].
    """
    if not np.all(np.isfinite(shares)):
        return False
    error = pooled([relative_errors(test)])
    return error + BEATEN_BY * standard_error([test]) < pooled([shares])
