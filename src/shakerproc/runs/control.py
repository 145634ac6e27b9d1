"""How far a control kept to what is demanded, in words that no rounding contradicts."""

from typing import Final

from shakerproc.numerals import numeral
from shakerproc.runs.summary import ControlSummary

BEYOND_ALARM: Final = 0.05
"""Share of the band or the sweep that may lie beyond the alarm limit by chance [-]."""


def beside(value: float, limit: float, decimals: int = 1, *, sign: bool = True) -> str:
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


def control_told(seen: ControlSummary, where: str) -> str:
    """Return how far a control kept to what is demanded along its band or its sweep.

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
        share = beside(100.0 * seen.beyond_alarm, allowed, sign=False)
        place = f"beyond {level} in {share} % of the {where}, where {allowed:g} % may be"
    verdict = "kept" if seen.kept else "NOT KEPT"
    worst = beside(seen.worst_db, limit)
    return f"{place}: {verdict}, at worst {worst} dB at {numeral(seen.worst_hz, 4)} Hz"
