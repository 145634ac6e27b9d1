"""The units that a report shows, as a person chooses them: ``SI``, or ``g, in/s, mil``."""

from collections.abc import Mapping, Sequence
from typing import Final

from shakerproc import units
from shakerproc.units import quoted

ChosenUnits = Mapping[str, tuple[str, float]]
"""Name of a unit and its size in SI, by the SI unit of the quantity."""

SI: Final = ("m/s^2", "m/s", "m", "N", "Pa", "V")
"""SI units of the quantities whose unit may be chosen, besides strain."""

_STRAIN: Final = ("µm/m", "m/m", "%")


def chosen_units(words: Sequence[str]) -> ChosenUnits:
    """Return the units that a report shows.

    Parameters
    ----------
    words : sequence of str
        ``SI`` for all of it, or a unit for each quantity; a later one counts.

    Raises
    ------
    ValueError
        If a word is no unit of acceleration, velocity, displacement, force, pressure, voltage
        or strain.
    """
    found: dict[str, tuple[str, float]] = {}
    for word in words:
        if word.strip().casefold() == "si":
            found |= {unit: (_printed(unit), 1.0) for unit in SI} | {"1": ("m/m", 1.0)}
            continue
        kind = _kind(units.spelled(word.strip()))
        found[kind] = (_printed(word.strip()), units.to_si(f"1 {units.spelled(word)}", kind))
    return found


def _kind(unit: str) -> str:
    if unit in _STRAIN:
        return "1"
    known = [kind for kind in SI if units.problem_of_unit(unit) is None
             and units.is_unit_of(unit, kind)]  # fmt: skip
    if not known:
        raise ValueError(
            "expected SI, or units of acceleration, velocity, displacement, force, pressure, "
            f"voltage or strain such as g, in/s, mil, got {quoted(unit)}"
        )
    return known[0]


def _printed(unit: str) -> str:
    """Return a unit as people write it: ``in/s²`` for ``in/s^2``, ``µm`` for ``um``."""
    return {"um": "µm"}.get(unit, unit.replace("^2", "²").replace("s2", "s²"))
