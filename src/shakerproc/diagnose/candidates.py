"""The candidates: every effect as the observer knows it, with grids to start from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose import kernel

N_SLIDERS = 14
"""Sliders that stand for the even distribution of an Iwan joint."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Scales of the motion in one joint, from which the grids are made.

    Attributes
    ----------
    peak, rms : float
        Relative displacement [m].
    fast : float
        Rms of the relative velocity [m/s].
    stiffness, damping : float
        Of the joint [N/m], [N s/m].
    mass : float
        Reduced mass of its two sides [kg].
    frequency : float
        Where the response is strongest [Hz].
    noise : float
        Rms of what the velocity is known to [m/s].
    force : float
        Mass times rms of the acceleration [N].
    """

    peak: float
    rms: float
    fast: float
    stiffness: float
    damping: float
    mass: float
    frequency: float
    noise: float
    force: float


Values = tuple[float, ...]
Rows = Callable[[Values, float], tuple[tuple[int, Values], ...]]


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect that may be missing.

    Attributes
    ----------
    kind : str
        Key in `EFFECTS`.
    names, units : tuple of str
        Free parameters, in order.
    positive : tuple of bool
        Whether each is above 0 (then its logarithm is fitted).
    columns : callable
        From inner values to the (op, parameters) of its linear columns, for the screening.
    grid : callable
        Inner values to start from, for a Motion.
    combine : callable
        From inner values and the regressed weights of the columns to the parameters, or None
        where the weights are not physical.
    guesses : callable
        Parameters to try besides those of the screening, for a Motion.
    rows : callable
        From the parameters and the stiffness of the joint to the laws of the observer.
    nested : mapping of str to callable
        From the fitted parameters of a simpler effect, by its kind, to where to start.
    """

    kind: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    positive: tuple[bool, ...]
    columns: Rows
    grid: Callable[[Motion], list[Values]]
    combine: Callable[[Values, FloatArray, Motion], Values | None]
    rows: Rows
    guesses: Callable[[Motion], list[Values]] = lambda _: []
    fixed: Mapping[str, float | str] = field(default_factory=lambda: MappingProxyType({}))
    nested: Mapping[str, Callable[[Values, Motion], list[Values]]] = field(
        default_factory=lambda: MappingProxyType({})
    )


def _above(x: float) -> bool:
    return bool(np.isfinite(x) and x > 0.0)


def _single(inner: Values, weights: FloatArray, _: Motion) -> Values | None:
    return (float(weights[0]), *inner) if _above(weights[0]) else None


def _signed(inner: Values, weights: FloatArray, _: Motion) -> Values | None:
    return (float(weights[0]), *inner)


def _fractions(
    motion: Motion, n: int = 14, low: float = 0.03, high: float = 0.95
) -> list[float]:
    shares = np.geomspace(low, high, n)
    return [float(share * motion.peak) for share in shares]


def _offset_grid(motion: Motion) -> list[Values]:
    steps = _fractions(motion, 7, 0.05, 0.9)
    return [(a, b) for a in steps for b in steps if a != b]


FORCES = (0.02, 0.06, 0.15, 0.4, 0.9)
"""Friction forces to try, as shares of mass times rms of the acceleration [-]."""

GAP = Candidate(
    "gap", ("stiffness", "clearance"), ("N/m", "m"), (True, True),
    columns=lambda inner, _: ((kernel.GAP, (1.0, inner[0])),),
    grid=lambda motion: [(a,) for a in _fractions(motion, 18)],
    combine=_single,
    rows=lambda p, _: ((kernel.GAP, (p[0], p[1])),),
    nested=MappingProxyType({"offset_gap": lambda p, _: [(p[0], 0.5 * (p[1] + p[2]))]}),
)  # fmt: skip

OFFSET_GAP = Candidate(
    "offset_gap", ("stiffness", "clearance_positive", "clearance_negative"),
    ("N/m", "m", "m"), (True, True, True),
    columns=lambda inner, _: ((kernel.OFFSET_GAP, (1.0, *inner)),),
    grid=_offset_grid,
    combine=_single,
    rows=lambda p, _: ((kernel.OFFSET_GAP, p),),
    nested=MappingProxyType({
        "gap": lambda p, _: [
            (p[0], p[1] * (1.0 + off), p[1] * (1.0 - off)) for off in (-0.3, -0.02, 0.02, 0.3)
        ]
    }),
)  # fmt: skip


def _stop(side: float) -> Candidate:
    return Candidate(
        "stop", ("stiffness", "clearance"), ("N/m", "m"), (True, True),
        columns=lambda inner, _: ((kernel.STOP, (1.0, inner[0], side)),),
        grid=lambda motion: [(a,) for a in _fractions(motion, 18)],
        combine=_single,
        rows=lambda p, _: ((kernel.STOP, (p[0], p[1], side)),),
        fixed=MappingProxyType({"side": "positive" if side > 0.0 else "negative"}),
        nested=MappingProxyType({
            "offset_gap": lambda p, _: [(p[0], p[1] if side > 0.0 else p[2])]
        }),
    )  # fmt: skip


