"""The level of a test: what the log demands and what the controls saw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import STANDARD_GRAVITY, Channel
from shakerproc.numerals import numeral
from shakerproc.runs.control import beside
from shakerproc.spectra import CrossSpectra
from shakerproc.testlog import PULSES, Test
from shakerproc.testlog.excitation import FORCES, LEVELS, LevelKind

AMPLITUDE_TOLERANCE: Final = 0.15
"""How far a sine may miss its amplitude [-] (IEC 60068-2-6); an rms value likewise."""


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
        told, tolerance = f"{beside(off, alarm)} dB", f"{alarm:g} dB"
    else:
        off = seen.value / wanted.value - 1.0
        inside = abs(off) <= AMPLITUDE_TOLERANCE
        limit = 100.0 * AMPLITUDE_TOLERANCE
        told, tolerance = f"{beside(100.0 * off, limit, 0)}%", f"{limit:g}%"
    if inside:
        return ""
    whose = "force channels" if seen.unit == "N" else "controls"
    return (
        f"the {whose} saw a mean {wanted.kind} of {seen}, {told} from the {wanted} of the log "
        f"(tolerance {tolerance})"
    )
