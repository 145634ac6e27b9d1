"""Limits of a log as quantities of a forecast: probability, and the level at which it is 5 %."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.errors import LogError
from shakerproc.forecast.motion import joints_of_model
from shakerproc.forecast.quantities import Quantity
from shakerproc.models import Model
from shakerproc.testlog import TestLog
from shakerproc.testlog.limits import Limit

ALLOWED: Final = 0.05
"""Probability up to which a limit may be exceeded: 95 % is the usual confidence [-]."""

STEP_DB: Final = 3.0
"""Distance of the levels at which the probability is looked for [dB]."""

FARTHEST_DB: Final = 12.0
"""Distance from the demanded level up to which it is looked for [dB]."""

_LEAST: Final = 1e-4  # probability that is told apart from 0


@final
@dataclass(frozen=True, slots=True)
class Judged:
    """A limit, and what a planned test does to it.

    Attributes
    ----------
    limit : Limit
        As the log has it.
    quantity : Quantity
        What it limits.
    probability : float
        That the test exceeds it [-].
    level_db : float, optional
        Level at which that is 5 %, above that of the test; None beyond 12 dB [dB].
    """

    limit: Limit
    quantity: Quantity
    probability: float
    level_db: float | None

    @property
    def name(self) -> str:
        """What it limits, for people."""
        return name_of(self.limit)


def name_of(limit: Limit) -> str:
    """Return what a limit is of, for people."""
    if limit.whose == "response":
        return f"{limit.name} {limit.statistic}"
    what = _of_joint(limit) if limit.whose == "joint" else ""
    return " ".join(filter(None, (limit.whose, limit.name, what)))


def quantity_of(limit: Limit, model: Model, log: TestLog) -> Quantity:
    """Return the quantity that a limit is of.

    Parameters
    ----------
    limit : Limit
        As the log has it.
    model : Model
        What is shaken.
    log : TestLog
        For messages.

    Raises
    ------
    LogError
        If the model has no such sensor or joint, or what it limits is not known.
    """
    unit = model.unit_of(limit.unit) if limit.unit in {"m", "N"} else limit.unit
    if limit.whose == "response":
        sensor = model.sensors.get(limit.name)
        if sensor is None:
            raise _error(
                log, limit, f"expected a sensor of the model: {', '.join(model.sensors)}"
            )
        if model.sensor_unit(sensor) != limit.unit:
            raise _error(
                log, limit,
                f"expected a limit in {model.sensor_unit(sensor)}, which {limit.name} measures",
            )  # fmt: skip
        return Quantity("response", limit.name, limit.statistic, limit.unit)
    if limit.statistic == "rms":
        raise _error(log, limit, "expected a peak value; rms limits are of channels only")
    if limit.whose == "joint":
        known = ["-".join(pair) for pair in joints_of_model(model)]
        names = {name: name for name in known}
        names |= {"-".join(reversed(pair)): "-".join(pair) for pair in joints_of_model(model)}
        if limit.name not in names:
            raise _error(log, limit, f"expected a joint of the model: {', '.join(known)}")
        return Quantity("joint", names[limit.name], _of_joint(limit), unit)
    if limit.whose == "force":
        return Quantity("force", "", "force", unit)
    if not model.excitation.moves_base:
        raise _error(log, limit, "a force drives the model, so no table moves; take it out")
    if limit.name == "force" and log.shaker.moving_mass is None:
        raise _error(
            log, limit, "expected shaker: {moving_mass: 12 kg}, without which no force is known"
        )
    return Quantity("shaker", "", limit.name, unit)  # type: ignore[arg-type]


def level_of(probability: Callable[[float], float]) -> float | None:
    """Return the level at which a limit is exceeded with 5 %; None beyond 12 dB.

    Parameters
    ----------
    probability : callable
        From a level above that of the test [dB] to the probability [-].

    Returns
    -------
    float or None
        Level above that of the test [dB].
    """
    here, level = _score(probability(0.0)), 0.0
    step = -STEP_DB if here > _score(ALLOWED) else STEP_DB
    while abs(level) < FARTHEST_DB:
        there = _score(probability(level + step))
        if (there - _score(ALLOWED)) * (here - _score(ALLOWED)) <= 0.0 and there != here:
            return level + step * (_score(ALLOWED) - here) / (there - here)
        here, level = there, level + step
    return None


def _score(probability: float) -> float:
    """Return the normal score of a probability, straight in level where laws are bells."""
    return float(scipy.special.ndtri(np.clip(probability, _LEAST, 1.0 - _LEAST)))


def _of_joint(limit: Limit) -> "str":
    return "force" if limit.unit in {"N", "N m"} else "displacement"


def _error(log: TestLog, limit: Limit, message: str) -> LogError:
    return LogError(str(log.document.error(("limits", *limit.key), message)))
