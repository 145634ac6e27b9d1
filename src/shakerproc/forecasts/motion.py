"""The motion of a model in a test, and the laws of its joints by which two levels differ."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison import at_samples
from shakerproc.comparison.equilibrium import pairs_of
from shakerproc.comparison.free_run_error import in_band
from shakerproc.comparison.hidden_joints import JointHistory, joint_history, probed
from shakerproc.data import FloatArray
from shakerproc.models import AbstractMemorylessEffect, Conditions, Element, Model
from shakerproc.models.conditions import NO_CONDITIONS
from shakerproc.models.coordinates import resolved
from shakerproc.models.laws import Law
from shakerproc.numerals import numeral
from shakerproc.simulation import Input, Runs, free_runs

What: TypeAlias = Literal[
    "rms", "peak", "peak_frequency_hz", "displacement", "force", "velocity", "acceleration"
]
"""What a quantity is."""

_OF_TABLE: Final[tuple[tuple[What, str], ...]] = (
    ("acceleration", "m/s^2"), ("velocity", "m/s"), ("displacement", "m"),
)  # fmt: skip

CHANGED: Final = 0.02
"""Change of a joint's stiffness or damping that is told [-]: a resonance moves by half of it,
1 %."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestMotion:
    """Motion of a model in one test.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    drive : (n,) array
        What drove it [m/s^2 or N].
    responses : mapping of str to (n,) array
        What each sensor records within the band [unit of the sensor].
    joints : mapping of (str, str) to JointHistory
        TestMotion and force in each joint.
    table : tuple of (What, (n,) array, str)
        Acceleration, velocity and displacement of the base, with their units; none where a
        force drives, or nobody asked.
    """

    sample_rate: float
    drive: FloatArray
    responses: Mapping[str, FloatArray]
    joints: Mapping[tuple[str, str], JointHistory]
    table: tuple[tuple[What, FloatArray, str], ...]


def motion_of(
    model: Model,
    given: Input,
    drive: FloatArray,
    band: tuple[float, float],
    gains: FloatArray,
    *,
    conditions: Conditions = NO_CONDITIONS,
    table: bool = False,
) -> TestMotion | None:
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
    conditions : Conditions
        Those of the test; the motion has every joint of the model, under whichever.
    table : bool
        Whether the motion of the table is wanted, too.
    """
    pairs, model = pairs_of(model), model.under(conditions)
    watched = probed(model, pairs)
    whole = np.array([(0, 0, given.n_samples)])
    response = free_runs(watched, Runs((given,), whole))
    if response.failed[0]:
        return None
    rows = dict(zip(watched.sensors, at_samples(watched, response.outputs[0]), strict=True))
    rate = given.sample_rate
    responses = in_band(np.array([rows[name] for name in model.sensors]), rate, band)
    return TestMotion(
        rate,
        drive,
        dict(zip(model.sensors, gains[:, None] * responses, strict=True)),
        {pair: joint_history(model, pair, rows, rate) for pair in pairs},
        _table(model, drive, rate, band) if table else (),
    )


def _table(
    model: Model, drive: FloatArray, rate: float, band: tuple[float, float]
) -> tuple[tuple[What, FloatArray, str], ...]:
    """Return acceleration, velocity and displacement of the base within a band."""
    if not model.excitation.moves_base:
        return ()
    length = scipy.fft.next_fast_len(2 * drive.size, real=True)
    omega = 2.0 * np.pi * scipy.fft.rfftfreq(length, 1.0 / rate)
    spectrum = scipy.fft.rfft(in_band(drive, rate, band), length)
    rows: list[tuple[What, FloatArray, str]] = []
    for order, (what, unit) in enumerate(_OF_TABLE):
        divisor = np.maximum(omega, omega[1]) ** order
        samples = scipy.fft.irfft(spectrum / (1j**order * divisor), length)[: drive.size]
        rows.append((what, samples, model.unit_of(unit)))
    return tuple(rows)


@final
@dataclass(frozen=True, slots=True)
class JointLaw:
    r"""Linear law nearest to that of a joint over one motion, by least squares.

    .. math:: F \approx k z + c \dot z

    Attributes
    ----------
    stiffness, damping : float
        :math:`k` [N/m] and :math:`c` [N s/m].
    """

    stiffness: float
    damping: float


def law_of(joint: JointHistory) -> JointLaw:
    """Return the linear law nearest to that of a joint over its motion."""
    columns = np.stack([joint.displacement, joint.velocity])
    gram = columns @ columns.T
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    weights = np.linalg.lstsq(gram / np.outer(scale, scale), columns @ joint.force / scale)[0]
    stiffness, damping = weights / scale
    return JointLaw(float(stiffness), float(damping))


def reasons(model: Model, before: TestMotion, after: TestMotion) -> list[str]:
    """Return how joints differ from the highest level that was run, a clause each.

    Parameters
    ----------
    model : Model
        The model.
    before, after : TestMotion
        At the highest level that was run, and at the one that is forecast.
    """
    texts = []
    for pair, there in after.joints.items():
        here = before.joints[pair]
        joint_elements = [one for one in resolved(model) if set(one.between) == set(pair)]
        sentences = _of_laws(joint_elements, pair, here, there)
        was, now = law_of(here), law_of(there)
        moved = []
        for name, one, other in (
            ("stiffness", was.stiffness, now.stiffness), ("damping", was.damping, now.damping)
        ):  # fmt: skip
            if abs(other - one) > CHANGED * abs(one):
                moved.append(f"{name} {(other - one) / abs(one):+.0%}")
        if sentences or moved:
            clauses = [*sentences, *([f"effective {' and '.join(moved)}"] if moved else [])]
            texts.append(f"joint {'-'.join(pair)}: {', '.join(clauses)}")
    return texts


def _of_laws(
    elements: Sequence[Element], pair: tuple[str, str], here: JointHistory, there: JointHistory
) -> list[str]:
    """Return how the laws of a joint differ, by their kinds."""
    texts = []
    for element in elements:
        effect, turn = element.effect, 1.0 if element.between == pair else -1.0
        name = effect.kind.replace("_", " ")
        laws = {row.law for row in effect.rows()}
        if isinstance(effect, AbstractMemorylessEffect) and Law.FRICTION not in laws:
            walls = [s.at for s in effect.switches() if s.variable == "displacement" and s.at]
            was, now = (_beyond(walls, turn * one.displacement) for one in (here, there))
            if walls and now > 0.0 and now - was > CHANGED * now:
                closed = "closes" if was == 0.0 else f"is in contact {numeral(100 * was, 2)} % "
                rest = (
                    ""
                    if was == 0.0
                    else f"of the time there and {numeral(100 * now, 2)} % here"
                )
                texts.append(f"the {name} {closed}{rest}")
        elif Law.FRICTION in laws or not isinstance(effect, AbstractMemorylessEffect):
            texts.append(f"the {name} slips further")
    return texts


def _beyond(walls: Sequence[float], displacement: FloatArray) -> float:
    """Return the share of time beyond the nearest walls [-]."""
    above = min([wall for wall in walls if wall > 0.0], default=np.inf)
    below = max([wall for wall in walls if wall < 0.0], default=-np.inf)
    return float(np.mean((displacement > above) | (displacement < below)))
