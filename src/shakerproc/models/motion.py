"""Translation or rotation: the same laws, with the units of one or of the other."""

import re
from typing import Final, Literal, TypeAlias

Motion: TypeAlias = Literal["translation", "rotation"]
"""How masses move: along an axis [m], or about it [rad], with moments of inertia."""

_OF_ROTATION: Final = {"m": "rad", "N": "N m", "kg": "kg m^2"}
"""Unit of an angle, a torque and a moment of inertia by that of its counterpart."""

_SYMBOL: Final = re.compile(r"(?<![A-Za-z])(?P<symbol>kg|N|m)(?![A-Za-z])(?P<power>\^\d)?")


def unit_in(unit: str, motion: Motion) -> str:
    """Return the SI unit that a quantity of a translation has in a motion.

    Parameters
    ----------
    unit : str
        SI unit of the quantity where masses move along an axis.
    motion : Motion
        How they move.

    Examples
    --------
    >>> unit_in("N/m^3", "rotation"), unit_in("N s/m", "rotation"), unit_in("m/s^2", "rotation")
    ('N m/rad^3', 'N m s/rad', 'rad/s^2')
    """
    return unit if motion == "translation" else _SYMBOL.sub(_turned, unit)


_PREFIXES: Final = (("m", 1e3), ("µ", 1e6), ("n", 1e9))


def shown_in(unit: str, motion: Motion, largest: float | None = None) -> tuple[str, float]:
    """Return the unit that people read a quantity of a motion in, and how many make one of SI.

    Displacements are shown in millimetres or milliradians, where the largest that is shown is
    less than a tenth of one in millionths, and so on.

    Parameters
    ----------
    unit : str
        SI unit of the quantity where masses move along an axis.
    motion : Motion
        How they move.
    largest : float, optional
        The largest value that is shown [m or rad].
    """
    shown = unit_in(unit, motion)
    if unit != "m":
        return shown, 1.0
    if not largest:
        largest = 1.0
    prefix, factor = next((one for one in _PREFIXES if largest * one[1] >= 0.1), _PREFIXES[-1])
    return prefix + shown, factor


def _turned(match: re.Match[str]) -> str:
    name, power = _OF_ROTATION[match["symbol"]], match["power"] or ""
    return f"({name}){power}" if power and " " in name else f"{name}{power}"
