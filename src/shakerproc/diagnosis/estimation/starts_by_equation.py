"""Starts of windows by the equation of motion, where a mean displacement was not measured.

An accelerometer tells a displacement but for what it was, and how fast it changed, where the
window began. The forces of the model tell both: along the window they have to balance the
inertia that was measured. Nothing is simulated, so that every place at which a window may begin
can be tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import members_of, models_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.resting_places import apart
from shakerproc.models import Model
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.laws import Law

PERIODS: Final = 2.0
"""Length from the beginning of a window that is looked at, in periods of the joint's motion: it
tells both numbers, and errors of what is integrated do not grow in it [-]."""

SAMPLES: Final = 200
"""Samples of that length at most, 100 of every period: slow motions take no memory [-]."""

PLACES: Final = np.linspace(-3.0, 3.0, 61)
"""Displacements that are tried, over the largest that was measured without its mean [-]."""

FASTER: Final = np.array([-0.3, 0.0, 0.3])
"""Velocities that are tried beside that measured, over the largest [-]."""

NEAREST: Final = 3
"""Places that are gone on from: those of the least misfit around them [-]."""

ROUNDS: Final = 6
"""Steps of Gauss and Newton from there [-]."""

STEP: Final = 1e-4
"""Change for their slopes, over the largest motion [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Laws:
    """The laws of a model, what springs and dampers do as matrices.

    Attributes
    ----------
    stiffness, damping : (n_masses, n_masses) array
        Of all linear laws [N/m], [N s/m].
    others : tuple of (array, AbstractMemorylessEffect)
        What a joint sees of the displacements of all masses, and a law in it.
    """

    stiffness: FloatArray
    damping: FloatArray
    others: tuple[tuple[FloatArray, AbstractMemorylessEffect], ...]


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Record:
    """The beginnings of windows, side by side.

    Attributes
    ----------
    inertia : (n_windows, n_masses, n) array
        Mass by measured acceleration, less the force that drives [N].
    moved, passed : (n_windows, n_masses, n) array
        Displacement [m] and velocity [m/s] since the window began, against the base.
    time : (n,) array
        Since then [s]; n is `SAMPLES` at most.
    """

    inertia: FloatArray
    moved: FloatArray
    passed: FloatArray
    time: FloatArray

    def misfit(self, laws: _Laws, at: FloatArray) -> FloatArray:
        """Return the inertia less all forces, (n_windows, k, n_masses * n) array [N].

        `at` (n_windows, k, 2 n_masses) holds displacements and velocities at the beginning.
        """
        z, v = np.split(at, 2, axis=2)
        since = self.inertia + laws.stiffness @ self.moved + laws.damping @ self.passed
        steady, rising = z @ laws.stiffness + v @ laws.damping, v @ laws.stiffness
        left = (steady[..., np.newaxis] + rising[..., np.newaxis] * self.time) + since[:, None]
        for across, effect in laws.others:
            place, speed = ((one @ across)[..., np.newaxis] for one in (z, v))
            moved, passed = ((across @ one)[:, None] for one in (self.moved, self.passed))
            force = effect.force_at(place + speed * self.time + moved, speed + passed)
            for i in np.flatnonzero(across):
                left[:, :, i] += across[i] * force
        return left.reshape(*left.shape[:2], -1)


def by_equation(
    data: DataSet, model: Model, table: NDArray[np.int64], starts: FloatArray
) -> FloatArray | None:
    """Return starts at which the forces of a model balance the inertia that was measured.

    None where some mass has no accelerometer, a law remembers, or a structure moves, whose
    inertia no sensor tells alone.

    Parameters
    ----------
    data, model, table
        As for `completed`.
    starts : (n_windows, n_motions) array
        What is known of them without the forces.
    """
    if model.structures:
        return None
    sensors, laws = _accelerometers(model), _laws(model)
    if sensors is None or laws is None:
        return None
    told = starts.copy()
    for own, members in members_of(models_of(model, data.tests), table):
        record = _record(data, own, table[members], sensors)
        told[members] = _balanced(data, own, record, starts[members])
    return told


def _balanced(data: DataSet, model: Model, record: _Record, starts: FloatArray) -> FloatArray:
    """Return the starts of windows of tests in which the model is the same."""
    laws = _laws(model)
    if laws is None:
        return starts
    n, half = len(model.masses), starts.shape[1] // 2
    columns = np.r_[:n, half : half + n]  # what else moves, further modes, stays as it is
    sizes = data.motion_sizes
    with np.errstate(all="ignore"):
        begun = _scanned(record, laws, starts[:, columns], sizes)
        found, left = _settled(record, laws, begun, sizes)
    best = np.argmin(left, axis=1)
    chosen: FloatArray = found[np.arange(len(found)), best]
    good = np.isfinite(chosen).all(axis=1, keepdims=True)
    told = starts.copy()
    told[:, columns] = np.where(good, chosen, starts[:, columns])
    return told


def _accelerometers(model: Model) -> list[int] | None:
    """Return the sensor of each mass that measures its acceleration; None if one lacks it."""
    found = {
        sensor.at: i
        for i, sensor in enumerate(model.sensors.values())
        if sensor.measures == "acceleration"
    }
    named = [found.get(name) for name in model.masses]
    return [i for i in named if i is not None] if None not in named else None


def _laws(model: Model) -> _Laws | None:
    """Return the laws of a model, each in its joint; None if one remembers."""
    n, others = len(model.masses), []
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    for one in model.elements:
        across = apart(model, one.between)
        if not isinstance(one.effect, AbstractMemorylessEffect):
            return None
        rows = one.effect.rows()
        if any(row.law is not Law.LINEAR for row in rows):
            others.append((across, one.effect))
            continue
        for row in rows:
            stiffness += row.values[0] * np.outer(across, across)
            damping += row.values[1] * np.outer(across, across)
    return _Laws(stiffness, damping, tuple(others))


def _record(
    data: DataSet, model: Model, table: NDArray[np.int64], sensors: Sequence[int]
) -> _Record:
    """Return the beginnings of windows."""
    rate = data.tests[0].sample_rate
    size = int(min(table[:, 2].min(), PERIODS / data.frequency * rate + 2))
    measured, drives = [], []
    for test, begin, _ in table:
        part = slice(int(begin), int(begin) + size)
        measured.append(data.tests[test].responses[sensors, part])
        drives.append(data.tests[test].input[part])
    acceleration, drive = np.array(measured), np.array(drives)[:, np.newaxis]
    moves = model.excitation.moves_base
    relative = acceleration - drive if moves else acceleration
    inertia = np.array(list(model.masses.values()))[:, np.newaxis] * acceleration
    if model.excitation.on is not None and not moves:
        inertia[:, list(model.masses).index(str(model.excitation.on))] -= drive[:, 0]
    passed = scipy.integrate.cumulative_simpson(relative, dx=1.0 / rate, initial=0.0)
    moved = scipy.integrate.cumulative_simpson(passed, dx=1.0 / rate, initial=0.0)
    some = np.linspace(0, size - 1, min(size, SAMPLES)).astype(int)
    return _Record(inertia[..., some], moved[..., some], passed[..., some], some / rate)


def _scanned(record: _Record, laws: _Laws, starts: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return the starts of least misfit around them, (n_windows, k, 2 n_masses) array.

    One mass after the other is tried everywhere while the others stay.
    """
    n, out = starts.shape[1] // 2, [starts[:, np.newaxis]]
    for i in range(n):
        at = np.repeat(starts[:, np.newaxis], PLACES.size * FASTER.size, axis=1)
        at[:, :, i] = np.repeat(PLACES, FASTER.size) * sizes[i]
        at[:, :, n + i] += np.tile(FASTER, PLACES.size) * sizes[n + i]
        misfit = np.sum(record.misfit(laws, at) ** 2, axis=2)
        misfit = np.where(np.isfinite(misfit), misfit, np.inf).reshape(
            -1, PLACES.size, FASTER.size
        )
        speed, least = np.argmin(misfit, axis=2), np.min(misfit, axis=2)
        beside = np.pad(least, ((0, 0), (1, 1)), constant_values=np.inf)
        lowest = np.logical_and(least <= beside[:, :-2], least <= beside[:, 2:])
        order = np.argsort(np.where(lowest, least, np.inf), axis=1)[:, :NEAREST]
        rows = np.arange(len(at))[:, np.newaxis]
        out.append(at[rows, order * FASTER.size + speed[rows, order]])
    return np.concatenate(out, axis=1)


def _settled(
    record: _Record, laws: _Laws, at: FloatArray, sizes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return starts moved to where the misfit is least, and the sum of its squares there."""
    left = record.misfit(laws, at)
    cost = np.sum(left**2, axis=2)
    steps = STEP * np.diag(sizes)
    for _ in range(ROUNDS):
        moved = [(record.misfit(laws, at + step) - left) / STEP for step in steps]
        slopes = _finite(np.stack(moved, axis=-1))
        turned = slopes.swapaxes(-1, -2)
        fall = turned @ _finite(left)[..., np.newaxis]
        change = np.linalg.pinv(turned @ slopes, hermitian=True) @ fall
        there = at - sizes * change[..., 0]
        tried = record.misfit(laws, there)
        lower = (np.sum(tried**2, axis=2) < cost)[..., np.newaxis]
        at, left = np.where(lower, there, at), np.where(lower, tried, left)
        cost = np.sum(left**2, axis=2)
    return at, np.where(np.isfinite(cost), cost, np.inf)


def _finite(rows: FloatArray) -> FloatArray:
    """Return rows, 0 where a force is beyond all numbers: nothing is told there."""
    if np.isfinite(np.sum(rows)):
        return rows
    return np.nan_to_num(rows, nan=0.0, posinf=0.0, neginf=0.0)
