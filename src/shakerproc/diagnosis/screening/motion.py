"""Motion across joints, and of places, along every test that is screened."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest, RelativeMotion
from shakerproc.diagnosis.data.motion import coordinate_motions
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of


@final
@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """How the places of a model move in tests.

    Attributes
    ----------
    relative : tuple of mapping
        Motion of every place, and of every mode of a structure, against the base, by its name,
        in each test.
    base : tuple of RelativeMotion
        Of the base itself; at rest where a force drives.
    """

    relative: tuple[Mapping[str, RelativeMotion], ...]
    base: tuple[RelativeMotion, ...]

    def across(self, joint: Joint, *, absolute: bool = False) -> tuple[RelativeMotion, ...]:
        """Return, for each test, the motion across a joint or that of its second place."""
        first, second = joint
        return tuple(
            difference(own[second], own[first], base if absolute else None)
            for own, base in zip(self.relative, self.base, strict=True)
        )


def difference(
    second: RelativeMotion, first: RelativeMotion, base: RelativeMotion | None
) -> RelativeMotion:
    """Return the motion of a place less that of another, or on top of that of the base."""
    if base is not None:
        return RelativeMotion(
            second.displacement + base.displacement, second.velocity + base.velocity
        )
    return RelativeMotion(
        second.displacement - first.displacement, second.velocity - first.velocity
    )


def motions_of(model: Model, tests: Sequence[PreparedTest]) -> Motions:
    """Return the motion of every place in tests."""
    relative = []
    for test in tests:
        z, v = np.split(coordinate_motions(model, test), 2)
        still = np.zeros(test.n_samples)
        relative.append({BASE: RelativeMotion(still, still), **moved_places(model, z, v)})
    return Motions(tuple(relative), tuple(_base(model, test) for test in tests))


def moved_places(model: Model, z: FloatArray, v: FloatArray) -> dict[str, RelativeMotion]:
    """Return the motion of each coordinate and place.

    Parameters
    ----------
    model : Model
        The model.
    z, v : (n_coordinates, n) array
        Displacements [m] and velocities [m/s] of masses and modes of structures.
    """
    n, alone = model.n_coordinates, coordinates_of(model, ())
    own = zip(alone.names[:n], z, v, strict=True)
    points = ((point, alone.at(point)[:n]) for point in model.points)
    return {name: RelativeMotion(*both) for name, *both in own} | {
        point: RelativeMotion(row @ z, row @ v) for point, row in points
    }


def _base(model: Model, test: PreparedTest) -> RelativeMotion:
    """Return the motion of the base, its acceleration integrated above 1 % of the band."""
    if not model.excitation.moves_base:
        still = np.zeros(test.n_samples)
        return RelativeMotion(still, still)
    length = scipy.fft.next_fast_len(test.n_samples + round(test.sample_rate), real=True)
    frequency = scipy.fft.rfftfreq(length, 1.0 / test.sample_rate)
    frequency[0] = frequency[1]
    omega = 2.0 * np.pi * frequency
    passed = 1.0 / (1.0 + (0.5 * test.band[0] / frequency) ** 8)
    moved = -scipy.fft.rfft(test.input, length) / omega**2 * passed
    both = [
        scipy.fft.irfft(part, length)[: test.n_samples] for part in (moved, 1j * omega * moved)
    ]
    return RelativeMotion(*both)
