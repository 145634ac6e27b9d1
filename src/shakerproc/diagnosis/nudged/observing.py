"""The motion of a model that sensors see, and the time in which it forgets a start."""

from collections.abc import Mapping

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.simulation.free_runs import led_by

Seen = tuple[tuple[str, bool], ...]
"""Places whose motion is measured, and whether where they are is, too."""


def seen_of(model: Model) -> Seen:
    """Return which places sensors tell the velocity of, and of which the displacement."""
    placed: dict[str, bool] = {}
    for sensor in model.sensors.values():
        if sensor.at != BASE and sensor.measures != "force":
            place = sensor.measures.endswith("displacement")
            placed[sensor.at] = placed.get(sensor.at, False) or place
    return tuple((at, placed[at]) for at in model.moving if at in placed)


def seen_by(seen: Seen, places: Mapping[str, FloatArray]) -> FloatArray:
    """Return the outputs of sensors by unit displacements, then unit velocities."""
    still = np.zeros_like(next(iter(places.values())))
    velocities = [np.concatenate([still, places[at]]) for at, _ in seen]
    displacements = [np.concatenate([places[at], still]) for at, placed in seen if placed]
    return np.reshape([*velocities, *displacements], (-1, 2 * still.size))


def slowest_decay(model: Model, rate: float) -> float:
    r"""Return the decay rate of what is forgotten last by a model that is held [1/s].

    .. math:: \min_r -\operatorname{Re} \lambda_r (A - \text{rate} \, L S)

    over what turns, with the linear part of the model, :math:`A`. A mass with a sensor forgets
    at half the rate; a mode that no sensor sees by its own damping alone.

    Parameters
    ----------
    model : Model
        What is held.
    rate : float
        Nudging rate [1/s].
    """
    linear = coordinates_of(model)
    n, by_mass = linear.mass.size, 1.0 / linear.mass[:, None]
    sees = seen_by(seen_of(model), linear.places)
    held = rate * (led_by(sees, linear.mass) @ sees)
    state = np.block([
        [np.zeros((n, n)), np.eye(n)],
        [-by_mass * linear.stiffness, -by_mass * linear.damping],
    ])
    poles = np.linalg.eigvals(state - held)
    turning = -poles.real[poles.imag > 0.0]
    return float(min(0.5 * rate, np.min(turning, initial=np.inf)))
