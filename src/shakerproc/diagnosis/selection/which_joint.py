"""Joints that tests do not tell apart, and the sensor that would."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis import wording
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.residuals import Predicted, predict
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.errors import ModelError
from shakerproc.models import Sensor


def in_other_joints(standing: Sequence[Score]) -> list[Score]:
    """Return the hypotheses that have the chosen effects in other joints, and are no richer."""
    if not standing:
        return []
    first = standing[0].fit.hypothesis
    return [
        one
        for one in standing[1:]
        if one.fit.hypothesis.size <= first.size
        and sorted(one.fit.hypothesis.kinds) == sorted(first.kinds)
        and one.fit.hypothesis.names != first.names
    ]


def joint_notes(found: Found, standing: Sequence[Score]) -> list[str]:
    """Return that joints are not told apart, each time with the sensor that would."""
    return [
        wording.which_joint_note(
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