CUBIC = Candidate(
    "cubic_stiffness", ("coefficient",), ("N/m^3",), (False,),
    columns=lambda _i, _: ((kernel.CUBIC, (1.0,)),),
    grid=lambda _: [()],
    combine=_signed,
    rows=lambda p, _: ((kernel.CUBIC, p),),
)  # fmt: skip

QUADRATIC = Candidate(
    "quadratic_stiffness", ("coefficient",), ("N/m^2",), (False,),
    columns=lambda _i, _: ((kernel.QUADRATIC, (1.0,)),),
    grid=lambda _: [()],
    combine=_signed,
    rows=lambda p, _: ((kernel.QUADRATIC, p),),
)  # fmt: skip


def _power(motion: Motion) -> list[Values]:
    return [(n,) for n in (1.3, 1.5, 1.7, 2.0, 2.3, 2.6, 3.2, 3.6, 4.0, 4.5, 5.0, 6.0)]


def power(reference: float) -> Candidate:
    """Return the power law of a joint; its force is given at this displacement [m]."""
    return Candidate(
        "power_law", ("force", "exponent"), ("N", "1"), (True, True),
        columns=lambda inner, _: ((kernel.POWER, (1.0, reference, inner[0])),),
        grid=_power,
        combine=_single,
        rows=lambda p, _: ((kernel.POWER, (p[0], reference, p[1])),),
        fixed=MappingProxyType({"reference_displacement": reference}),
    )  # fmt: skip


COULOMB = Candidate(
    "coulomb_friction", ("sliding_force",), ("N",), (True,),
    columns=lambda inner, _: ((kernel.COULOMB, (1.0, 0.0, 1.0, inner[0])),),
    grid=lambda motion: [(s * motion.fast,) for s in (0.01, 0.05, 0.2)],
    combine=lambda inner, weights, _: (float(weights[0]),) if _above(weights[0]) else None,
    rows=lambda p, _: ((kernel.COULOMB, p),),
    guesses=lambda motion: [(f * motion.force,) for f in FORCES],
    nested=MappingProxyType({
        "stribeck_friction": lambda p, _: [(p[0],), (p[0] * (1.0 + 0.5 * p[1]),)],
        "lugre_friction": lambda p, _: [(p[0],)],
    }),
)  # fmt: skip


def _stribeck_values(inner: Values, weights: FloatArray, _: Motion) -> Values | None:
    if not (_above(weights[0]) and _above(weights[1])):
        return None
    return (float(weights[0]), float(weights[1] / weights[0]), inner[0])


def _stribeck_around(coulomb: Values, motion: Motion) -> list[Values]:
    return [
        (share * coulomb[0], excess, speed * motion.fast)
        for share, excess in ((0.97, 0.1), (0.85, 0.2), (0.9, 0.4), (0.65, 0.5), (0.75, 0.8))
        for speed in (0.05, 0.2, 0.6, 1.5)
    ]


STRIBECK = Candidate(
    "stribeck_friction", ("sliding_force", "excess", "stribeck_velocity"),
    ("N", "1", "m/s"), (True, True, True),
    columns=lambda inner, _: (
        (kernel.COULOMB, (1.0, 0.0, 1.0, inner[1])),
        (kernel.STRIBECK, (0.0, 1.0, inner[0], inner[1])),
    ),
    grid=lambda motion: [
        (s * motion.fast, r * motion.fast) for s in (0.1, 0.3, 0.8) for r in (0.02, 0.1)
    ],
    combine=_stribeck_values,
    rows=lambda p, _: ((kernel.STRIBECK, (p[0], p[0] * (1.0 + p[1]), p[2])),),
    guesses=lambda motion: [(f * motion.force, 0.5, 0.3 * motion.fast) for f in FORCES],
    nested=MappingProxyType({"coulomb_friction": _stribeck_around}),
)  # fmt: skip


def _lugre_grid(motion: Motion) -> list[Values]:
    return [
        (force * motion.stiffness * motion.rms, bend * motion.rms, speed * motion.fast)
        for force in (0.05, 0.2)
        for bend in (0.05, 0.2)
        for speed in (0.2, 0.6)
    ]


def _lugre_rows(p: Values, mass: float) -> tuple[tuple[int, Values], ...]:
    sliding, excess, speed, bristle, ratio = p
    damping = ratio * np.sqrt(bristle * mass)
    return ((kernel.LUGRE, (bristle, damping, 0.0, sliding, sliding * (1.0 + excess), speed)),)


def _lugre_values(inner: Values, weights: FloatArray, _: Motion) -> Values | None:
    if not _above(weights[0]):
        return None
    force, bend, speed = inner
    return (force * float(weights[0]), 0.4, speed, force * float(weights[0]) / bend, 0.2)


