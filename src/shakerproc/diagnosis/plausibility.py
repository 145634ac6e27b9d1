"""Mistakes in a model or a log that no effect explains, seen before a long search."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.measured import Measured
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.screening.transfer import LinearPart, linear_model
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model
from shakerproc.spectra import coherence, cross_spectra, h1

MOST_TESTS: Final = 4
"""Tests that are looked at: a mistake in model or roles is in each, and seen in half [-]."""

NEAR: Final = 2.0
"""Factor to which a model explains gains so well that no mistake is looked for: 6 dB [-]."""

HALF: Final = 0.5
"""Share that a correction leaves at most of what the model leaves, and of what a single gain
leaves: it explains more than half of either [-]."""

DECADES: Final = 6
"""Powers of ten that stiffness over mass is tried with, either way: mg for kg [-]."""

SLIP: Final = 100.0
"""Factor from which a unit is wrong: above the ten of a missing contact, below the thousand
between units and their multiples [-]."""

TWIN: Final = 0.01
"""Rms of response plus control over the response below which one is the other turned round:
the uncertainty of two calibrations (ISO 16063-21) [-]."""

FLAT: Final = 0.25
"""Spread of the logarithms of gains below which joints hold, by friction or else: 2 dB [-]."""

_MOST_BINS: Final = 128
_MOST_WORK: Final = 2**21  # bins times the square of the number of motions
_FEWEST: Final = 12  # bins
_SHORTEST: Final = 64  # samples of a segment
_TOLD: Final = 0.5  # coherence above which a gain is no noise


def check_plausible(model: Model, tests: Sequence[Measured]) -> None:
    r"""Pass a model and tests that a search for an effect can be begun with.

    .. math:: d^2 = \overline{\left(\ln |H| - \ln |\hat H|\right)^2}

    over sensors and frequencies tells how well the linear part of the model explains the
    measured response functions. A mistake is told where the model as it is does not explain
    them to a factor of two, and its correction explains more than half of :math:`d^2` and of
    the variance of :math:`\ln |H|`. Joints that hold in a test are no mistake but a verdict.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of Measured
        What is to be explained; a few of them are looked at.

    Raises
    ------
    DiagnosisError
        If controls and responses are exchanged, every response is the control turned round, or
        mass, stiffness or sensitivities are wrong by more than a missing effect makes it.
    """
    if model.excitation.role is None or model.excitation.imposed:
        return
    count = min(len(tests), MOST_TESTS)
    chosen = [tests[i * len(tests) // count] for i in range(count)]
    looked = [_looked(linear_model(model.under(test.conditions)), test) for test in chosen]
    doubted = [one for one in looked if one.doubted]
    turned = [_turned(model, test) for test in tests]
    if len(doubted) == count and all(turned):
        raise DiagnosisError(turned[0])
    if 2 * len(doubted) < count or any(one.spread < FLAT for one in doubted):
        return
    told = [text for one in doubted if (text := _mistake(one))]
    if 2 * len(told) >= count:
        raise DiagnosisError(told[0])


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Looked:
    """Gains of a test, (n_sensors, n_frequencies), and the model's; no frequencies for none."""

    linear: LinearPart
    test: Measured
    frequency: FloatArray
    measured: ComplexArray
    modelled: ComplexArray
    known: FloatArray

    def distance(self, modelled: ComplexArray, measured: ComplexArray | None = None) -> float:
        """Return the rms difference of logarithms of gains where they are no noise [-]."""
        if not self.known.any():
            return 0.0
        mine = _logarithms(self.measured if measured is None else measured)
        square = (mine - _logarithms(modelled)) ** 2
        return float(np.sqrt(np.average(square, weights=self.known)))

    @property
    def doubted(self) -> bool:
        """Whether the model explains the gains to no factor of two."""
        return self.distance(self.modelled) >= float(np.log(NEAR))

    @property
    def spread(self) -> float:
        """Rms of the logarithms of gains about their mean: what a single gain leaves [-]."""
        if not self.known.any():
            return 0.0
        logarithms = _logarithms(self.measured)
        mean = np.average(logarithms, weights=self.known)
        return float(np.sqrt(np.average((logarithms - mean) ** 2, weights=self.known)))


def _logarithms(gains: ComplexArray) -> FloatArray:
    """Return the logarithms of the magnitudes of gains [-]."""
    return np.asarray(np.log(np.maximum(np.abs(gains), np.finfo(float).tiny)))


