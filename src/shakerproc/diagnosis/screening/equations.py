"""Forces as whitened columns: what each would show at the sensors, in units of their noise.

In every block of samples the sensors' spectra R, less what the linear model H makes of the
input U, are what forces F that the model lacks show through it:

    R - H U = -G F + what is left over from before the block + noise

Nothing is linearised where every mass carries a sensor: F is taken along the measured motion.
Divided by the standard deviation of the noise, all rows count alike.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.data.tests import FLOOR_SHARE
from shakerproc.diagnosis.screening.laws import force_along
from shakerproc.diagnosis.screening.motion import Motions
from shakerproc.diagnosis.screening.stretches import Stretch
from shakerproc.diagnosis.screening.transfer import Joint, LinearPart
from shakerproc.errors import ModelError
from shakerproc.models import Model
from shakerproc.models.conditions import Scale, share_of
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects import AbstractEffect
from shakerproc.models.laws import Law

GAIN: Final = 0.01
"""Usual error of a sensor's gain: what calibration sheets promise [-]."""

DELAY: Final = 2e-5
"""Usual delay between channels: a fifth of a sample at 10 kHz [s]."""

_TOLD_APART: Final = 1e-9
"""Share of a unit column that must be its own to count as a column [-]."""

_SMOOTHED: Final = 5
"""Bins over which the power of a block is averaged for its relative floor [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """Blocks of tests, and what turns forces into whitened columns.

    Attributes
    ----------
    linear : LinearPart
        The linear part of the model.
    tests : tuple of PreparedTest
        The tests.
    stretches : tuple of Stretch
        Which of their samples are looked at.
    frequency : (n_frequencies,) array
        Those of the bins that are used [Hz].
    bins : slice
        The same among all of a block.
    weights : (n_blocks, n_sensors, n_frequencies) array
        One over the standard deviation of the noise of a bin; 0 outside the band of a test.
    leftovers : (n_blocks, n_rows, n_leftovers) array
        Orthonormal columns that span what is left over from before each block.
    residual : (n_blocks, n_rows) array
        What the linear model does not explain, whitened.
    nuisances : (n_nuisances, n_blocks, n_rows) array
        What 1 % of gain and 20 us of delay of each sensor would show, whitened.
    n_numbers : int
        How many independent numbers the residual holds; 1 where it holds none.
    """

    linear: LinearPart
    tests: tuple[PreparedTest, ...]
    stretches: tuple[Stretch, ...]
    frequency: FloatArray
    bins: slice
    weights: FloatArray
    leftovers: FloatArray
    residual: FloatArray
    nuisances: FloatArray
    n_numbers: int

    def columns(self, forces: Sequence[FloatArray], direction: FloatArray) -> FloatArray:
        """Return whitened columns of forces, (n_forces, n_blocks, n_rows) array.

        Parameters
        ----------
        forces : sequence of (n_forces, n) array
            Along the samples of every stretch [N].
        direction : (n_masses,) array
            How unit displacements of the masses stretch what carries them [-].
        """
        shown = -self.linear.by_forces(self.frequency, direction[:, None])[:, 0]
        blocks = np.concatenate(
            [s.folded(own) for s, own in zip(self.stretches, forces, strict=True)], axis=-2
        )
        spectra = scipy.fft.rfft(blocks, axis=-1)[..., self.bins]
        return self._whitened(spectra[..., None, :] * shown)

    def shares(self, scale: Scale | None) -> FloatArray:
        """Return the force of what is scaled in each test over that of its law, (n_tests,)."""
        return np.array([share_of(scale, test.conditions) for test in self.tests])

    def _whitened(self, spectra: ComplexArray) -> FloatArray:
        """Return rows of spectra (..., n_blocks, n_sensors, n_frequencies)."""
        return without(self.leftovers, _rows(spectra * self.weights))


def without(basis: FloatArray, rows: FloatArray) -> FloatArray:
    """Return rows [any unit] less what a basis of each block spans of them."""
    share = np.einsum("brl,...br->...bl", basis, rows, optimize=True)
    return np.asarray(rows - np.einsum("brl,...bl->...br", basis, share, optimize=True))


def _rows(spectra: ComplexArray | FloatArray) -> FloatArray:
    """Return the real and imaginary parts over sensors and frequencies as one axis."""
    flat = spectra.reshape(*spectra.shape[:-2], -1)
    return np.concatenate([flat.real, flat.imag], axis=-1)


def equations_of(
    linear: LinearPart, tests: Sequence[PreparedTest], stretches: Sequence[Stretch]
) -> Equations:
    """Return the equations of some stretches of tests."""
    block, rate = stretches[0].block, tests[0].sample_rate
    every = scipy.fft.rfftfreq(block, 1.0 / rate)
    low = min(tests[s.test].band[0] for s in stretches)
    high = max(tests[s.test].band[1] for s in stretches)
    first = max(1, int(np.searchsorted(every, low)))
    bins = slice(first, int(np.searchsorted(every, high, side="right")))
    frequency = every[bins]
    linear_part = _responses(linear, tests, stretches)
    measured, unexplained = (
        np.concatenate([
            scipy.fft.rfft(s.cut(part[i]), axis=-1).transpose(1, 0, 2)[..., bins]
            for s, part in zip(stretches, linear_part, strict=True)
        ])
        for i in range(2)
    )
    owners = np.repeat([s.test for s in stretches], [s.n_blocks for s in stretches])
    weights = _weights(linear, [tests[i] for i in owners], measured, frequency, block)
    basis = _orthonormal(linear.leftovers(frequency, block, rate), weights)
    taken = int(np.count_nonzero(np.any(basis != 0.0, axis=1)))
    return Equations(
        linear=linear,
        tests=tuple(tests),
        stretches=tuple(stretches),
        frequency=frequency,
        bins=bins,
        weights=weights,
        leftovers=basis,
        residual=without(basis, _rows(unexplained * weights)),
        nuisances=without(basis, _rows(_sensor_errors(measured, frequency) * weights)),
        n_numbers=max(1, 2 * int(np.count_nonzero(weights)) - taken),
    )


def _responses(
    linear: LinearPart, tests: Sequence[PreparedTest], stretches: Sequence[Stretch]
) -> list[tuple[FloatArray, FloatArray]]:
    """Return the responses of the test of every stretch, and the same less the linear model."""
    found: dict[int, tuple[FloatArray, FloatArray]] = {}
    for index in {s.test for s in stretches}:
        test = tests[index]
        length = scipy.fft.next_fast_len(test.n_samples + round(test.sample_rate), real=True)
        frequency = scipy.fft.rfftfreq(length, 1.0 / test.sample_rate)
        frequency[0] = frequency[1]
        spectrum = linear.by_input(frequency) * scipy.fft.rfft(test.input, length)
        spectrum[:, 0] = 0.0
        explained = scipy.fft.irfft(spectrum, length)[:, : test.n_samples]
        measured = test.responses[list(linear.sensors)]
        found[index] = measured, measured - explained
    return [found[s.test] for s in stretches]


def _weights(
    linear: LinearPart,
    tests: Sequence[PreparedTest],
    measured: ComplexArray,
    frequency: FloatArray,
    block: int,
) -> FloatArray:
    """Return one over the noise of every bin; `tests` are those that the blocks belong to."""
    passed = np.abs(linear.by_input(frequency)) ** 2
    power = np.abs(measured) ** 2
    kernel = np.ones(_SMOOTHED) / _SMOOTHED
    power = scipy.ndimage.convolve1d(power, kernel, axis=-1, mode="nearest")
    noise = np.array([_noise(test)[list(linear.sensors)] for test in tests])[..., None]
    driven = np.array([_control_noise(test) for test in tests])[:, None, None]
    whole = block * (noise**2 + driven**2 * passed) + FLOOR_SHARE**2 * power
    variance = 0.5 * whole  # of the real part, and of the imaginary
    low, high = (np.array([test.band[i] for test in tests])[:, None, None] for i in range(2))
    inside = (frequency >= low) & (frequency <= high)
    return np.asarray(np.where(inside, 1.0 / np.sqrt(variance), 0.0))


def _noise(test: PreparedTest) -> FloatArray:
    """Return the noise of a sample of each sensor, were it the same up to half the rate."""
    return np.asarray(test.noise * np.sqrt(0.5 * test.sample_rate / test.band[1]))


def _control_noise(test: PreparedTest) -> float:
    """Return the standard deviation of a sample of the input; 0 where nothing tells it."""
    noise = test.noise_density
    return float(np.sqrt(np.sum(noise.input) * noise.frequency[0]))


def _orthonormal(left: ComplexArray, weights: FloatArray) -> FloatArray:
    """Return orthonormal rows of what is left over, whitened, for every block."""
    rows = _rows(left[:, None] * weights)
    size = np.linalg.norm(rows, axis=-1, keepdims=True)
    rows = rows / np.where(size > 0.0, size, 1.0)
    basis, triangle = np.linalg.qr(rows.transpose(1, 2, 0))
    shown = np.abs(np.diagonal(triangle, axis1=-2, axis2=-1)) > _TOLD_APART
    return np.asarray(basis * shown[:, None, :])


def _sensor_errors(measured: ComplexArray, frequency: FloatArray) -> ComplexArray:
    """Return columns of errors of gain and delay of each sensor, of their usual size."""
    n_sensors = measured.shape[1]
    own = np.eye(n_sensors)[:, None, :, None] * measured
    return np.concatenate([GAIN * own, -DELAY * 2j * np.pi * frequency * own])


_STEP: Final = 1e-3
"""Share by which each number is changed for its slope: the screening is linear in it [-]."""


def columns_of(
    equations: Equations,
    motions: Motions,
    between: Joint,
    effects: Sequence[AbstractEffect],
    shares: FloatArray,
) -> FloatArray:
    """Return the whitened columns of effects in one joint; zeros where a force fails.

    `shares`, (n_tests,), multiply the forces in each test [-].
    """
    absolute = effects[0].absolute
    motion = motions.across(between, absolute=absolute)
    rates = [test.sample_rate for test in equations.tests]
    forces = [
        shares[s.test]
        * np.array([force_along(e, motion[s.test], s, rates[s.test]) for e in effects])
        for s in equations.stretches
    ]
    for force in forces:
        force[~np.all(np.isfinite(force), axis=1)] = 0.0
    direction = equations.linear.direction(between, second_only=absolute)
    return equations.columns(forces, direction)


def own_columns(model: Model, equations: Equations, motions: Motions) -> FloatArray:
    """Return columns of the model's own nonlinear elements, and of each of their numbers.

    What the linear model leaves holds their forces; what is to be added explains the rest.
    Their sizes and numbers remain free, to first order. So it does that of a linear element
    that a condition scales, as far as it is another one in a test than in the linear model.

    Returns
    -------
    (n_columns, n_blocks, n_rows) array
        Whitened; zeros where a force fails.
    """
    found = [equations.nuisances[:0]]
    for element in resolved(model):
        shares = equations.shares(element.scaled_by)
        effects = [element.effect]
        if all(row.law is Law.LINEAR for row in element.effect.rows()):
            shares -= 1.0
            if not np.ptp(shares):  # as a spring and a damper of the joint are free, too
                continue
        else:
            effects += _nearby(element.effect)
        columns = columns_of(equations, motions, element.between, effects, shares)
        found += [columns[:1], (columns[1:] - columns[0]) / _STEP]
    return np.concatenate(found)


def _nearby(effect: AbstractEffect) -> Iterator[AbstractEffect]:
    """Yield the effect with one number after the other changed, where it can be."""
    for name, parameter in effect.parameters.items():
        value = getattr(effect, name)
        if parameter.choices or not isinstance(value, (int, float)) or not value:
            continue
        try:
            yield replace(effect, **{name: (1.0 + _STEP) * value})  # type: ignore[type-var]
        except (ValueError, ModelError):
            continue
