"""Bodies that no spring holds: the constant of the force that drives them."""

import numpy as np

from shakerproc.comparison.joints import law_along
from shakerproc.comparison.measured import Measured
from shakerproc.data import FloatArray
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import resolved
from shakerproc.simulation.assembly import assemble

_ENDS = 8
"""Samples that tell the velocity at either end [-]."""


def mean_force(model: Model, measured: Measured) -> float:
    r"""Return the mean of the force with which a model moves as was measured [N].

    .. math:: \bar F = \sum_i m_i \frac{v_i(T) - v_i(0)}{T}
        + \sum_j \overline{F_j(z_j, \dot z_j)}

    over masses and the joints to the base, along the measured displacements. A force sensor or
    an amplifier does not tell its constant, and masses that no spring holds drift with it. It
    is 0 where springs hold all masses, one has no sensor of displacement, or structures move.

    `measured` is without the means of its channels.
    """
    moved = _displacements(model, measured)
    if not moved or model.structures or model.excitation.role != "force" or is_held(model):
        return 0.0
    rate = measured.sample_rate
    velocities = {mass: np.gradient(row) * rate for mass, row in moved.items()}
    duration = (measured.stop - measured.start) / rate
    found = 0.0
    for mass, velocity in velocities.items():
        gained = float(velocity[-_ENDS:].mean() - velocity[:_ENDS].mean())
        found += model.masses[mass] * gained / duration
    for element in resolved(model):
        if BASE not in element.between:
            continue
        (mass,) = set(element.between) - {BASE}
        force = law_along(element, (BASE, mass), moved[mass], velocities[mass], rate)
        found += float(force.mean())
    return found


def is_held(model: Model) -> bool:
    """Return whether springs hold every mass."""
    n = model.n_coordinates
    return bool(np.linalg.matrix_rank(assemble(model).machine.matrix[:n, :n]) == n)


def _displacements(model: Model, measured: Measured) -> dict[str, FloatArray]:
    """Return the measured displacements [m] by mass; none where a mass has no such sensor."""
    part = slice(measured.start, measured.stop)
    found = {
        model.sensors[name].at: row[part]
        for name, row in zip(measured.sensors, measured.responses, strict=True)
        if "displacement" in model.sensors[name].measures
    }
    return found if found.keys() == model.masses.keys() else {}
