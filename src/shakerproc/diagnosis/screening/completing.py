"""Motion that no sensor tells, from the forces that a candidate lets act.

Below the lowest resonance accelerations integrated twice tell nothing, and of a mass without a
sensor nothing is told at all: there the motion is that of the linear model, to which the
forces that it lacks must be added.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data.motion import TRUSTED_FROM, lowest_frequency
from shakerproc.diagnosis.screening.motion import Motions, moved_places
from shakerproc.diagnosis.screening.stretches import Stretch
from shakerproc.diagnosis.screening.transfer import LinearPart
from shakerproc.models import BASE
from shakerproc.simulation import TOLD_APART

_NEGLIGIBLE: Final = 1e-4
"""Share of the motion that is not worth completing [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Lacking:
    """Forces that the model lacks along a stretch.

    Attributes
    ----------
    stretch : Stretch
        Where.
    forces : (n_coordinates, n) array
        What acts on the coordinates [N].
    direction : (n_coordinates,) array
        How unit coordinates stretch the joint that they change with [-].
    stiffness : float
        How much the force of that joint rises with a slow displacement [N/m].
    """

    stretch: Stretch
    forces: FloatArray
    direction: FloatArray
    stiffness: float


def untold(linear: LinearPart, frequency: FloatArray) -> FloatArray:
    r"""Return the share of the motion that the model tells, (n, n, n_frequencies) array [-].

    .. math:: I - L \, \mathrm{diag}(t) \, S

    with a row of :math:`S` for each place that has a sensor, whose motion is trusted to a share
    :math:`t`, and :math:`L` the pseudoinverse of :math:`S`.
    """
    lowest = TRUSTED_FROM * lowest_frequency(linear.system)
    integrated = 1.0 / (1.0 + (lowest / frequency) ** 8)
    places = {
        s.at: np.ones_like(frequency) if s.measures.endswith("displacement") else integrated
        for s in linear.model.sensors.values()
        if s.at != BASE
    }
    n = len(linear.system.names)
    sees = np.reshape([linear.system.places[at] for at in places], (-1, n))
    led = np.linalg.pinv(sees, rcond=TOLD_APART)
    trusted = np.reshape(list(places.values()), (-1, frequency.size))
    told = np.einsum("is,sf,sj->ijf", led, trusted, sees, optimize=True)
    return np.asarray(np.eye(n)[..., np.newaxis] - told)


def completed(
    linear: LinearPart,
    motions: Motions,
    reference: Motions,
    lacking: Sequence[Lacking],
    sample_rate: float,
    *,
    share: float,
) -> Motions:
    """Return motions nearer to those that forces, which change with them, complete.

    One step of Newton's method: what the forces add to the motion less what was added before,
    over how stiff the forces make the model.

    Parameters
    ----------
    linear : LinearPart
        The linear part of the model.
    motions, reference : Motions
        The motion as it was last, and that with nothing added.
    lacking : sequence of Lacking
        Forces that the model lacks.
    sample_rate : float
        Samples per second [Hz].
    share : float
        Share of the step that is taken [-].
    """
    relative = [dict(own) for own in motions.relative]
    for one in lacking:
        now, first = motions.relative[one.stretch.test], reference.relative[one.stretch.test]
        part = slice(one.stretch.start, one.stretch.stop)
        names = linear.system.names[: linear.model.n_coordinates]
        before = np.array([
            now[name].displacement[part] - first[name].displacement[part] for name in names
        ])
        displacement = np.array([now[name].displacement for name in names])
        velocity = np.array([now[name].velocity for name in names])
        change = _change(linear, one, before, sample_rate)
        displacement[:, part] += share * change[:, 0]
        velocity[:, part] += share * change[:, 1]
        relative[one.stretch.test] |= moved_places(linear.model, displacement, velocity)
    return Motions(tuple(relative), motions.base)


def _change(
    linear: LinearPart, lacking: Lacking, before: FloatArray, sample_rate: float
) -> FloatArray:
    """Return the changes of displacement and velocity, (n_coordinates, 2, n) array."""
    size, n = lacking.forces.shape[1], len(before)
    length = scipy.fft.next_fast_len(size + size // 8, real=True)
    frequency = scipy.fft.rfftfreq(length, 1.0 / sample_rate)
    frequency[0] = 0.1 * frequency[1]
    share = untold(linear, frequency)
    untrusted = np.any(np.abs(share) > _NEGLIGIBLE, axis=(0, 1))
    used = int(np.max(np.nonzero(untrusted)[0], initial=0)) + 1
    loads = np.column_stack([np.eye(len(share)), lacking.direction])
    yields = linear.compliance(frequency[:used], loads)
    moved = np.einsum("ikf,fkj->jif", share[..., :used], yields, optimize=True)
    spectra = scipy.fft.rfft(lacking.forces, length)[:, :used]
    wanted = np.einsum("jif,jf->if", moved[:-1], spectra)
    wanted[:n] -= scipy.fft.rfft(before, length)[:, :used]
    across = lacking.direction @ wanted
    yielding = 1.0 + lacking.stiffness * (lacking.direction @ moved[-1])
    wanted -= lacking.stiffness * across / yielding * moved[-1]
    both = np.stack([wanted, 2j * np.pi * frequency[:used] * wanted], axis=1)[:n]
    return np.asarray(scipy.fft.irfft(both, length)[..., :size])
