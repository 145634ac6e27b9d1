"""Relative motion of the two sides of a joint: measured where it can be, else the model's."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data.tests import PreparedTest
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.simulation import TOLD_APART
from shakerproc.simulation.assembly import System, assemble

TRUSTED_FROM: Final = 0.35
"""Accelerations integrated twice are trusted above this share of the lowest natural frequency;
below it the linear model's own motion is (prototype of DIAGNOSIS.md: 0.35) [-]."""

ANTI_ALIAS: Final = 0.3
"""Motion is kept up to this share of the sample rate [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class RelativeMotion:
    """Motion of one place against another, or of the base, in one test.

    Attributes
    ----------
    displacement, velocity : (n,) array
        Of the second place less those of the first [m], [m/s].
    """

    displacement: FloatArray
    velocity: FloatArray


def compliance(system: System, frequency: FloatArray, forces: FloatArray) -> ComplexArray:
    """Return displacements by forces, (n_frequencies, n, n_forces) array [m/N].

    Laws that are not linear are left out.

    Parameters
    ----------
    system : System
        The model, assembled.
    frequency : (n_frequencies,) array
        Above 0 [Hz].
    forces : (n, n_forces) array
        Each column a set of forces on what moves [N].
    """
    matrix, mass = system.machine.matrix, system.machine.mass
    n = mass.size
    omega = 2.0 * np.pi * frequency[:, None, None]
    dynamic = -(omega**2) * np.eye(n) - matrix[:, :n] - 1j * omega * matrix[:, n : 2 * n]
    load = np.broadcast_to(forces / mass[:, None], (frequency.size, *forces.shape))
    return np.asarray(np.linalg.solve(dynamic, load.astype(complex)))


def input_load(system: System) -> FloatArray:
    """Return the forces of a unit input, (n, 1) array [N]."""
    load: FloatArray = system.machine.matrix[:, -1:] * system.machine.mass[:, None]
    return load


def coordinate_displacements(model: Model, test: PreparedTest) -> FloatArray:
    """Return displacements of masses and modes of structures, (n_coordinates, n) array [m].

    A place with a sensor moves as measured; below `TRUSTED_FROM` of the lowest natural
    frequency, and as far as no sensor tells, all moves as the linear part of the model does.
    The mean is that of a measured displacement, else 0. Where a displacement is imposed, only
    its mass is taken to move.
    """
    if model.excitation.imposed:
        moved = np.zeros((model.n_coordinates, test.n_samples))
        moved[list(model.masses).index(str(model.excitation.on))] = test.input
        return moved
    system = assemble(model.under(test.conditions))
    size = test.n_samples
    length = scipy.fft.next_fast_len(size + round(test.sample_rate), real=True)
    frequency = scipy.fft.rfftfreq(length, 1.0 / test.sample_rate)
    frequency[0] = frequency[1]
    drive = scipy.fft.rfft(test.input, length)
    motion = compliance(system, frequency, input_load(system))[..., 0].T * drive
    motion[:, 0] = 0.0
    measured = _measured_spectra(model, test, drive, frequency, length)
    trust = 1.0 / (1.0 + (TRUSTED_FROM * lowest_frequency(system) / frequency) ** 8)
    sees = np.reshape([system.places[at] for at in measured], (-1, len(system.names)))
    shares = [
        trust * (np.arange(trust.size) > 0) if integrated else 1.0
        for _, integrated in measured.values()
    ]
    lacking = [
        share * (spectrum - seen)
        for share, (spectrum, _), seen in zip(
            shares, measured.values(), sees @ motion, strict=True
        )
    ]
    motion += np.linalg.pinv(sees, rcond=TOLD_APART) @ np.reshape(lacking, (-1, trust.size))
    motion *= 1.0 / (1.0 + (frequency / (ANTI_ALIAS * test.sample_rate)) ** 16)
    found: FloatArray = scipy.fft.irfft(motion, length)[:, :size]
    return found[: model.n_coordinates]


def lowest_frequency(system: System) -> float:
    """Return the lowest natural frequency of the linear part above 0, or 0 if none [Hz]."""
    n = system.machine.mass.size
    omega = np.sqrt(np.abs(np.linalg.eigvals(-system.machine.matrix[:, :n])))
    held = omega[omega > 1e-9 * max(float(omega.max()), 1e-300)]
    return float(held.min()) / (2.0 * np.pi) if held.size else 0.0


def _measured_spectra(
    model: Model, test: PreparedTest, drive: ComplexArray, frequency: FloatArray, length: int
) -> dict[str, tuple[ComplexArray, bool]]:
    """Return relative displacement of each place with a sensor, and if it was integrated."""
    omega = 2.0 * np.pi * frequency
    base = drive if model.excitation.moves_base else 0.0 * drive
    found: dict[str, tuple[ComplexArray, bool]] = {}
    for sensor, row in zip(model.sensors.values(), test.responses, strict=True):
        if sensor.at == BASE:
            continue
        spectrum = scipy.fft.rfft(closed(row, length))
        relative = sensor.measures.startswith("relative")
        if sensor.measures.endswith("acceleration"):
            found[sensor.at] = -(spectrum - base) / omega**2, True
        elif sensor.measures.endswith("velocity"):
            moved = 0.0 if relative else base / (1j * omega)
            found[sensor.at] = (spectrum - moved) / (1j * omega), True
        elif sensor.measures.endswith("displacement"):
            moved = 0.0 if relative else -base / omega**2
            found[sensor.at] = spectrum - moved, False
    return found


def coordinate_motions(model: Model, test: PreparedTest) -> FloatArray:
    """Return displacements [m], then velocities [m/s], (2 n_coordinates, n) array.

    Of masses and modes of structures; see `coordinate_displacements`.
    """
    moved = coordinate_displacements(model, test)
    return np.concatenate([moved, [slope(row, test.sample_rate) for row in moved]])


def joint_motion(model: Model, motion: FloatArray, joint: tuple[str, str]) -> RelativeMotion:
    """Return the motion across a joint [m], [m/s]; see `coordinate_motions`."""
    n = model.n_coordinates
    across = coordinates_of(model, ()).across(joint)[:n]
    return RelativeMotion(across @ motion[:n], across @ motion[n:])


def slope(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Return the derivative [unit/s] of band-limited samples [unit] at a rate [Hz]."""
    length = scipy.fft.next_fast_len(2 * samples.size, real=True)
    omega = 2.0 * np.pi * scipy.fft.rfftfreq(length, 1.0 / sample_rate)
    spectrum = 1j * omega * scipy.fft.rfft(closed(samples, length))
    found: FloatArray = scipy.fft.irfft(spectrum, length)[: samples.size]
    return found


