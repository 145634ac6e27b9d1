"""The thesis' methods, for comparison: Newmark's, and the solvers of MATLAB's kind.

They know nothing of switchings and take the laws from the effects themselves, not from the
compiled tables: slow, of limited accuracy, and independent of all else in this room. Effects
with memory, and joints that stick, are beyond them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, final

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError, SimulationError
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.model import Model

_ITERATIONS = 50
_CORRECTION = 1e-12
"""Last correction of displacement as a share of the largest so far [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ComparedMotion:
    """Motion by one method of comparison.

    Attributes
    ----------
    displacement, velocity, acceleration : (n_masses, n) array
        Relative to the base [m], [m/s], [m/s^2].
    evaluations : int
        How often the forces were computed.
    """

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    evaluations: int


def newmark(
    model: Model,
    excitation: FloatArray,
    sample_rate: float,
    *,
    start: FloatArray | None = None,
) -> ComparedMotion:
    r"""Return the response by Newmark's method, one step a sample.

    Predict, then correct by Newton's method with the effective stiffness
    :math:`K + \gamma / (\beta \Delta t) C + M / (\beta \Delta t^2)`, with the average
    acceleration, :math:`\beta = 1/4` and :math:`\gamma = 1/2`.

    Parameters
    ----------
    model : Model
        Of memoryless effects.
    excitation : (n,) array
        Input at the steps [m/s^2 or N].
    sample_rate : float
        Steps per second [Hz].
    start : (2, n_masses) array, optional
        Displacement [m] and velocity [m/s] at the start.

    Raises
    ------
    ModelError
        If an effect has memory.
    SimulationError
        If the corrections do not die out.

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       sec. 3.8 and eq. 3.50.
    """
    beta, gamma = 0.25, 0.5
    forces = _Forces(model)
    n, h = len(model.masses), 1.0 / sample_rate
    d, v = (np.zeros((2, n)) if start is None else np.asarray(start, dtype=float)).copy()
    a = (excitation[0] * forces.drive - forces.at(d, v)) / forces.mass
    motion = np.empty((3, n, excitation.size))
    motion[:, :, 0] = d, v, a
    largest, evaluations = float(np.max(np.abs(d))), 1
    for step in range(1, excitation.size):
        load = excitation[step] * forces.drive
        guess = d + h * v + (0.5 - beta) * h**2 * a
        rate = v + (1.0 - gamma) * h * a
        d = guess.copy()
        for _ in range(_ITERATIONS):
            a = (d - guess) / (beta * h**2)
            v = rate + gamma * h * a
            evaluations += 1
            residual = load - forces.at(d, v) - forces.mass * a
            stiffness, damping = forces.slopes(d, v)
            effective = stiffness + gamma / (beta * h) * damping
            effective += np.diag(forces.mass) / (beta * h**2)
            change = np.linalg.solve(effective, residual)
            d = d + change
            largest = max(largest, float(np.max(np.abs(d))))
            if np.max(np.abs(change)) <= _CORRECTION * largest:
                break
        else:
            raise SimulationError(
                f"{model.title}: Newmark's corrections do not die out at {step * h:.6g} s. "
                f"Take a higher sample rate."
            )
        a = (d - guess) / (beta * h**2)
        v = rate + gamma * h * a
        motion[:, :, step] = d, v, a
    return ComparedMotion(motion[0], motion[1], motion[2], evaluations)


def general_solver(
    model: Model,
    excitation: Callable[[float], float],
    time: FloatArray,
    *,
    method: Literal["RK45", "RK23", "DOP853", "Radau", "BDF", "LSODA"] = "RK45",
    relative_tolerance: float = 1e-3,
    start: FloatArray | None = None,
) -> ComparedMotion:
    """Return the response by a general solver of ordinary differential equations.

    ``RK45`` at 1e-3 is what MATLAB's ode45 is by default, ``BDF`` close to its ode15s.

    Parameters
    ----------
    model : Model
        Of memoryless effects.
    excitation : function
        The input at a time [s], in its SI unit.
    time : (n,) array
        Times of the results [s].
    method : str
        One of scipy's.
    relative_tolerance : float
        Error of a step as a share of the motion; the absolute one is 1e-6 of it on a motion
        of 1 mm [-].
    start : (2, n_masses) array, optional
        Displacement [m] and velocity [m/s] at the start.

    Raises
    ------
    ModelError
        If an effect has memory.
    SimulationError
        If the solver gives up.
    """
    forces = _Forces(model)
    n = len(model.masses)

    def rates(at: float, y: FloatArray) -> FloatArray:
        push = excitation(at) * forces.drive - forces.at(y[:n], y[n:])
        return np.concatenate((y[n:], push / forces.mass))

    first = np.zeros(2 * n) if start is None else np.ravel(start)
    solved = solve_ivp(
        rates, (float(time[0]), float(time[-1])), first, method=method, t_eval=time,
        rtol=relative_tolerance, atol=relative_tolerance * 1e-6,
    )  # fmt: skip
    if not solved.success:
        raise SimulationError(f"{model.title}: {method} gives up: {solved.message}")
    acceleration = np.array([rates(t, y)[n:] for t, y in zip(time, solved.y.T, strict=True)]).T
    return ComparedMotion(solved.y[:n], solved.y[n:], acceleration, int(solved.nfev))


class _Forces:
    """Forces of all elements by the formulas of their effects."""

    def __init__(self, model: Model) -> None:
        names = list(model.masses)
        if model.excitation.imposed:
            raise ModelError(
                f"{model.title}: the methods of comparison do not impose a displacement. Use "
                f"simulate."
            )
        if model.structures:
            raise ModelError(
                f"{model.title}: the methods of comparison carry masses alone, no structures. "
                f"Use simulate."
            )
        self.mass = np.array([model.masses[name] for name in names])
        self.drive = -self.mass if model.excitation.moves_base else np.zeros(len(names))
        if model.excitation.on is not None:
            self.drive[names.index(model.excitation.on)] = 1.0
        self.parts: list[tuple[FloatArray, AbstractMemorylessEffect]] = []
        for element in resolved(model):
            if not isinstance(element.effect, AbstractMemorylessEffect):
                raise ModelError(
                    f"{model.title}: {element.effect.kind} has memory, which the methods of "
                    f"comparison do not carry. Use simulate."
                )
            direction = np.zeros(len(names))
            for place, sign in zip(element.between, (-1.0, 1.0), strict=True):
                if place in names:
                    direction[names.index(place)] = sign
            self.parts.append((direction, element.effect))

    def at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return the forces that hold the masses back, (n_masses,) array [N]."""
        total = np.zeros_like(self.mass)
        for direction, effect in self.parts:
            z, v = np.atleast_1d(direction @ displacement), np.atleast_1d(direction @ velocity)
            total += direction * effect.force_at(z, v)[0]
        return total

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return tangent stiffness [N/m] and damping [N s/m], (n_masses, n_masses) arrays."""
        stiffness, damping = (np.zeros((self.mass.size, self.mass.size)) for _ in range(2))
        for direction, effect in self.parts:
            z, v = np.atleast_1d(direction @ displacement), np.atleast_1d(direction @ velocity)
            by_z, by_v = effect.slopes(z, v)
            across = np.outer(direction, direction)
            stiffness += across * by_z[0]
            damping += across * by_v[0]
        return stiffness, damping
