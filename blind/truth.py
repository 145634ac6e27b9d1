"""The motion of the truth: fixed-step Runge-Kutta of order 4 with located crossings.

Coordinates are relative to the base. The base acceleration (or the force) is given at twice the
rate of the steps. A step in which an element crosses a threshold or stops sliding is cut there;
a contact that sticks is held by the force it needs until that exceeds what it can bear.

The kernels share one array m, laid out in `laws.layout`; p is the place of an element's table.
"""

from dataclasses import dataclass

import numpy as np

from blind import laws
from blind.integration.steps import integrate
from blind.laws import layout


@dataclass(frozen=True)
class Truth:
    """Masses, linear joints as (first end, second end, stiffness, damping), and elements.

    An element is (code, first end, second end, parameters, thresholds); -1 is the base. `start`
    are the displacements at rest, none of them where it is empty.
    """

    masses: tuple[float, ...]
    joints: tuple[tuple[int, int, float, float], ...]
    elements: tuple[tuple[int, int, int, tuple[float, ...], tuple[float, ...]], ...]
    force_on: int = -1
    start: tuple[float, ...] = ()


@dataclass(frozen=True)
class Motion:
    """What a test does: acceleration at fine steps and its means over them, else at samples."""

    acceleration: np.ndarray
    means: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    stretch: np.ndarray
    rate: np.ndarray
    force: np.ndarray


def _linear(truth: Truth) -> np.ndarray:
    """Return what the joints take off the accelerations, for each displacement and velocity."""
    n = len(truth.masses)
    matrix = np.zeros((n, 2 * n))
    for first, second, stiffness, damping in truth.joints:
        ends = [(second, 1.0)] + ([(first, -1.0)] if first >= 0 else [])
        for row, a in ends:
            for column, b in ends:
                matrix[row, column] += a * b * stiffness / truth.masses[row]
                matrix[row, n + column] += a * b * damping / truth.masses[row]
    return matrix


def _memory(truth: Truth) -> np.ndarray:
    """Return the array that the kernels share.

    Raises
    ------
    ValueError
        If there are more masses, elements or states than it holds.
    """
    m = np.zeros(layout.SIZE)
    n = len(truth.masses)
    if n > layout.JOINTS - layout.MASSES or len(truth.elements) > 6:
        raise ValueError("too many masses or elements for the kernels")
    m[layout.N_MASSES], m[layout.N_ELEMENTS] = n, len(truth.elements)
    m[layout.FORCE_ON] = truth.force_on
    m[layout.MASSES : layout.MASSES + n] = truth.masses
    for i, row in enumerate(_linear(truth)):
        m[layout.JOINTS + 8 * i : layout.JOINTS + 8 * i + row.size] = row
    size = 2 * n
    for e, (code, first, second, parameters, thresholds) in enumerate(truth.elements):
        p = layout.ELEMENTS + layout.STRIDE * e
        m[p : p + len(parameters)] = parameters
        edges = p + layout.THRESHOLDS
        m[edges : edges + len(thresholds)] = thresholds
        m[p + layout.FIRST], m[p + layout.SECOND], m[p + layout.KIND] = first, second, code
        m[p + layout.N_THRESHOLDS] = len(thresholds)
        m[p + layout.SLIDES], m[p + layout.STATE] = code in laws.SLIDING, size
        size += laws.STATES.get(code, 0)
    m[layout.STATE_SIZE] = size
    if size > layout.TRIAL - layout.Y:
        raise ValueError("too many states for the kernels")
    m[layout.Y : layout.Y + len(truth.start)] = truth.start
    return m


def move(
    truth: Truth,
    base: np.ndarray,
    force: np.ndarray,
    *,
    sample_rate: float,
    substeps: int,
    limit: float,
) -> Motion | None:
    """Return the motion under base acceleration and force, or None if it runs away.

    `base` and `force` hold 2 * substeps * n_samples + 1 values; the run starts at rest.

    Raises
    ------
    RuntimeError
        If an Iwan element turns more often than its memory holds.
    """
    n, ne = len(truth.masses), len(truth.elements)
    n_steps = (base.size - 1) // (2 * substeps) * substeps
    m = _memory(truth)
    m[layout.MODES] = any(
        thresholds or code in laws.SLIDING for code, _, _, _, thresholds in truth.elements
    )
    m[layout.STEP] = 1.0 / (sample_rate * substeps)
    m[layout.SUBSTEPS], m[layout.LIMIT] = substeps, limit
    accelerations = np.empty((2, n_steps, n))
    samples = np.empty((n_steps // substeps, 2 * n + 3 * ne))
    status = integrate(m, base, force, accelerations, samples)
    if status == 2:
        raise RuntimeError("the memory of an Iwan element is full")
    if status:
        return None
    parts = np.split(samples, np.cumsum([n, n, ne, ne]), axis=1)
    return Motion(*accelerations, *parts)
