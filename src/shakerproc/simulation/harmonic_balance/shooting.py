"""Periodic motion by shooting: the state that comes back after a period of exact stepping.

Harmonics resolve the corner that dry friction puts into the velocity slowly; the stepper
locates every stop and start. Shooting therefore makes harmonic balance's solutions exact, and
gives their multipliers, for models with dry friction.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.branch import NEUTRAL, Branch, multipliers
from shakerproc.simulation.inputs import Input, prepare
from shakerproc.simulation.response import SimulatedResponse, simulate

CORRECTION = 1e-12
"""Size of the last correction of a state over that of the motion [-]."""

PER_PERIOD = 32
"""Samples a period; the input between them is a polynomial of degree 9."""

NEAR = 0.2
"""How far shooting may go from harmonic balance, over the size of the motion [-]."""


@final
@dataclass(frozen=True, eq=False)
class Orbit:
    """A motion that repeats itself.

    Attributes
    ----------
    state : (2 n_dofs,) array
        Displacements [m] and velocities [m/s] relative to the base at time 0.
    monodromy : (2 n_dofs, 2 n_dofs) array
        What one round makes of a small disturbance.
    motion : (n_dofs, n_samples) array
        Displacements over one round [m].
    """

    state: FloatArray
    monodromy: FloatArray
    motion: FloatArray


def periodic_orbit(
    model: Model,
    level: float,
    frequency: float,
    guess: FloatArray,
    *,
    order: int = 1,
    n_samples: int = PER_PERIOD,
) -> Orbit | None:
    """Return the orbit near a guess, by Newton's method; None where there is none.

    Parameters
    ----------
    model : Model
        What is shaken, by a cosine; its laws have no memory.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    frequency : float
        Frequency of the excitation [Hz].
    guess : (2 n_dofs,) array
        Displacements and velocities at time 0 [m, m/s].
    order : int
        Periods of the excitation in one round.
    n_samples : int
        Samples of the motion in one period of the excitation, at least 32.
    """
    given = _input_of_round(level, frequency, order, max(n_samples, PER_PERIOD))
    state = np.array(guess, np.float64)
    omega = 2.0 * np.pi * frequency
    for _ in range(20):
        try:
            response = _round_from_state(model, given, state)
            sizes = _sizes(response, omega)
            monodromy = _differences(model, given, state, sizes)
            step = np.linalg.solve(np.eye(state.size) - monodromy, _end(response) - state)
        except (SimulationError, np.linalg.LinAlgError):
            return None
        correction = float(np.max(np.abs(step / sizes)))
        if not correction < 1.0:
            return None
        state = state + step
        if correction < CORRECTION:
            last = _round_from_state(model, given, state)
            return Orbit(state, monodromy, last.motion[: state.size // 2, :-1])
    return None


def one_round(
    model: Model,
    level: float,
    frequency: float,
    state: FloatArray,
    *,
    order: int = 1,
    n_samples: int = PER_PERIOD,
) -> SimulatedResponse:
    """Return one round of a motion from a state, by the stepper that suits the model.

    Parameters
    ----------
    model : Model
        What is shaken, by a cosine.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    frequency : float
        Frequency of the excitation [Hz].
    state : (2 n_dofs,) array
        Displacements and velocities at time 0 [m, m/s].
    order : int
        Periods of the excitation in one round.
    n_samples : int
        Samples of the motion in one period of the excitation.
    """
    given = _input_of_round(level, frequency, order, n_samples)
    return simulate(model, given, start=_start(model, state), growth=False)


def _input_of_round(level: float, frequency: float, order: int, n_samples: int) -> Input:
    omega = 2.0 * np.pi * frequency
    return prepare(
        lambda time: level * np.cos(omega * time),
        n_samples * frequency,
        duration=order / frequency,
    )


def _round_from_state(model: Model, given: Input, state: FloatArray) -> SimulatedResponse:
    """Return one round from a state."""
    return simulate(model, given, start=_start(model, state), growth=False, solver="taylor")


def _start(model: Model, state: FloatArray) -> dict[str, tuple[float, float]]:
    """Return a state as displacement and velocity of every coordinate."""
    names, n = coordinates_of(model).names, state.size // 2
    return {name: (float(state[i]), float(state[n + i])) for i, name in enumerate(names)}


def _end(response: SimulatedResponse) -> FloatArray:
    end: FloatArray = response.motion[: len(response.motion) - len(response.states), -1]
    return end


def _sizes(response: SimulatedResponse, omega: float) -> FloatArray:
    """Return how large each displacement and velocity is."""
    moving = (len(response.motion) - len(response.states)) // 2
    amplitude = np.max(np.abs(response.motion[:moving]), axis=1)
    amplitude = np.maximum(amplitude, 1e-6 * np.max(amplitude))
    return np.concatenate([amplitude, omega * amplitude])


def _differences(
    model: Model, given: Input, state: FloatArray, sizes: FloatArray
) -> FloatArray:
    """Return the derivative of the state after a round by the state before, by differences."""
    columns = []
    for i in range(state.size):
        change = np.zeros(state.size)
        change[i] = 1e-6 * sizes[i]
        ends = [
            _end(_round_from_state(model, given, state + sign * change)) for sign in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * change[i]))
    return np.array(columns).T


def polished(model: Model, level: float, branch: Branch) -> Branch:
    """Return a branch with every motion made exact and with its multipliers.

    A point whose orbit is not found near stays as harmonic balance has it.

    Parameters
    ----------
    model : Model
        What is shaken; its laws have no memory.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    branch : Branch
        Its motions by harmonic balance.
    """
    unknowns, floquet_multipliers = branch.unknowns.copy(), branch.multipliers.copy()
    stable = branch.stable.copy()
    for i in range(branch.frequency.size):
        orbit = _orbit(model, level, branch, i)
        if orbit is None:
            continue
        coefficients = fourier.coefficients_of_values(orbit.motion, branch.balance.harmonics)
        exact = branch.balance.real(coefficients)
        if np.linalg.norm(exact - unknowns[i]) < NEAR * np.linalg.norm(exact):
            unknowns[i] = exact
            floquet_multipliers[i] = multipliers(orbit.monodromy)
            stable[i] = bool(np.abs(floquet_multipliers[i, 0]) <= 1.0 + NEUTRAL)
    return replace(branch, unknowns=unknowns, multipliers=floquet_multipliers, stable=stable)


def _orbit(model: Model, level: float, branch: Branch, point: int) -> Orbit | None:
    balance = branch.balance
    return periodic_orbit(
        model,
        level,
        float(branch.frequency[point]),
        state_of(branch, point),
        order=balance.order,
        n_samples=4 * int(balance.harmonics[-1]) // balance.order + 4,
    )


def state_of(branch: Branch, point: int) -> FloatArray:
    """Return displacements and velocities at time 0, (2 n_dofs,) array [m], [m/s].

    Parameters
    ----------
    branch : Branch
        Motions by harmonic balance.
    point : int
        Which of them.
    """
    balance = branch.balance
    omega = 2.0 * np.pi * branch.frequency[point] / balance.order
    start: list[FloatArray] = [
        np.array(fourier.value(row, balance.harmonics, 0.0)[:2])
        for row in balance.coefficients(branch.unknowns[point])
    ]
    states = np.array(start)
    return np.concatenate([states[:, 0], omega * states[:, 1]])
