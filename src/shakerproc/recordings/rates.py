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

RATE_WORD: Final = re.compile(
    r"(?:data_?|scan_?|acquisition_?)?rate|samples?_?(?:per_?|/)s(?:ec(?:ond)?)?|sps|abtastrate|"
    r"sampl(?:e|ing)_?rate|sampl(?:e|ing)_?freq(?:uency)?",
    re.IGNORECASE,
)
STEP_WORD: Final = re.compile(
    r"(?:sampl(?:e|ing)_?)?(?:interval|period|step)|sampl(?:e|ing)_?time", re.IGNORECASE
)
"""How a line of text or an attribute calls them, which is about a recording and no variable."""