def closed(samples: FloatArray, length: int) -> FloatArray:
    """Return samples [any unit] and a straight line back to the first, `length` in all.

    A spectrum takes what it is given as one period: a motion that does not end where it began
    would jump there.
    """
    bridge = np.linspace(samples[-1], samples[0], length - samples.size + 2)[1:-1]
    return np.concatenate([samples, bridge])


def frequency_of(motions: Sequence[RelativeMotion]) -> float:
    """Return the frequency of a harmonic motion of this velocity and displacement [Hz]."""
    velocity = sum(float(np.sum(motion.velocity**2)) for motion in motions)
    displacement = sum(float(np.sum(motion.displacement**2)) for motion in motions)
    return float(np.sqrt(velocity / max(displacement, 1e-300)) / (2.0 * np.pi))


def models_of(model: Model, tests: Sequence[PreparedTest]) -> tuple[Model, ...]:
    """Return the model of each test: that under its conditions, one where these are alike."""
    made: dict[tuple[float, ...], Model] = {}
    found = []
    for test in tests:
        shares = tuple(scale.share(test.conditions) for scale in model.scales)
        if shares not in made:
            made[shares] = model.under(test.conditions)
        found.append(made[shares])
    return tuple(found)


def members_of(
    models: Sequence[Model], table: NDArray[np.int64]
) -> Iterator[tuple[Model, NDArray[np.int64]]]:
    """Yield each model once, and which windows are of a test that has it.

    Parameters
    ----------
    models : sequence of Model
        Of each test.
    table : (n_windows, 3) array of int
        Test, first sample, and number of samples.
    """
    owner = np.array([next(i for i, one in enumerate(models) if one is own) for own in models])
    for i in np.unique(owner[table[:, 0]]):
        yield models[i], np.flatnonzero(owner[table[:, 0]] == i)
