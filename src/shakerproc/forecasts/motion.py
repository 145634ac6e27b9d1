"""The motion of a model in a test: responses, joints and the table that shakes it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison import at_samples
from shakerproc.comparison.equilibrium import pairs_of
from shakerproc.comparison.free_run_error import in_band
from shakerproc.comparison.joints import law_along
from shakerproc.data import FloatArray
from shakerproc.models import BASE, Model, Sensor
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.parallel_elements import resolved
from shakerproc.simulation import Input, Runs, free_runs

What: TypeAlias = Literal[
    "rms", "peak", "peak_frequency_hz", "displacement", "force", "velocity", "acceleration"
]
"""What a quantity is."""

_PLACE: Final = "displacement of "
_SPEED: Final = "velocity of "
_OF_TABLE: Final[tuple[tuple[What, str], ...]] = (
    ("acceleration", "m/s^2"), ("velocity", "m/s"), ("displacement", "m"),
)  # fmt: skip


@final
@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Displacement of the second place against the first [m], velocity [m/s] and force [N]."""

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Motion of a model in one test.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    drive : (n,) array
        What drove it [m/s^2 or N].
    responses : mapping of str to (n,) array
        What each sensor records within the band [unit of the sensor].
    joints : mapping of (str, str) to JointMotion
        Motion and force in each joint.
    table : tuple of (What, (n,) array, str)
        Acceleration, velocity and displacement of the base, with their units; none where a
        force drives, or nobody asked.
    """

    sample_rate: float
    drive: FloatArray
    responses: Mapping[str, FloatArray]
    joints: Mapping[tuple[str, str], JointMotion]
    table: tuple[tuple[What, FloatArray, str], ...]


def motion_of(
    model: Model,
    given: Input,
    drive: FloatArray,
    band: tuple[float, float],
    gains: FloatArray,
    *,
    table: bool = False,
) -> Motion | None:
    """Return the motion of a model from rest; None where it runs away.

    Parameters
    ----------
    model : Model
        What is shaken.
    given : Input
        What drives it, prepared.
    drive : (n,) array
        The same as samples [m/s^2 or N].
    band : (float, float)
        Within which responses are recorded [Hz].
    gains : (n_sensors,) array
        What the sensors record over what they should [-].
    table : bool
        Whether the motion of the table is wanted, too.
    """
    probed = _probed(model)
    whole = np.array([(0, 0, given.n_samples)])
    found = free_runs(probed, Runs((given,), whole))
    if found.failed[0]:
        return None
    rows = dict(zip(probed.sensors, at_samples(probed, found.outputs[0]), strict=True))
    rate = given.sample_rate
    responses = in_band(np.array([rows[name] for name in model.sensors]), rate, band)
    return Motion(
        rate,
        drive,
        dict(zip(model.sensors, gains[:, None] * responses, strict=True)),
        {pair: _joint(model, pair, rows, rate) for pair in pairs_of(model)},
        _table(model, drive, rate, band) if table else (),
    )


def _probed(model: Model) -> Model:
    """Return a model with sensors of the motion of every joint's places against the base."""
    sensors = dict(model.sensors)
    for place in {place for pair in pairs_of(model) for place in pair} - {BASE}:
        sensors[_PLACE + place] = Sensor(place, "relative displacement")
        sensors[_SPEED + place] = Sensor(place, "relative velocity")
    return replace(model, sensors=sensors)


def _joint(
    model: Model, pair: tuple[str, str], rows: Mapping[str, FloatArray], rate: float
) -> JointMotion:
    """Return the motion of a joint, and the force of all laws between its places."""
    still = np.zeros_like(next(iter(rows.values())))
    displacement, velocity = (
        (still if pair[1] == BASE else rows[kind + pair[1]])
        - (still if pair[0] == BASE else rows[kind + pair[0]])
        for kind in (_PLACE, _SPEED)
    )
    force = np.zeros_like(displacement)
    for element in resolved(model):
        same = set(element.between) == set(pair)
        if same and not isinstance(element.effect, AttachedMode):
            force = force + law_along(element, pair, displacement, velocity, rate)
    return JointMotion(displacement, velocity, force)


def _table(
    model: Model, drive: FloatArray, rate: float, band: tuple[float, float]
) -> tuple[tuple[What, FloatArray, str], ...]:
    """Return acceleration, velocity and displacement of the base within a band."""
    if not model.excitation.moves_base:
        return ()
    length = scipy.fft.next_fast_len(2 * drive.size, real=True)
    omega = 2.0 * np.pi * scipy.fft.rfftfreq(length, 1.0 / rate)
    spectrum = scipy.fft.rfft(in_band(drive, rate, band), length)
    found: list[tuple[What, FloatArray, str]] = []
    for order, (what, unit) in enumerate(_OF_TABLE):
        divisor = np.maximum(omega, omega[1]) ** order
        samples = scipy.fft.irfft(spectrum / (1j**order * divisor), length)[: drive.size]
        found.append((what, samples, model.unit_of(unit)))
    return tuple(found)