def _looked(linear: LinearPart, test: Measured) -> _Looked:
    """Return the gains of a test at no more frequencies than it takes."""
    part = slice(test.start, test.stop)
    rows = np.vstack([test.input[part], test.responses[:, part]])
    sensors = list(range(1, rows.shape[0]))
    segment = max(_SHORTEST, min(test.test.processing.welch.segment, rows.shape[1] // 4))
    none = np.empty((len(sensors), 0))
    nothing = _Looked(
        linear, test, np.empty(0), none.astype(np.complex128), none.astype(np.complex128), none
    )
    if segment > rows.shape[1]:
        return nothing
    cross = cross_spectra(rows, test.sample_rate, segment=segment)
    low, high = test.excited
    known = coherence(cross, [0], sensors) > _TOLD
    inside = (cross.frequency >= low) & (cross.frequency <= high) & np.any(known, axis=0)
    bins = np.flatnonzero(inside & (cross.frequency > 0.0))
    if bins.size < _FEWEST:
        return nothing
    most = _MOST_WORK // linear.system.machine.mass.size**2
    wanted = np.geomspace(bins[0], bins[-1], int(np.clip(most, _FEWEST, _MOST_BINS)))
    bins = np.unique(bins[np.searchsorted(bins, wanted).clip(0, bins.size - 1)])
    frequency = cross.frequency[bins]
    measured = h1(cross, [0], sensors)[:, bins]
    known_there = known[:, bins].astype(float)
    return _Looked(linear, test, frequency, measured, linear.by_input(frequency), known_there)


def _mistake(looked: _Looked) -> str:
    """Return the mistake that explains a test far better than the model does, or nothing."""
    linear = looked.linear
    left, text = min([
        *_exchanged(linear.model, looked),
        *_units(linear, looked),
        _sensitivities(looked),
    ])
    as_it_is = looked.distance(looked.modelled)
    if not text or left**2 > HALF * min(as_it_is, looked.spread) ** 2:
        return ""
    return (
        f"{looked.test.run}: {linear.model.title} explains the measured gains to a factor of "
        f"{np.exp(as_it_is):.2g}, and to {np.exp(left):.2g} {text}"
    )


def _exchanged(model: Model, looked: _Looked) -> Iterator[tuple[float, str]]:
    """Return how well the test is explained with control and a response exchanged."""
    if not model.excitation.moves_base:
        return
    for i, name in enumerate(looked.test.sensors):
        if model.sensors[name].measures == "acceleration":
            swapped = looked.measured / looked.measured[i]
            swapped[i] = 1.0 / looked.measured[i]
            text = f"with control and {name} exchanged. Correct the roles in the log."
            yield looked.distance(looked.modelled, swapped), text


def _units(linear: LinearPart, looked: _Looked) -> Iterator[tuple[float, str]]:
    """Return how well the test is explained by stiffness over mass in other units.

    Damping over mass goes with it where the mass is wrong, and stays where the stiffness is.
    Factors below `SLIP` are no mistake: they have no text, and only compete.
    """
    machine = linear.system.machine
    n = machine.mass.size
    for power in range(-DECADES, DECADES + 1):
        factor = 10.0**power
        for columns in (n, 2 * n) if power else ():
            matrix = machine.matrix.copy()
            matrix[:, :columns] *= factor
            system = replace(linear.system, machine=machine._replace(matrix=matrix))
            other = replace(linear, system=system).by_input(looked.frequency)
            text = (
                f"with stiffness over mass {factor:.0e} times as large. Correct their units in "
                "the model."
            )
            wrong = max(factor, 1.0 / factor) >= SLIP
            yield looked.distance(other), text if wrong else ""


def _sensitivities(looked: _Looked) -> tuple[float, str]:
    """Return how well the test is explained by another sensitivity of every sensor."""
    apart = _logarithms(looked.measured) - _logarithms(looked.modelled)
    factor = float(np.exp(np.average(apart, weights=looked.known)))
    text = (
        f"with gains {factor:.0e} times as large. Correct sensitivities in the log, or masses "
        "in the model."
    )
    wrong = max(factor, 1.0 / factor) >= SLIP
    return looked.distance(factor * looked.modelled), text if wrong else ""


def _turned(model: Model, test: Measured) -> str:
    """Return that every response is the control with the other sign, if they are."""
    kinds = {model.sensors[name].measures for name in test.sensors}
    if not model.excitation.moves_base or kinds != {"acceleration"}:
        return ""
    part = slice(test.start, test.stop)
    responses = test.responses[:, part]
    sizes = np.sqrt(np.mean(responses**2, axis=1))
    inputs = [test.input[part], *test.controls[:, part]]
    left = np.min([np.sqrt(np.mean((responses + x) ** 2, axis=1)) for x in inputs], axis=0)
    if np.any(left > TWIN * sizes):
        return ""
    return (
        f"{test.run}: {' and '.join(test.sensors)} is the control turned round, to "
        f"{float(np.max(left / sizes)):.1%} of its rms: no structure is between them. Check "
        "cables, polarity and roles."
    )
