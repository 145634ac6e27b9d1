r"""The backbone: free motion of each size, its frequency and its damping.

What damping takes is given back by a negative damping in proportion to the masses, so that the
motion repeats itself (extended periodic motion). One mass with a linear damper thus has the
backbone of the undamped oscillator, and friction gives the damping ratio of each amplitude.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.continuation import StepSizes, Trace, follow
from shakerproc.simulation.harmonic_balance.curves import motion_weights
from shakerproc.simulation.harmonic_balance.laws import AbstractLaw, HarmonicMotion
from shakerproc.simulation.harmonic_balance.system import PeriodicSystem, system_of_model


@final
@dataclass(frozen=True, eq=False)
class Backbone:
    """Free periodic motions of one mode, from the smallest on.

    Attributes
    ----------
    balance : HarmonicBalance
        The equations that they solve.
    frequency : (n_points,) array
        Frequency [Hz].
    damping_ratio : (n_points,) array
        Damping ratio that a decay has at this size [-].
    amplitude : (n_points,) array
        Largest displacement of any degree of freedom, relative to the base [m].
    unknowns : (n_points, n_unknowns) array
        Coefficients of the displacements [m].
    """

    balance: HarmonicBalance
    frequency: FloatArray
    damping_ratio: FloatArray
    amplitude: FloatArray
    unknowns: FloatArray

    @property
    def coefficients(self) -> ComplexArray:
        """Complex displacements, (n_points, n_dofs, n_harmonics) array [m]."""
        return np.array([self.balance.coefficients(row) for row in self.unknowns])


@final
@dataclass(frozen=True, eq=False)
class FreeCurve:
    """Free motion; the last unknowns are the rate [rad/s] and the negative damping [1/s].

    Attributes
    ----------
    balance : HarmonicBalance
        The equations, without a load.
    scale : float
        A force of the motion [N].
    phase : (n_unknowns,) array
        Unknowns whose sum is held at 0, to choose an instant for time 0.
    """

    balance: HarmonicBalance
    scale: float
    phase: FloatArray

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual (n + 1,) and derivative (n + 1, n + 2).

        `point` holds coefficients [m] and a rate [rad/s].
        """
        unknowns, omega, growth = point[:-2], point[-2], point[-1]
        balanced = self.balance.residual(unknowns, omega, growth)
        step = 1e-3 * omega
        more = self.balance.residual(unknowns, omega, growth + step)
        by_growth = (more.force - balanced.force) / step
        size = float(np.linalg.norm(unknowns)) or 1.0
        residual = np.append(balanced.force / self.scale, self.phase @ unknowns / size)
        derivative = np.zeros((residual.size, point.size))
        derivative[:-1] = np.column_stack([balanced.jacobian, balanced.by_omega, by_growth])
        derivative[:-1] /= self.scale
        derivative[-1, :-2] = self.phase / size
        return residual, derivative

    def weights(self, point: FloatArray) -> FloatArray:
        """Return one over the size of the velocity, and one over the rate for the others.

        `point` holds coefficients [m] and a rate [rad/s].
        """
        return motion_weights(self.balance, point, np.full(2, 1.0 / point[-2]))


def backbone(
    model: Model,
    amplitude: tuple[float, float],
    *,
    mode: int = 1,
    harmonics: int = 31,
) -> Backbone:
    """Return the free motion of a mode at every size.

    Parameters
    ----------
    model : Model
        What moves; its excitation is left out.
    amplitude : tuple of float
        Smallest and largest displacement relative to the base [m].
    mode : int
        Number of the mode at the largest amplitude, from 1.
    harmonics : int
        Highest harmonic.

    Returns
    -------
    Backbone
        From the smallest amplitude that has a free motion to the largest.

    Raises
    ------
    ValueError
        If the amplitudes are not above 0 and rising, or there is no such mode.
    SimulationError
        If no free motion is found at the largest amplitude.

    References
    ----------
    .. [1] M. Krack, "Nonlinear modal analysis of nonconservative systems: extension of the
       periodic motion concept", Computers and Structures 154, 59-71, 2015.
    """
    checks.positive("smallest amplitude", amplitude[0], "m")
    if not amplitude[1] > amplitude[0]:
        raise ValueError(f"amplitudes must rise, not {amplitude[0]:g} m, {amplitude[1]:g} m")
    system = system_of_model(model, 0.0)
    if not 1 <= mode <= system.n_dofs:
        raise ValueError(f"mode must be 1 to {system.n_dofs}, not {mode}")
    first, step = (1, 2) if system.odd else (0, 1)
    balance = HarmonicBalance(system, np.arange(first, harmonics + 1, step))
    shape, omega = _linear_mode(system, amplitude[1], mode - 1)
    curve, start = _start(balance, shape, omega)
    point = _at_size(curve, start)
    if point is None:
        raise SimulationError(
            f"{model.title}: no free motion of {amplitude[1]:g} m in mode {mode} was found. "
            f"Ask for a larger amplitude."
        )
    trace = follow(curve, point, -point, _until(balance, amplitude), StepSizes())
    return _backbone_of_trace(balance, trace, amplitude)


