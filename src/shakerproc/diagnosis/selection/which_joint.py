"""Joints that tests do not tell apart, and the sensor that would."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.residuals import Predicted, predict
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE
from shakerproc.diagnosis.selection.proposing import as_good, no_richer
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.errors import ModelError
from shakerproc.models import Sensor


def in_other_joints(standing: Sequence[Score]) -> list[Score]:
    """Return the hypotheses that have the chosen effects in other joints, and are no richer."""
    others = [(one, one.fit.hypothesis) for one in no_richer(standing)]
    return [
        one
        for one, hypothesis in others
        if sorted(hypothesis.kinds) == sorted(standing[0].fit.hypothesis.kinds)
        and hypothesis.names != standing[0].fit.hypothesis.names
    ]


def indistinguishable(standing: Sequence[Score]) -> tuple[str, ...]:
    """Return kinds and joints that predict as well as the chosen one and are no richer."""
    own = standing[0].fit.hypothesis.kinds if standing else ()
    tied = [score.fit.hypothesis.kinds for score in as_good(standing)]
    kinds = [kind for one in tied for kind in one if kind not in own]
    elsewhere = (name for names in _elsewhere(standing) for name in names)
    return tuple(dict.fromkeys([*kinds, *elsewhere]))


def alternatives(standing: Sequence[Score]) -> tuple[str, ...]:
    """Return the hypotheses that predict as well, each with all its effects, in words."""
    tied = [score.fit.hypothesis.kinds for score in as_good(standing)]
    return tuple(dict.fromkeys(" with ".join(one) for one in (*tied, *_elsewhere(standing))))


def ties(standing: Sequence[Score]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what predicts as well as the chosen one: kinds and joints, and in words."""
    return indistinguishable(standing), alternatives(standing)


def _elsewhere(standing: Sequence[Score]) -> list[list[str]]:
    """Return the effects and joints of each that has the chosen effects in other joints."""
    return [
        [
            f"{one.kind} between {' and '.join(one.between)}"
            for one in score.fit.hypothesis.added
        ]
        for score in in_other_joints(standing)
    ]


def shared(probability: float | None, standing: Sequence[Score]) -> float | None:
    """Return a probability shared by joints that are not told apart [-]."""
    return None if probability is None else probability / (1 + len(in_other_joints(standing)))


def joint_notes(found: Found, standing: Sequence[Score]) -> list[str]:
    """Return that joints are not told apart, each time with the sensor that would."""
    return [
        _told(
            standing[0].fit.hypothesis.added[-1].between,
            other.fit.hypothesis.added[-1].between,
            telling_sensor(found, standing[0].fit, other.fit),
        )
        for other in in_other_joints(standing)
    ]


def telling_sensor(found: Found, one: Fit, other: Fit) -> tuple[str, float] | None:
    """Return the place without sensor where two hypotheses differ most, and by how much.

    The rms of the difference of both accelerations over that of the one, in whole tests that
    were held out [-]. None where every place has a sensor, or one of them runs away.
    """
    known = {sensor.at for sensor in found.data.model.sensors.values()}
    places = [place for place in found.data.model.moving if place not in known]
    moved = [_at(found, fit, places) for fit in (one, other)]
    if not places or moved[0] is None or moved[1] is None:
        return None
    both = [np.concatenate(each.outputs, axis=1) for each in moved if each is not None]
    apart = np.sqrt(np.mean((both[1] - both[0]) ** 2, axis=1) / np.mean(both[0] ** 2, axis=1))
    k = int(np.argmax(apart))
    return places[k], float(apart[k])


def _at(found: Found, fit: Fit, places: Sequence[str]) -> Predicted | None:
    model = fit.hypothesis.model_at(fit.x)
    everywhere = replace(model, sensors={place: Sensor(place) for place in places})
    try:
        moved = predict(found.data, everywhere, whole_tests(found.data, held_out=True), None)
    except ModelError:
        return None
    return None if moved.failed.any() else moved


def _told(
    chosen: tuple[str, str], other: tuple[str, str], sensor: tuple[str, float] | None
) -> str:
    """Return that two joints are not told apart, and the place and share of what would [-]."""
    said = (
        f"These tests do not tell whether it is between {' and '.join(chosen)} or between "
        f"{' and '.join(other)}"
    )
    if sensor is None or sensor[1] < NEGLIGIBLE:
        return f"{said}, and no further sensor would."
    place, share = sensor
    return f"{said}: a sensor at {place} would, where both differ by {share:.0%}."
