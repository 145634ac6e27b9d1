"""Level of a test: demanded, as the controls saw it, and how far they kept to it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import STANDARD_GRAVITY, Channel
from shakerproc.numerals import numeral
from shakerproc.runs.summary import ControlSummary
from shakerproc.spectra import CrossSpectra
from shakerproc.testlog import PULSES, Test
from shakerproc.testlog.excitation import FORCES, LEVELS, LevelKind

BEYOND_ALARM: Final = 0.05
"""Share of the band or the sweep that may lie beyond the alarm limit by chance [-]."""

AMPLITUDE_TOLERANCE: Final = 0.15
"""How far a sine may miss its amplitude [-] (IEC 60068-2-6); an rms value likewise."""


def rounded_within(value: float, limit: float, decimals: int = 1, *, sign: bool = True) -> str:
    """Return a number rounded so that it stays on its side of a limit.

    More decimals than asked are written where the rounded number would lie on the other side:
    3.04 beside a limit of 3 is ``+3.04``.

    Both are in the same unit, whichever it is.
    """
    beyond = abs(value) > limit
    for places in range(decimals, decimals + 12):
        text = f"{round(value, places) + 0.0:{'+' if sign else ''}.{places}f}"
        if (abs(float(text)) > limit) == beyond:
            return text
    return f"{value:+}" if sign else f"{value}"


def control_text(seen: ControlSummary, where: str) -> str:
    """Return how far a control kept to its demand along its band or its sweep.

    Parameters
    ----------
    seen : ControlSummary
        Its departure, limits and verdict.
    where : str
        Along what: ``band`` or ``sweep``.
    """
    past_abort = not seen.kept and seen.beyond_alarm <= BEYOND_ALARM
    limit = seen.abort_db if past_abort else seen.alarm_db
    level = f"±{limit:g} dB of the demanded level"
    if abs(seen.worst_db) <= limit:
        place = f"within {level}"
    elif past_abort:
        place = f"beyond {level}, the abort limit"
    elif seen.beyond_alarm == 0.0:
        place = f"beyond {level} by no more than chance"
    else:
        allowed = 100.0 * BEYOND_ALARM
        share = rounded_within(100.0 * seen.beyond_alarm, allowed, sign=False)
        place = f"beyond {level} in {share} % of the {where}, where {allowed:g} % may be"
    verdict = "kept" if seen.kept else "NOT KEPT"
    worst = rounded_within(seen.worst_db, limit)
    return f"{place}: {verdict}, at worst {worst} dB at {numeral(seen.worst_hz, 4)} Hz"


def density_unit(unit: str) -> str:
    """Return the unit of a density, with brackets around a ratio or a product."""
    return f"({unit})²/Hz" if "/" in unit or " " in unit else f"{unit}²/Hz"


@final
@dataclass(frozen=True, slots=True)
class Level:
    """A level, demanded or measured.

    Attributes
    ----------
    kind : LevelKind
        Amplitude of a sine, mean density or rms within the excited band.
    value : float
        In SI.
    unit : str
        SI unit of the signal, such as ``m/s^2`` or ``N``.
    """

    kind: LevelKind
    value: float
    unit: str

    @property
    def shown(self) -> tuple[float, str]:
        """Value and unit for people."""
        name, factor = (
            ("g", 1.0 / STANDARD_GRAVITY) if self.unit == "m/s^2" else (self.unit, 1.0)
        )
        if self.kind == "density":
            return self.value * factor**2, density_unit(name)
        return self.value * factor, f"{name} rms" if self.kind == "rms" else name

    def __str__(self) -> str:
        value, unit = self.shown
        return f"{numeral(value)} {unit}"


def demanded(test: Test) -> Level | None:
    """Return the level that the log demands."""
    if test.level is None or test.level_unit is None:
        return None
    kind, unit = LEVELS[test.level_unit]
    return Level(kind, test.level, unit)


def watched(test: Test, channels: Sequence[Channel]) -> tuple[int, ...]:
    """Return the rows of the channels that tell the level of a test, in the unit of the log.

    The controls; where the log demands a force, the channels that measure one. None where no
    channel measures what the log demands.
    """
    wanted = demanded(test)
    if wanted is None:
        return tuple(i for i, channel in enumerate(channels) if channel.role == "control")
    return watched_in(channels, wanted.unit)


def watched_in(channels: Sequence[Channel], unit: str) -> tuple[int, ...]:
    """Return the rows of the channels that tell a level: forces of one in N, else controls.

    `unit` is that of the signal, such as ``N``.
    """
    role = "force" if unit in FORCES else "control"
    return tuple(i for i, c in enumerate(channels) if c.role == role and c.unit == unit)


def unseen(test: Test, channels: Sequence[Channel]) -> str:
    """Return why the level that the log demands is not checked; empty where it is."""
    wanted = demanded(test)
    if wanted is None or watched(test, channels):
        return ""
    role = "force" if wanted.unit in FORCES else "control"
    return (
        f"The level is not checked: the log demands {wanted}, and no channel has the role "
        f"{role}, which would measure it."
    )


def measured(
    test: Test,
    cross: CrossSpectra,
    channels: Sequence[Channel],
    band: tuple[float, float],
) -> Level | None:
    """Return the mean level of the watched channels, as the log or the excitation puts it.

    Parameters
    ----------
    test : Test
        What the log says.
    cross : CrossSpectra
        Of the crop.
    channels : sequence of Channel
        What each row is.
    band : (float, float)
        Excited band [Hz].

    Returns
    -------
    Level or None
        None where no channel measures it, where no kind of level is known, or of a pulse.
    """
    wanted = demanded(test)
    by_excitation: dict[str | None, LevelKind] = {
        "random": "density", "sine on random": "density", "sine sweep": "amplitude",
        "measured": "rms",
    }  # fmt: skip
    kind = wanted.kind if wanted else by_excitation.get(test.excitation)
    if test.excitation == "sine" and not wanted:
        kind = "amplitude"
    rows = watched(test, channels)
    if kind is None or not rows or test.excitation in PULSES:
        return None
    each = spectra.rms_in_band(cross, band)[list(rows)]
    power = float(np.mean(each**2))
    values = {
        "amplitude": math.sqrt(2.0 * power),
        "density": power / (band[1] - band[0]),
        "rms": math.sqrt(power),
    }
    return Level(kind, values[kind], channels[rows[0]].unit)


def mismatch(test: Test, seen: Level | None) -> str:
    """Return the message on a level outside its tolerance; empty where it is inside."""
    wanted = demanded(test)
    if wanted is None or seen is None or wanted.unit != seen.unit:
        return ""
    if not (wanted.value > 0.0 and seen.value > 0.0):
        return ""
    if wanted.kind == "density":
        off = 10.0 * math.log10(seen.value / wanted.value)
        alarm = test.processing.tolerance.alarm
        inside = abs(off) <= alarm
        departure, tolerance = f"{rounded_within(off, alarm)} dB", f"{alarm:g} dB"
    else:
        off = seen.value / wanted.value - 1.0
        inside = abs(off) <= AMPLITUDE_TOLERANCE
        limit = 100.0 * AMPLITUDE_TOLERANCE
        departure, tolerance = f"{rounded_within(100.0 * off, limit, 0)}%", f"{limit:g}%"
    if inside:
        return ""
    whose = "force channels" if seen.unit == "N" else "controls"
    return (
        f"the {whose} saw a mean {wanted.kind} of {seen}, {departure} from the {wanted} of the "
        f"log (tolerance {tolerance})"
    )
