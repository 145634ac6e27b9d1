"""The test that would settle what is open, simulated with the hypotheses that compete."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.residuals import TOLERANCE
from shakerproc.diagnosis.joint_outcomes import Locked
from shakerproc.diagnosis.result import NextTest
from shakerproc.diagnosis.selection.excitations import (
    Trial,
    as_it_was,
    loudest,
    most_of,
    trials_of,
)
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.errors import ModelError
from shakerproc.models import Model
from shakerproc.simulation import Runs, free_runs, prepare
from shakerproc.testlog import Shaker

LEVELS: Final = (0.5, 1.0, 1.5, 2.0, 3.0)
"""Levels that are tried, as multiples of the loudest test: up to 10 dB more, beyond which a
specimen may break and a fitted law means little [-]."""

CLOSING: Final = (1.25, 1.5, 2.0, 3.0)
"""Largest motions that are tried, as multiples of a clearance that never closed [-]."""

BETTER: Final = 1.05
"""How much farther apart responses must be for a louder test, or one less like those of the
log: differences below it depend on the draw of the drive [-]."""

DECIBEL: Final = float(10.0 / np.log(10.0))
"""Decibels of a factor of e between densities."""

AVERAGED_S: Final = 0.5
"""Length of the parts that spectra are averaged over: 2 Hz wide bins [s]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Alternative:
    """A hypothesis that competes.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of its effects.
    model : Model
        With its fitted numbers.
    gain : (n_sensors,) array
        Of each sensor [-].
    """

    kinds: tuple[str, ...]
    model: Model
    gain: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Laboratory:
    """Limits that a proposed test has to keep.

    Attributes
    ----------
    tests : tuple of PreparedTest
        Those that were run.
    model : Model
        Says what is driven.
    shaker : Shaker
        Its limits.
    seed : int
        Of random waveforms.
    """

    tests: tuple[PreparedTest, ...]
    model: Model
    shaker: Shaker
    seed: int

    @property
    def loudest(self) -> PreparedTest:
        """The test with the largest input."""
        return loudest(self.tests)

    @property
    def unit(self) -> str:
        """Unit of the input."""
        return self.model.drive_unit

    def most(self, trial: Trial) -> float:
        """Return by how much an excitation may be louder, by the shaker [-]."""
        if not self.model.excitation.moves_base:
            return np.inf
        return most_of(self.shaker, trial.samples, self.loudest.sample_rate)

    def levels(self, trial: Trial, wanted: Sequence[float]) -> list[float]:
        """Return the multiples [-] of a level that the shaker can do, its limit among them."""
        most = self.most(trial)
        return [times for times in wanted if times <= most] + (
            [most] if min(wanted) < most < max(wanted) else []
        )


def alternative_of(score: Score) -> Alternative | None:
    """Return a scored hypothesis as an alternative; None if no model can have its numbers."""
    fit = score.fit
    try:
        model = fit.hypothesis.model_at(fit.x)
    except ModelError:
        return None
    return Alternative(fit.hypothesis.kinds, model, fit.gain)


def telling_apart(
    laboratory: Laboratory, first: Alternative, others: Sequence[Alternative]
) -> tuple[NextTest, ...]:
    """Return the test in which the responses of one hypothesis and all others differ most.

    Tried are the loudest test, a random drive and a sweep over its band and over a wider one,
    each at several levels within the limits of the shaker, as far as every hypothesis has a
    motion there.
    """
    best: tuple[float, Trial, float] | None = None
    for trial in trials_of(laboratory.loudest, laboratory.unit, laboratory.seed):
        for times in laboratory.levels(trial, LEVELS):
            apart = _least_apart(laboratory, first, others, trial, times)
            if apart is None:
                break
            if best is None or apart > BETTER * best[0]:
                best = apart, trial, times
    if best is None:
        return ()
    apart, trial, times = best
    reason = f"the spectra of the responses differ by {DECIBEL * apart:.2g} dB on average there"
    if apart < scatter(trial.samples.size / laboratory.loudest.sample_rate):
        reason += ", too little to tell them apart; no other test that was tried shows more"
    return (_proposed(trial, times, _separated([first, *others]), reason),)


