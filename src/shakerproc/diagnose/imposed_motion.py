"""Component tests: a rig imposes the motion of a joint, and its force is to be explained.

Where the inertia of the moved part is a small share of the measured force, the motion that the
force would cause is ill-posed (dry friction on nearly no mass), but the force that the motion
causes is plain: it is read along the measured motion, sample by sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnose.prepare import signal_slope, white_level
from shakerproc.diagnose.structure import Sensing, Structure
from shakerproc.diagnosis.data import TestArrays

INERTIA = 0.1
"""Share of the force that inertia may have for the motion to count as imposed [-]: with a mass
known to 10 %, what it leaves is 1 % of the force, as much as sensors are calibrated to."""
AT_REST = 0.02
"""Share of the rms velocity below which a joint rests: friction is then undetermined [-]."""
TURN = 0.02
"""Share of the range of motion that a return must exceed to be a turn [-]."""
SAME = 0.03
"""Share of the range of motion by which the turns of repeated swings may differ [-]."""
MOST_SAMPLES = 40_000
"""Samples that all tests together are thinned to."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """One test as a hysteresis loop.

    Attributes
    ----------
    name : str
        Name of the test.
    sample_rate : float
        Samples per second, after thinning [Hz].
    displacement, velocity, force : (n,) array
        Of the joint [m], [m/s]; the measured force less inertia [N].
    swing : (n,) array
        Number of the swing (from turn to turn); -1 where nothing is judged: before the second
        turn, because what happened before the recording is unknown, and at rest.
    turns : (n_turns,) array
        Displacement of every turn [m]; swing i goes from turn i to turn i + 1.
    inertia : float
        Rms of the inertia force over rms of the measured force [-].
    noise : float
        Standard deviation of a sample of the measured force [N].
    hold_out : bool
        Whether the log keeps the test out of every fit.
    """

    name: str
    sample_rate: float
    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    swing: NDArray[np.int64]
    turns: FloatArray
    inertia: float
    noise: float
    hold_out: bool


def loops(structure: Structure, tests: Sequence[TestArrays]) -> tuple[Loop, ...] | None:
    """Return the tests as loops, or None where the motion is not imposed."""
    if structure.masses.size != 1 or structure.forced != 0 or len(structure.joints) != 1:
        return None
    sensing = structure.sensing
    if len(sensing) != 1 or sensing[0].order == 2:
        return None
    total = sum(test.responses.shape[1] for test in tests)
    thin = max(1, total // MOST_SAMPLES)
    found = tuple(_loop(float(structure.masses[0]), sensing[0], t, thin) for t in tests)
    if any(loop.inertia > INERTIA or loop.turns.size < 4 for loop in found):
        return None
    return found


def _loop(mass: float, sensing: Sensing, test: TestArrays, thin: int) -> Loop:
    rate = test.sample_rate
    measured, force = test.responses[0], test.controls.mean(axis=0)
    if sensing.order == 1:
        moved = scipy.integrate.cumulative_trapezoid(measured, dx=1.0 / rate, initial=0)
        moved = scipy.signal.detrend(moved)
        fast = measured
    else:
        moved, fast = measured, signal_slope(measured, white_level(measured, rate), rate)
    pull = signal_slope(fast, white_level(fast, rate), rate)
    inertia = mass * pull
    share = float(np.sqrt(np.mean(inertia**2) / max(float(np.mean(force**2)), 1e-300)))
    noise = white_level(force, rate)
    z, v, f = (_thinned(x, thin) for x in (moved, fast, force - inertia))
    turns = turns_of(z)
    swing = np.full(z.size, -1, dtype=np.int64)
    for i, (a, b) in enumerate(pairwise(turns)):
        swing[a:b] = i
    swing[swing < 2] = -1
    swing[np.abs(v) < AT_REST * np.sqrt(np.mean(v**2))] = -1
    return Loop(
        test.name, rate / thin, z, v, f, swing, z[turns], share, noise, test.hold_out
    )  # fmt: skip


def _thinned(samples: FloatArray, thin: int) -> FloatArray:
    whole = samples.size // thin * thin
    out: FloatArray = samples[:whole].reshape(-1, thin).mean(axis=1)
    return out


def turns_of(z: FloatArray) -> NDArray[np.int64]:
    """Return the samples at which a motion turns by more than `TURN` of its range."""
    least = TURN * float(np.ptp(z))
    turns, extreme, way = [0], 0, 0
    for i in range(1, z.size):
        if way == 0:
            if abs(z[i] - z[0]) > least:
                way, extreme = (1 if z[i] > z[0] else -1), i
        elif (z[i] - z[extreme]) * way > 0.0:
            extreme = i
        elif (z[extreme] - z[i]) * way > least:
            turns.append(extreme)
            way, extreme = -way, i
    turns.append(extreme)
    return np.array(turns, dtype=np.int64)


def scatter(found: Sequence[Loop]) -> float | None:
    """Return by how much the force differs between repeats of one swing [N], rms.

    Two swings are repeats where this turn and the two before it lie within `SAME` of the range:
    same way, same start, same history. The force is compared at equal displacement. With n
    repeats each differs from the mean of the others by n/(n - 1) of the variance of one. None
    where no swing was repeated.
    """
    squares, count = 0.0, 0
    for loop in found:
        same = SAME * float(np.ptp(loop.displacement))
        swings = range(2, loop.turns.size - 1)
        for i in swings:
            alike = [
                j for j in swings
                if j != i and (j - i) % 2 == 0
                and np.max(np.abs(loop.turns[i - 1 : i + 2] - loop.turns[j - 1 : j + 2])) < same
            ]  # fmt: skip
            own = np.flatnonzero(loop.swing == i)
            others = [_along(loop, j, loop.displacement[own]) for j in alike]
            if not others or not own.size:
                continue
            differ = loop.force[own] - np.mean(others, axis=0)
            n = len(alike) + 1
            squares += float(np.nansum(differ**2)) * (n - 1) / n
            count += int(np.sum(np.isfinite(differ)))
    return float(np.sqrt(squares / count)) if count else None


def _along(loop: Loop, swing: int, at: FloatArray) -> FloatArray:
    """Return the force of a swing at these displacements [N]; NaN where it did not come."""
    own = np.flatnonzero(loop.swing == swing)
    if not own.size:
        return np.full(at.size, np.nan)
    order = own[np.argsort(loop.displacement[own], kind="stable")]
    return np.interp(
        at, loop.displacement[order], loop.force[order], left=np.nan, right=np.nan
    )  # fmt: skip
