"""Whether samples go on where those before end."""

from typing import Final

from shakerproc.recordings.time_base import CLOCKS

LATE: Final = 1e-3
"""Gap between segments that is none [s]: programs write times of day to the millisecond."""


def follows(elapsed: float, duration: float, step: float) -> bool:
    """Return whether samples go on where those before end.

    Parameters
    ----------
    elapsed : float
        From the first sample of those before to the first of these [s].
    duration : float
        Of the samples before [s].
    step : float
        Time between samples [s]; 0 where it is not said.
    """
    return step > 0.0 and abs(elapsed - duration) <= max(step, LATE) + CLOCKS * duration
