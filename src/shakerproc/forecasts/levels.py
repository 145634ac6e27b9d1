"""Levels of tests, which of them are one, and the level at which a limit is exceeded."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.comparison import Measured
from shakerproc.comparison.equilibrium import pairs_of
from shakerproc.comparison.part import AROUND
from shakerproc.errors import LogError
from shakerproc.forecasts.motion import What
from shakerproc.forecasts.quantities import Quantity
from shakerproc.models import Conditions, Model
from shakerproc.numerals import numeral
from shakerproc.planning.drive import noise_profile
from shakerproc.planning.planned import level_text
from shakerproc.testlog import BROADBAND, Test, TestLog
from shakerproc.testlog.excitation import LEVELS
from shakerproc.testlog.header import Limit

Kind: TypeAlias = tuple[str | None, bool, tuple[float, ...]]
"""Excitation of a test, whether it sweeps upwards or not at all, and the shares of their forces
that the elements have which its conditions scale [-]."""

ONE_LEVEL_DB: Final = 1.0
"""Difference up to which tests are of one level: what controllers keep to [dB]."""


def amplitude_of(test: Test) -> float | None:
    """Return the rms of the drive that a log demands; None where it does not say it [SI]."""
    if test.excitation in BROADBAND and (test.profile or test.level):
        return noise_profile(test).rms
    if test.profile is not None:
        return max(test.profile.level) / sqrt(2.0)
    if test.level is None or test.level_unit is None:
        return None
    kind = LEVELS[test.level_unit][0]
    return test.level / sqrt(2.0) if kind == "amplitude" else test.level


def amplitude_of_measured(measured: Measured) -> float:
    """Return the rms of the drive that was demanded, or measured where none was [SI]."""
    demanded = amplitude_of(measured.test)
    return drive_rms(measured) if demanded is None else demanded


def drive_rms(measured: Measured) -> float:
    """Return the rms of the measured drive in the part that is compared [SI]."""
    return float(np.std(measured.input[measured.start : measured.stop]))


def decibels(ratio: float) -> float:
    """Return a ratio of amplitudes in decibels [dB]."""
    return 20.0 * float(np.log10(ratio))


def grouped(tests: Sequence[Measured]) -> list[list[Measured]]:
    """Return the tests of each level, the lowest level first."""
    rows: list[list[Measured]] = []
    for test in sorted(tests, key=amplitude_of_measured):
        here = amplitude_of_measured(test)
        first = amplitude_of_measured(rows[-1][0]) if rows else 0.0
        if not first or decibels(here / first) > ONE_LEVEL_DB:
            rows.append([])
        rows[-1].append(test)
    return rows


def kind_of(model: Model, test: Test, conditions: Conditions) -> Kind:
    """Return the drive of a test, and the factors of its conditions on the model [-]."""
    rises = test.from_hz is None or test.to_hz is None or test.from_hz <= test.to_hz
    return test.excitation, rises, tuple(scale.share(conditions) for scale in model.scales)


def kind_of_measured(model: Model, measured: Measured) -> Kind:
    """Return how a test was driven that was run, and under which shares [-]."""
    return kind_of(model, measured.test, measured.conditions)


def nearest_level(
    model: Model, tests: Sequence[Measured], to: Kind, amplitude: float
) -> list[Measured]:
    """Return the tests of the level next to an amplitude [SI], driven alike if any is.

    Those that are driven alike under other conditions come before all others.
    """
    kinds = [kind_of_measured(model, test) for test in tests]
    same_kind = next(
        found
        for n in (3, 2, 0)
        if (found := [t for t, kind in zip(tests, kinds, strict=True) if kind[:n] == to[:n]])
    )
    distances_db = [
        abs(decibels(amplitude_of_measured(test) / amplitude)) for test in same_kind
    ]
    first = amplitude_of_measured(same_kind[distances_db.index(min(distances_db))])
    return [
        test
        for test in same_kind
        if abs(decibels(amplitude_of_measured(test) / first)) <= ONE_LEVEL_DB
    ]


def excited_band(test: Test) -> tuple[float, float] | None:
    """Return the band that a test excites [Hz]; None where its log does not say it."""
    if test.band is None and test.frequency_hz is not None:
        low, high = (share * test.frequency_hz for share in AROUND)
        return low, high
    return test.band


def raised_level_text(test: Test, decibel: float = 0.0) -> str:
    """Return the level of a test as a log writes it, so many decibels higher [dB]."""
    if test.level is None or test.level_unit is None:
        named = f"profile {test.profile.name}" if test.profile else "its level"
        return f"{named} {decibel:+.1f} dB" if decibel else named
    if not decibel:
        return test.level_text
    power = 2.0 if LEVELS[test.level_unit][0] == "density" else 1.0
    return level_text(test.level * 10.0 ** (power * decibel / 20.0), test.level_unit)


def in_order(levels: Sequence[Sequence[Measured]]) -> str:
    """Return the levels that were run, for people."""
    return ", ".join(
        group[0].test.level_text or numeral(drive_rms(group[0])) for group in levels
    )


ALLOWED: Final = 0.05
"""Probability up to which a limit may be exceeded: 95 % is the usual confidence [-]."""

STEP_DB: Final = 3.0
"""Distance of the levels at which the probability is looked for [dB]."""

FARTHEST_DB: Final = 12.0
"""Distance from the demanded level up to which it is looked for [dB]."""


@final
@dataclass(frozen=True, slots=True)
class JudgedLimit:
    """A limit, and the probability that a planned test exceeds it.

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
        """Name of the limited quantity, for people."""
        return name_of(self.limit)


