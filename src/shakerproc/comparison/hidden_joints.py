"""Motion and force of joints that recordings do not tell, as the modes of a model tell them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.comparison import TestComparison
from shakerproc.comparison.joints import law_along
from shakerproc.comparison.own import run
from shakerproc.data import FloatArray
from shakerproc.models import BASE, Model, Sensor
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.simulation.inputs import prepare_measured, with_constant

DRAWS: Final = 19
"""Models drawn from what tests leave open: of further ones 1 in 20 lies beyond each end [-]."""

LONGEST: Final = 2**13
"""Samples of a test over which joints are predicted: two tenths of a second of a processor
for each draw [-]."""

PERIODS: Final = 8
"""Periods of the largest response that are kept, about the largest motion of a joint [-]."""

MOST: Final = 1000
"""Samples that are kept [-]."""

_NINE_TENTHS: Final = 1.645  # standard deviations
_PLACE: Final = "displacement of "
_SPEED: Final = "velocity of "


@final
@dataclass(frozen=True, slots=True, eq=False)
class JointHistory:
    """Displacement of the second place against the first [m], velocity [m/s] and force [N]."""

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray


@final
@dataclass(frozen=True, slots=True)
class Banded:
    """Samples with the band in which 90 % of what tests leave open lies [unit of the samples].

    Attributes
    ----------
    value, low, high : tuple of float
        A sample each.
    """

    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@final
@dataclass(frozen=True, slots=True)
class HiddenJoint:
    """A joint that the recordings do not tell, in a part of one test.

    Attributes
    ----------
    between : (str, str)
        The two places.
    test : str
        Name of the test.
    time : tuple of float
        From its start [s].
    displacement, force : Banded
        Of the second place against the first [m], and of all laws between them [N].
    """

    between: tuple[str, str]
    test: str
    time: tuple[float, ...]
    displacement: Banded
    force: Banded


def hidden_joints(
    model: Model, drawn: Sequence[Model], test: TestComparison
) -> tuple[HiddenJoint, ...]:
    r"""Return motion and force of the joints that the recordings of a test do not tell.

    .. math:: b^2 = \max_k (x_k - x)^2 + (1.645 \, \epsilon \, x_{rms})^2

    with the motions :math:`x_k` of the models drawn, each side by itself, and the error
    :math:`\epsilon` of the model at the sensors: what it misses of these it misses elsewhere.

    Parameters
    ----------
    model : Model
        Of which the motion is.
    drawn : sequence of Model
        With numbers drawn from what the tests leave open.
    test : TestComparison
        The model beside the test; nothing is told where that cannot be predicted as a whole.
    """
    pairs = [one.between for one in test.not_told]
    if not pairs or not test.prediction.predictable:
        return ()
    found = _histories(model, pairs, test)
    others = [_histories(one, pairs, test) for one in drawn]
    told = []
    for pair in pairs if found else ():
        part = _part(found[pair].displacement, test)
        banded = (
            _banded(
                getattr(found[pair], what),
                [getattr(other[pair], what) for other in others if other],
                test.error,
                part,
            )
            for what in ("displacement", "force")
        )
        time = np.arange(part.start, part.stop) / test.measured.sample_rate
        told.append(HiddenJoint(pair, test.measured.name, tuple(map(float, time)), *banded))
    return tuple(told)


def _histories(
    model: Model, pairs: Sequence[tuple[str, str]], test: TestComparison
) -> dict[tuple[str, str], JointHistory]:
    """Return motion and force of joints at the start of a test; none where it runs away."""
    measured, own = test.measured, test.prediction.own
    model = model.under(measured.conditions)
    watched = probed(model, pairs)
    given = prepare_measured(
        measured.input[:LONGEST], measured.sample_rate, imposed=model.excitation.imposed
    )
    rows, failed = run(watched, with_constant(given, own.constant), own)
    if failed:
        return {}
    named = dict(zip(watched.sensors, rows, strict=True))
    return {pair: joint_history(model, pair, named, measured.sample_rate) for pair in pairs}


def _part(displacement: FloatArray, test: TestComparison) -> slice:
    """Return which samples are kept: some periods about the largest motion."""
    rate, size = test.measured.sample_rate, displacement.size
    slowest = max(min(one.peak_hz for one in test.errors), rate / size)
    count = min(int(PERIODS * rate / slowest), MOST, size)
    largest = int(np.argmax(np.abs(displacement)))
    first = min(max(largest - count // 2, 0), size - count)
    return slice(first, first + count)


def _banded(
    value: FloatArray, others: Sequence[FloatArray], error: float, part: slice
) -> Banded:
    """Return a part of samples within their band [unit of the samples]."""
    apart = np.array([np.zeros(value.size), *(other - value for other in others)])[:, part]
    missed = _NINE_TENTHS * error * float(np.std(value))
    low, high = (np.sqrt(one**2 + missed**2) for one in (apart.min(axis=0), apart.max(axis=0)))
    rows = (value[part], value[part] - low, value[part] + high)
    return Banded(*(tuple(map(float, row)) for row in rows))


def probed(model: Model, pairs: Sequence[tuple[str, str]]) -> Model:
    """Return a model with sensors of the motion of joints' places against the base."""
    sensors = dict(model.sensors)
    for place in {place for pair in pairs for place in pair} - {BASE}:
        sensors[_PLACE + place] = Sensor(place, "relative displacement")
        sensors[_SPEED + place] = Sensor(place, "relative velocity")
    return replace(model, sensors=sensors)


def joint_history(
    model: Model, pair: tuple[str, str], rows: Mapping[str, FloatArray], rate: float
) -> JointHistory:
    """Return the motion of a joint, and the force of all laws between its places.

    Parameters
    ----------
    model : Model
        Its laws.
    pair : (str, str)
        The places.
    rows : mapping of str to (n,) array
        What the sensors of the probed model (see `probed`) record [m], [m/s].
    rate : float
        Samples per second [Hz].
    """
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
    return JointHistory(displacement, velocity, force)
