"""What a file says of its sample rate: how it is called, and whether its statements agree."""

import re
from collections.abc import Mapping
from typing import Final

import numpy as np

from shakerproc.recordings.raw import SILENT

CONTRADICTION: Final = 1e-3
"""How far two statements of a rate may part before they contradict each other, relative."""

RATE_NAME: Final = re.compile(
    r"(?:.*_)?(?:fs|sr|f_?sample|samp(?:le|ling)_?(?:rate|freq(?:uency)?)|(?:scan|data)_?rate)"
    r"(?:_hz)?",
    re.IGNORECASE,
)
STEP_NAME: Final = re.compile(
    r"(?:.*_)?(?:dt|delta_?[tx]|t_?s|ts_?s|increment|time_?step)", re.I
)


def agreed_rate(said: Mapping[str, float]) -> tuple[float | None, str]:
    """Return the sample rate [Hz] that a file gives, or what is wrong with its statements.

    Parameters
    ----------
    said : mapping
        Rates [Hz] by where they stand.
    """
    if not said:
        return None, SILENT
    for name, rate in said.items():
        if not (np.isfinite(rate) and rate > 0.0):
            return None, f"{name} gives a rate of {rate:g} Hz, which is none"
    low, high = min(said.values()), max(said.values())
    if high / low - 1.0 > CONTRADICTION:
        rates = ", ".join(f"{rate:.6g} Hz ({name})" for name, rate in said.items())
        return None, f"the file contradicts itself: {rates}"
    whole = [rate for rate in said.values() if rate == round(rate)]
    return (whole or list(said.values()))[0], ""