def _lugre_around(coulomb: Values, motion: Motion) -> list[Values]:
    return [
        (0.95 * coulomb[0], 0.3, speed * motion.fast, coulomb[0] / (bend * motion.rms), 0.2)
        for speed in (0.1, 0.5)
        for bend in (0.005, 0.02, 0.1)
    ]


LUGRE = Candidate(
    "lugre_friction",
    ("sliding_force", "excess", "stribeck_velocity", "bristle_stiffness", "bristle_ratio"),
    ("N", "1", "m/s", "N/m", "1"), (True,) * 5,
    columns=lambda inner, mass: _lugre_rows(
        (inner[0], 0.4, inner[2], inner[0] / inner[1], 0.2), mass
    ),
    grid=_lugre_grid,
    combine=_lugre_values,
    rows=_lugre_rows,
    guesses=lambda motion: [
        (f * motion.force, 0.5, 0.3 * motion.fast, f * motion.force / (0.1 * motion.rms), 0.2)
        for f in FORCES
    ],
    nested=MappingProxyType({"coulomb_friction": _lugre_around}),
)  # fmt: skip

QUADRATIC_DAMPING = Candidate(
    "quadratic_damping", ("coefficient",), ("N s^2/m^2",), (True,),
    columns=lambda _i, _: ((kernel.QUADRATIC_DAMPING, (1.0,)),),
    grid=lambda _: [()],
    combine=_single,
    rows=lambda p, _: ((kernel.QUADRATIC_DAMPING, p),),
)  # fmt: skip

CONTACT_DAMPING = Candidate(
    "contact_damping", ("damping", "clearance"), ("N s/m", "m"), (True, True),
    columns=lambda inner, _: ((kernel.CONTACT_DAMPING, (1.0, inner[0])),),
    grid=lambda motion: [(a,) for a in _fractions(motion, 18)],
    combine=_single,
    rows=lambda p, _: ((kernel.CONTACT_DAMPING, p),),
)  # fmt: skip


def _slips(motion: Motion, n: int = 12) -> list[Values]:
    return [(float(s * motion.rms),) for s in np.geomspace(0.05, 4.0, n)]


JENKINS = Candidate(
    "jenkins", ("stiffness", "slip_displacement"), ("N/m", "m"), (True, True),
    columns=lambda inner, _: ((kernel.JENKINS, (1.0, inner[0])),),
    grid=_slips,
    combine=_single,
    rows=lambda p, _: ((kernel.JENKINS, (p[0], p[0] * p[1])),),
)  # fmt: skip

IWAN = Candidate(
    "iwan", ("stiffness", "slip_displacement"), ("N/m", "m"), (True, True),
    columns=lambda inner, _: ((kernel.IWAN, (1.0, inner[0], float(N_SLIDERS))),),
    grid=lambda motion: [(2.0 * s,) for (s,) in _slips(motion, 10)],
    combine=_single,
    rows=lambda p, _: ((kernel.IWAN, (p[0], p[1], float(N_SLIDERS))),),
)  # fmt: skip

BOUC_WEN = Candidate(
    "bouc_wen", ("stiffness", "yield_displacement", "exponent"), ("N/m", "m", "1"), (True,) * 3,
    columns=lambda inner, _: ((kernel.BOUC_WEN, (1.0, *inner)),),
    grid=lambda motion: [(s, n) for (s,) in _slips(motion, 8) for n in (1.0, 2.0)],
    combine=_single,
    rows=lambda p, _: ((kernel.BOUC_WEN, p),),
)  # fmt: skip

DRIFT = Candidate(
    "stiffness_drift", ("rate",), ("1/s",), (False,),
    columns=lambda _i, stiffness: ((kernel.DRIFT, (stiffness, 0.0)),),
    grid=lambda _: [()],
    combine=_signed,
    rows=lambda p, stiffness: ((kernel.DRIFT, (p[0] * stiffness, 0.0)),),
    fixed=MappingProxyType({"reference": 0.0}),
)  # fmt: skip

ATTACHED = Candidate(
    "attached_mode", ("mass", "frequency", "damping_ratio"), ("kg", "Hz", "1"), (True,) * 3,
    columns=lambda _i, _: (),
    grid=lambda _: [],
    combine=_single,
    rows=lambda _p, _: (),
)  # fmt: skip


def library(motion: Motion) -> tuple[Candidate, ...]:
    """Return every candidate for a joint that moves like this."""
    return (
        CUBIC, QUADRATIC, power(motion.rms), GAP, _stop(1.0), _stop(-1.0), OFFSET_GAP,
        COULOMB, STRIBECK, LUGRE, QUADRATIC_DAMPING, CONTACT_DAMPING,
        JENKINS, IWAN, BOUC_WEN, ATTACHED, DRIFT,
    )  # fmt: skip


def sought() -> frozenset[str]:
    """Return the kinds of all candidates."""
    return frozenset(candidate.kind for candidate in library(Motion(*[1.0] * 9)))
