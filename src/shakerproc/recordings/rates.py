"""How files call a sample rate, and the time between samples."""

import re
from typing import Final

RATE_NAME: Final = re.compile(
    r"(?:.*_)?(?:fs|sr|f_?sample|samp(?:le|ling)_?(?:rate|freq(?:uency)?)|(?:scan|data)_?rate)"
    r"(?:_hz)?",
    re.IGNORECASE,
)
STEP_NAME: Final = re.compile(
    r"(?:.*_)?(?:dt|delta_?[tx]|t_?s|ts_?s|increment|time_?step)", re.I
)