def name_of(limit: Limit) -> str:
    """Return the name of the limited quantity, for people."""
    if limit.whose == "response":
        return f"{limit.name} {limit.statistic}"
    what = what_of_joint(limit) if limit.whose == "joint" else ""
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
    try:
        if limit.whose == "response":
            return _of_response(limit, model)
        _check_peak(limit)
        if limit.whose == "joint":
            return _of_joint(limit, model)
        if limit.whose == "shaker":
            return _of_shaker(limit, model, log)
    except ValueError as error:
        raise LogError(str(log.document.error(("limits", *limit.key), str(error)))) from error
    return Quantity("force", "", "force", limit.unit)


def _check_peak(limit: Limit) -> None:
    """Pass a limit of a largest value.

    Raises
    ------
    ValueError
        If it is one of an rms value.
    """
    if limit.statistic == "rms":
        raise ValueError("expected a peak value; rms limits are of channels only")


def _of_response(limit: Limit, model: Model) -> Quantity:
    """Return the quantity of a channel.

    Raises
    ------
    ValueError
        If no sensor of the model measures it.
    """
    sensor = model.sensors.get(limit.name)
    if sensor is None:
        raise ValueError(f"expected a sensor of the model: {', '.join(model.sensors)}")
    unit = model.sensor_unit(sensor)
    if unit != limit.unit:
        raise ValueError(f"expected a limit in {unit}, which {limit.name} measures")
    return Quantity("response", limit.name, limit.statistic, unit)


def _of_joint(limit: Limit, model: Model) -> Quantity:
    """Return the quantity of a joint, whose places may be written in either order.

    Raises
    ------
    ValueError
        If the model has no such joint.
    """
    names = {}
    for pair in pairs_of(model):
        names["-".join(pair)] = names["-".join(reversed(pair))] = "-".join(pair)
    if limit.name not in names:
        known = ", ".join(dict.fromkeys(names.values()))
        raise ValueError(f"expected a joint of the model: {known}")
    return Quantity("joint", names[limit.name], what_of_joint(limit), limit.unit)


def _of_shaker(limit: Limit, model: Model, log: TestLog) -> Quantity:
    """Return the quantity of the shaker's table.

    Raises
    ------
    ValueError
        If no table moves, or the mass that its force moves is not known.
    """
    if not model.excitation.moves_base:
        raise ValueError("a force drives the model, so no table moves; take it out")
    if limit.name == "force" and log.shaker.moving_mass is None:
        raise ValueError("expected shaker: {moving_mass: 12 kg}, or its force is not known")
    what: What = limit.name  # type: ignore[assignment]
    return Quantity("shaker", "", what, limit.unit)


def level_of(beyond: Callable[[float], float]) -> float | None:
    """Return the level at which a limit is exceeded with 5 %; None beyond 12 dB.

    Looked for at multiples of 3 dB next to where it would be if all grew with the level, then
    between the two that enclose it.

    Parameters
    ----------
    beyond : callable
        From a level above that of the test [dB] to the 95 % quantile over the limit [dB].

    Returns
    -------
    float or None
        Level above that of the test [dB].
    """
    known = {0: beyond(0.0)}
    last = round(FARTHEST_DB / STEP_DB)
    while True:
        steps = np.array(sorted(known))
        over = np.array([known[int(step)] for step in steps])
        crossed = np.flatnonzero(over[:-1] * over[1:] <= 0.0)
        if crossed.size:
            i = min(crossed, key=lambda i: abs(steps[i] + steps[i + 1]))
            share = over[i] / (over[i] - over[i + 1]) if over[i] != over[i + 1] else 0.0
            level = STEP_DB * (steps[i] + share * (steps[i + 1] - steps[i]))
            if steps[i + 1] - steps[i] == 1:
                return float(level)
            step = int(np.clip(round(level / STEP_DB), steps[i] + 1, steps[i + 1] - 1))
        else:
            end = int(steps[-1] if over[0] < 0.0 else steps[0])
            further = 1 if over[0] < 0.0 else -1
            if abs(end) >= last:
                return None
            away = max(1, round(abs(known[end]) / STEP_DB))
            step = int(np.clip(end + further * away, -last, last))
        known[step] = beyond(STEP_DB * step)


def what_of_joint(limit: Limit) -> What:
    """Return which quantity of a joint a limit is of, by its unit."""
    return "force" if limit.unit in {"N", "N m"} else "displacement"
