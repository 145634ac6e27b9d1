"""The force laws that the compiled kernels know: every effect is written in them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum, unique
from functools import lru_cache
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray


@unique
class Law(IntEnum):
    """Number of a force law in the tables that the kernels walk.

    Each has its formula and its branches in a file of `simulation.laws`, and nowhere else. An
    effect made of laws that stand here needs no other file than its own.
    """

    LINEAR = 0  # stiffness k, damping c: goes into the matrices, never into the table
    ATTACHED = 1  # mass, stiffness, damping of one more degree of freedom: into the matrices
    DRIFT = 2  # k r (t - t0) z
    STOP = 3  # k (z - a) where s (z - a) > 0
    JUMP = 4  # k z where s (z - a) > 0
    CONTACT_DAMPING = 5  # c v where s (z - a) > 0
    ODD_POWER = 6  # f |z / r|^n sign z
    EVEN_POWER = 7  # f |z / r|^n
    POWER_DAMPING = 8  # c |z / r|^n v
    QUADRATIC_DAMPING = 9  # c v |v|
    FRICTION = 10  # (Fc + (Fs - Fc) exp(-(v / vs)^2)) sign v, sticking below Fs
    LUGRE = 11  # one state, the bristle deflection
    JENKINS = 12  # one state, the spring force
    IWAN = 13  # stiffness, slip displacement, chi + 2; one state, how far it began from rest
    BOUC_WEN = 14  # k h, h' = v (1 - c |h / zy|^n); k, zy, n, c loading, back; see `curve_back`
    CONSTANT = 15  # a force
    SERIES = 16  # one state u: play, spring, slider, damper; k, a+, a-, Fs, 1 / c
    TABLE = 17  # a tabulated law, its numbers in `table`
    HERTZ = 18  # s k d^1.5 (1 + c s v) where d = s (z - a) > 0, and where that is not below 0


WITH_STATE: Final = frozenset({Law.LUGRE, Law.JENKINS, Law.IWAN, Law.BOUC_WEN, Law.SERIES})
"""Laws with a state of their own; `largest_state` says how large it grows."""


@final
@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table that the kernels walk.

    Attributes
    ----------
    law : Law
        Which force law.
    values : tuple of float
        Its numbers, at most six, in the order that `Law` gives [SI].
    table : (any,) array
        More numbers, of a tabulated law (see `tabulated.packed`).
    """

    law: Law
    values: tuple[float, ...]
    table: FloatArray = field(default_factory=lambda: np.zeros(0), compare=False)


_LEAST_LIMIT: Final = 1e-300
"""Least stiffness or share that a limit is over, so that none is infinite by rounding."""


def curve_back(values: Sequence[float]) -> FloatArray:
    r"""Return the curve of a Bouc-Wen branch that leads back; no numbers if it is a line.

    The state of the law is its way back: how far it has to go until the force is 0. Along the
    branch back it moves as the joint does, whatever rounding leaves of a force that hardly
    changes; the force is :math:`h = H(u)` with :math:`H' = 1 - c |H|^n`. Where that branch
    is straight, the way back is h. So is the state where the branch hardens, or bends more
    than loading does: there the force tells the place.

    Parameters
    ----------
    values : sequence of float
        Numbers of `Law.BOUC_WEN` [units of the law].
    """
    exponent, loading, back = values[2:5]
    if not 0.0 < back <= loading:
        return np.zeros(0)
    return _curve(back, exponent)


@lru_cache(maxsize=64)
def _curve(share: float, exponent: float) -> FloatArray:
    from shakerproc.models.kernels import saturating_curve  # loads the compiler: late

    return saturating_curve(share, exponent)


def largest_state(law: Law, values: Sequence[float]) -> tuple[float, float] | None:
    """Return the size of the state of a law and its upper bound; None without a state.

    Parameters
    ----------
    law : Law
        The law.
    values : sequence of float
        Its numbers [units of the law].

    Returns
    -------
    (float, float)
        What a change of the state is compared with, and its limit [unit of the state]; infinite
        for a loop that hardens.
    """
    if law in (Law.JENKINS, Law.IWAN):
        return values[1], values[1]
    if law is Law.LUGRE:
        deflection = values[0] / max(values[3], _LEAST_LIMIT)
        return deflection, max(values[0], values[1]) / max(values[3], _LEAST_LIMIT)
    if law is Law.SERIES:
        farthest = max(values[1], values[2]) + values[3] / max(values[0], _LEAST_LIMIT)
        return farthest, farthest
    if law is Law.BOUC_WEN:
        return values[1], values[1] * _longest_way_back(values)
    return None


def _longest_way_back(values: Sequence[float]) -> float:
    """Return the way back from all that loading reaches, over the yield displacement [-]."""
    exponent, loading, back = values[2:5]
    if not loading > 0.0 or loading == back:
        return math.inf
    farthest = float(loading ** (-1.0 / exponent))
    curve = curve_back(values)
    if not curve.size:
        return farthest
    from shakerproc.models.kernels import place_on_curve  # loads the compiler: late

    return float(place_on_curve(curve, farthest, exponent))