def largest_displacement(balance: HarmonicBalance, unknowns: FloatArray) -> float:
    """Return the largest displacement of any degree of freedom [m]."""
    n_samples = max(64, 8 * int(balance.harmonics[-1]))
    values = fourier.values(balance.coefficients(unknowns), balance.harmonics, n_samples)
    return float(np.max(np.abs(values)))


def _linear_mode(
    system: PeriodicSystem, amplitude: float, mode: int
) -> tuple[FloatArray, float]:
    """Return shape and rate [rad/s] of a mode with the stiffness that its amplitude feels."""
    shape, omega = np.zeros(system.n_dofs), 1.0
    stiffness = system.stiffness + sum(
        coupling.law.reference_stiffness * np.outer(coupling.direction, coupling.direction)
        for coupling in system.couplings
    )
    for _ in range(30):
        values, shapes = np.linalg.eig(np.linalg.solve(system.mass, stiffness))
        chosen = np.argsort(values.real)[mode]
        omega = float(np.sqrt(max(values.real[chosen], 1e-12)))
        shape = shapes.real[:, chosen]
        shape = amplitude * shape / shape[np.argmax(np.abs(shape))]
        stiffness = system.stiffness.copy()
        for coupling in system.couplings:
            along = float(coupling.direction @ shape)
            square = np.outer(coupling.direction, coupling.direction)
            stiffness += _felt(coupling.law, along, omega) * square
    return shape, omega


def _felt(law: AbstractLaw, amplitude: float, omega: float) -> float:
    """Return the stiffness that a harmonic motion feels [N/m]."""
    if amplitude == 0.0:
        return 0.0
    motion = HarmonicMotion(np.array([0.0, amplitude], np.complex128), np.arange(2), omega)
    return float(law.balance(motion).force[1] / amplitude)


def _start(
    balance: HarmonicBalance, shape: FloatArray, omega: float
) -> tuple[FreeCurve, FloatArray]:
    coefficients = np.zeros((shape.size, balance.harmonics.size), np.complex128)
    coefficients[:, balance.harmonics == 1] = shape[:, None]
    unknowns = balance.real(coefficients)
    phase = np.zeros(unknowns.size)
    sine = int(np.flatnonzero(balance.numbers[: balance.n_real] == 1)[1])
    phase[np.argmax(np.abs(shape)) * balance.n_real + sine] = 1.0
    scale = float(np.linalg.norm(omega**2 * (balance.system.mass @ shape)))
    return FreeCurve(balance, scale, phase), np.concatenate([unknowns, [omega, 0.0]])


def _at_size(curve: FreeCurve, guess: FloatArray) -> FloatArray | None:
    """Return the free motion near a guess with the same share of the guess."""
    point = guess
    held = np.concatenate([guess[:-2], [0.0, 0.0]])
    for _ in range(40):
        residual, derivative = curve.evaluate(point)
        matrix = np.vstack([derivative, held / (held @ held)])
        right = np.append(-residual, 1.0 - held @ point / (held @ held))
        try:
            step = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            return None
        point = point + step
        if np.linalg.norm(step * curve.weights(guess)) < 1e-11:
            return point if point[-2] > 0.0 else None
    return None


def _until(
    balance: HarmonicBalance, amplitude: tuple[float, float]
) -> Callable[[FloatArray, FloatArray], str]:
    def stop(_: FloatArray, point: FloatArray) -> str:
        size = largest_displacement(balance, point[:-2])
        inside = amplitude[0] <= size <= 3.0 * amplitude[1] and point[-2] > 0.0
        return "" if inside else "stopped"

    return stop


def _backbone_of_trace(
    balance: HarmonicBalance, trace: Trace, amplitude: tuple[float, float]
) -> Backbone:
    sizes = np.array([largest_displacement(balance, point[:-2]) for point in trace.points])
    inside = (sizes >= amplitude[0]) & (trace.points[:, -2] > 0.0)
    points = trace.points[inside][::-1]
    omega, growth = points[:, -2], points[:, -1]
    return Backbone(
        balance=balance,
        frequency=omega / (2.0 * np.pi),
        damping_ratio=growth / (2.0 * omega),
        amplitude=sizes[inside][::-1],
        unknowns=points[:, :-2],
    )
