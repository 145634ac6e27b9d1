"""Motion of what no sensor tells: modes that the measured motion of the masses drives."""

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.of_tests import as_free, offsets_in
from shakerproc.diagnosis.estimation.resting_places import may_shift, resting_places
from shakerproc.diagnosis.estimation.starts_by_equation import by_equation
from shakerproc.models import Model
from shakerproc.simulation import largest_states
from shakerproc.simulation.assembly import System, assemble


def completed(
    data: DataSet, model: Model, table: NDArray[np.int64], of_tests: FloatArray
) -> FloatArray:
    """Return all motions where windows begin, (n_windows, n_motions) array.

    Displacements and velocities of masses, attached and further modes, then the states of the
    laws, which begin with no memory. What the mean of a displacement is, the model says.

    Parameters
    ----------
    data : DataSet
        The tests.
    model : Model
        Says which modes and laws there are.
    table : (n_windows, 3) array of int
        Test, first sample, and number of samples.
    of_tests : (n, n_tests) array
        What each test has of its own: offsets of its sensors are taken away [-].
    """
    n_masses, hidden = model.n_coordinates, hidden_motions(data, model)
    off = data.offsets.moved(offsets_in(data, as_free(data, of_tests)))
    masses = np.zeros((2 * n_masses, len(table)))
    modes = np.zeros((len(hidden[0]), len(table)))
    for i, own in enumerate(data.motions):
        here = table[:, 0] == i
        masses[:, here] = own[:, table[here, 1]]
        masses[:n_masses, here] -= off[i][:, None]
        modes[:, here] = hidden[i][:, table[here, 1]]
    places = [own[0] for own in resting_places(data, model, table)]
    masses[:n_masses] += np.reshape(places, (-1, n_masses)).T
    states = np.zeros((len(table), len(largest_states(model))))
    return np.hstack([_joined(masses, modes).T, states])


def elsewhere(
    data: DataSet, model: Model, table: NDArray[np.int64], starts: FloatArray
) -> list[FloatArray]:
    """Return starts of windows where the mean of a displacement was not measured.

    Around the other places at which the masses may rest, and where the forces of the model
    balance the inertia; of tests too short for that mean as well, whatever the laws.

    Parameters
    ----------
    data, model, table
        As for `completed`.
    starts : (n_windows, n_motions) array
        What that returned.
    """
    if not (may_shift(data, model) or data.offsets.hide_places):
        return []
    places = resting_places(data, model, table)
    out = []
    for choice in range(1, max(map(len, places), default=1)):
        there = starts.copy()
        for row, own in zip(there, places, strict=True):
            if choice < len(own):
                row[: model.n_coordinates] += own[choice] - own[0]
        out.append(there)
    told = by_equation(data, model, table, starts)
    return out if told is None else [*out, told]


def sizes(data: DataSet, model: Model) -> FloatArray:
    """Return the scale of each number of a start, (n_motions,) array.

    The largest of the motions in any test [m], [m/s]: what decays begins far above its rms.
    And the size of each state [its unit].
    """
    most = np.max([np.max(np.abs(own), axis=1) for own in hidden_motions(data, model)], axis=0)
    return np.concatenate([_joined(data.motion_sizes, most), largest_states(model)[:, 0]])


def _joined(masses: FloatArray, modes: FloatArray) -> FloatArray:
    """Return displacements, then velocities, of masses and modes together."""
    x, v = np.split(masses, 2)
    hidden_x, hidden_v = np.split(modes, 2)
    return np.concatenate([x, hidden_x, v, hidden_v])


def hidden_motions(data: DataSet, model: Model) -> tuple[FloatArray, ...]:
    """Return displacements [m], then velocities [m/s], of attached and further modes.

    They are linear in the motion of the masses and the input, both measured, and begin at rest
    with the test; after that nothing is to be known of a start.

    Parameters
    ----------
    data : DataSet
        The tests.
    model : Model
        Says which modes there are.

    Returns
    -------
    tuple of (2 n_modes, n) array
        Of each test.
    """
    system = assemble(model)
    if len(system.names) == model.n_coordinates:
        return tuple(np.zeros((0, motion.shape[1])) for motion in data.motions)
    return tuple(
        _driven(system, np.vstack([motion, test.input]), 1.0 / test.sample_rate)
        for motion, test in zip(data.motions, data.tests, strict=True)
    )


def _driven(system: System, drive: FloatArray, step: float) -> FloatArray:
    """Return the motion of the modes from rest, (2 n_modes, n) array.

    Parameters
    ----------
    system : System
        The model, assembled.
    drive : (2 n_masses + 1, n) array
        Displacements and velocities of the masses, and the input; lines between samples.
    step : float
        Time between them [s].
    """
    n, matrix = len(system.names), system.machine.matrix
    n_masses = (len(drive) - 1) // 2
    modes = n - n_masses
    own = np.r_[n_masses:n, n + n_masses : 2 * n]
    given = np.r_[0:n_masses, n : n + n_masses, 2 * n]
    rates = np.zeros((2 * modes, 2 * modes))
    rates[:modes, modes:] = np.eye(modes)
    rates[modes:] = matrix[n_masses:n][:, own]
    pushed = np.zeros((2 * modes, len(drive)))
    pushed[modes:] = matrix[n_masses:n][:, given]
    poles, shapes = np.linalg.eig(rates)
    one = poles.imag >= 0.0  # of each pair, whose other is its conjugate
    times = np.where(poles[one].imag > 0.0, 2.0, 1.0)
    forced = np.linalg.solve(shapes, pushed.astype(complex))[one] @ drive
    each = [_first_order(p, row, step) for p, row in zip(poles[one], forced, strict=True)]
    return np.asarray(((shapes[:, one] * times) @ np.array(each)).real)


def _first_order(pole: complex, drive: ComplexArray, step: float) -> ComplexArray:
    """Return the solution from rest of q' = pole q + drive, exact for lines between samples."""
    turn = pole * step
    passed = np.exp(turn)
    later = step * (passed - 1.0 - turn) / turn**2
    earlier = step * (passed * (turn - 1.0) + 1.0) / turn**2
    return np.asarray(scipy.signal.lfilter([later, earlier], [1.0, -passed], drive))