def slipping(
    laboratory: Laboratory, locked: Sequence[Locked], kinds: Sequence[str]
) -> tuple[NextTest, ...]:
    """Return the test that loads joints which never slipped as far beyond as may be.

    A locked joint carries a force in proportion to the level: at any higher level it slips if
    it holds no more than it was seen to hold, and how much more it holds is not known.
    """
    trial = as_it_was(laboratory.loudest, laboratory.unit)
    levels = [times for times in laboratory.levels(trial, LEVELS) if times > 1.0]
    if not levels or not locked:
        return ()
    times, most = max(levels), max(joint.holds for joint in locked)
    unit = locked[0].unit
    reason = (
        f"the joint would have to hold {times * most:.3g} {unit} without slipping; it was "
        f"seen to hold {most:.3g} {unit}"
    )
    return (_proposed(trial, times, tuple(kinds), reason),)


def closing(
    laboratory: Laboratory,
    linear: Alternative,
    touching: Alternative,
    clearance: float,
    reach: float,
) -> tuple[NextTest, ...]:
    """Return the lowest level at which a clearance that never closed shows.

    Parameters
    ----------
    laboratory : Laboratory
        What the test has to keep to.
    linear, touching : Alternative
        The model without a contact and with it.
    clearance, reach : float
        Clearance, and the largest motion so far [m].
    """
    trial = as_it_was(laboratory.loudest, laboratory.unit)
    seen = scatter(trial.samples.size / laboratory.loudest.sample_rate)
    wanted = [share * clearance / reach for share in CLOSING]
    possible = [times for times in laboratory.levels(trial, wanted) if times >= wanted[0]]
    if not possible:
        return ()
    told = [
        times for times in possible
        if (_least_apart(laboratory, linear, [touching], trial, times) or 0.0) > seen
    ]  # fmt: skip
    times = min(told) if told else max(possible)
    reason = f"the joint would move {times * reach:.3g} m and close its clearance"
    return (_proposed(trial, times, (), reason),)


def scatter(seconds: float) -> float:
    """Return by how much logarithms of spectra of so many seconds scatter [-].

    Two runs of a motion that is not predictable differ by that.
    """
    return 1.0 / float(np.sqrt(max(1.0, seconds / AVERAGED_S)))


def _proposed(trial: Trial, times: float, kinds: tuple[str, ...], reason: str) -> NextTest:
    return NextTest(trial.excitation, trial.words(times), kinds, reason, trial.band, trial.like)


def _separated(alternatives: Sequence[Alternative]) -> tuple[str, ...]:
    """Return the kinds that some alternatives have and others have not."""
    kinds = dict.fromkeys(kind for alternative in alternatives for kind in alternative.kinds)
    shared = set(alternatives[0].kinds).intersection(
        *(alternative.kinds for alternative in alternatives)
    )
    return tuple(kind for kind in kinds if kind not in shared)


def _least_apart(
    laboratory: Laboratory,
    first: Alternative,
    others: Sequence[Alternative],
    trial: Trial,
    times: float,
) -> float | None:
    """Return how far the nearest alternative is from the first; None if one runs away.

    Mean magnitude of the logarithm of the ratio of their spectra [-].
    """
    samples = times * trial.samples
    spectra = [_spectrum(laboratory, alternative, samples) for alternative in (first, *others)]
    if any(found is None for found in spectra):
        return None
    one, *rest = (np.log(found) for found in spectra if found is not None)
    return min(float(np.mean(np.abs(one - other))) for other in rest)


def _spectrum(
    laboratory: Laboratory, alternative: Alternative, samples: FloatArray
) -> FloatArray | None:
    """Return densities of the responses and their noise, in the compared band [unit^2/Hz].

    None where the motion runs away.
    """
    test = laboratory.loudest
    rate = test.sample_rate
    given = prepare(samples, rate)
    found = free_runs(
        alternative.model.under(test.conditions),
        Runs((given,), np.array([(0, 0, given.n_samples)])),
        tolerance=TOLERANCE,
    )
    if found.failed[0]:
        return None
    rows = alternative.gain[:, np.newaxis] * found.outputs[0]
    size = min(round(AVERAGED_S * rate), rows.shape[1])
    frequency, density = scipy.signal.welch(rows, rate, nperseg=size)
    inside = (frequency >= test.band[0]) & (frequency <= test.band[1])
    noisy: FloatArray = density + test.noise_density.responses_at(frequency)
    return np.maximum(noisy[:, inside], 1e-300)
