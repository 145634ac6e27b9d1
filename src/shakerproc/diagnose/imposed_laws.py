"""Laws along an imposed motion: the library, and play in series with dry friction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit

from shakerproc.data import FloatArray
from shakerproc.diagnose import kernel
from shakerproc.diagnose.candidates import Candidate, Motion, Values, library
from shakerproc.diagnose.imposed_motion import AT_REST, Loop

SERIES: Final = -1
"""Number of the series law, which the kernel does not know."""


@njit(cache=True, nogil=True)
def slide_with_play(
    z: FloatArray, k: float, a: float, limit: float, forces: FloatArray
) -> None:
    """Fill forces (n,): a slider that gives way at a force, dragged through an elastic play.

    force = k (|w| - a) sign(w) outside the play, w = z - slider; where the force would exceed
    the limit the slider follows, so that w never leaves +-(a + limit / k). w begins at 0.
    """
    most = a + limit / k
    w = 0.0
    for i in range(z.shape[0]):
        if i > 0:
            w += z[i] - z[i - 1]
        w = min(max(w, -most), most)
        out = abs(w) - a
        forces[i] = math.copysign(k * out, w) if out > 0.0 else 0.0


def _slips(motion: Motion) -> list[Values]:
    return [
        (play * motion.peak, bend * motion.peak)
        for play in (0.01, 0.03, 0.1, 0.3)
        for bend in (0.01, 0.03, 0.1, 0.3)
    ]


PLAY_AND_SLIDER: Final = Candidate(
    "coulomb_friction+gap", ("sliding_force", "stiffness", "clearance"), ("N", "N/m", "m"),
    (True, True, True),
    columns=lambda inner, _: ((SERIES, (inner[1], 1.0, inner[0])),),
    grid=_slips,
    combine=lambda inner, w, _: (
        (float(w[0]) * inner[1], float(w[0]), inner[0]) if w[0] > 0.0 else None
    ),
    rows=lambda p, _: ((SERIES, p),),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Law:
    """One or two candidates that act side by side in the joint.

    Attributes
    ----------
    parts : tuple of Candidate
        What acts in parallel.
    """

    parts: tuple[Candidate, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Keys of `EFFECTS`."""
        return tuple(kind for part in self.parts for kind in part.kind.split("+"))

    @property
    def in_series(self) -> bool:
        """Whether play and friction act one behind the other."""
        return PLAY_AND_SLIDER in self.parts

    @property
    def positive(self) -> tuple[bool, ...]:
        """Whether each number is above 0."""
        return tuple(sign for part in self.parts for sign in part.positive)

    def split(self, values: Sequence[float]) -> list[Values]:
        """Return the numbers of each part."""
        out, first = [], 0
        for part in self.parts:
            out.append(tuple(values[first : first + len(part.names)]))
            first += len(part.names)
        return out


def forces(law: Law, values: Sequence[float], loop: Loop, motion: Motion) -> FloatArray:
    """Return the force of a law along the motion of a test, (n,) array [N]."""
    total = np.zeros(loop.force.size)
    for part, own in zip(law.parts, law.split(values), strict=True):
        beside = motion.mass if part.kind == "lugre_friction" else motion.stiffness
        for op, row in part.rows(own, beside):
            total += along(op, row, loop, motion)
    return total


def along(op: int, row: Values, loop: Loop, motion: Motion) -> FloatArray:
    """Return the force of one law of the kernel along the motion of a test, (n,) array [N]."""
    out = np.empty(loop.force.size)
    if op == SERIES:
        limit, stiffness, clearance = row
        slide_with_play(loop.displacement, stiffness, clearance, limit, out)
        return out
    numbers = np.zeros((1, 8))
    numbers[0, : len(row)] = row
    if op in {kernel.COULOMB, kernel.STRIBECK}:
        numbers[0, 3] = motion.noise
    kernel.force_along(
        op, numbers, loop.displacement, loop.velocity, 0.0, 1.0 / loop.sample_rate, out
    )
    return out


def motion_of(found: Sequence[Loop], mass: float) -> Motion:
    """Return the scales of all tests together."""
    z = np.concatenate([loop.displacement for loop in found])
    v = np.concatenate([loop.velocity for loop in found])
    f = np.concatenate([loop.force for loop in found])
    rms, fast, force = (float(np.sqrt(np.mean(x**2))) for x in (z, v, f))
    return Motion(
        float(np.max(np.abs(z))), rms, fast, force / rms, force / fast, mass,
        fast / rms / (2.0 * np.pi), 0.2 * AT_REST * fast, force,
    )  # fmt: skip


def single_laws(motion: Motion) -> tuple[Law, ...]:
    """Return every law of one part; an attached mode is inertia here, and not sought."""
    known = [part for part in library(motion) if part.kind != "attached_mode"]
    return tuple(Law((part,)) for part in (*known, PLAY_AND_SLIDER))
