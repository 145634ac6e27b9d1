"""Condition under which an effect is fitted to longer windows."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np


@final
@dataclass(frozen=True, slots=True)
class Condition:
    """Condition under which an effect is fitted to longer windows.

    Attributes
    ----------
    wanted : str
        Kind that is fitted to all windows, whatever it leaves; none if empty.
    below : float
        Level (see `Fit`) that others have to stay below in the shortest windows [-].
    explained : bool
        Whether the hypothesis without the effect leaves no more than noise: others have to
        outdo it then.
    """

    wanted: str = ""
    below: float = np.inf
    explained: bool = False


NONE: Final = Condition()
"""No condition but those that hold for every effect."""
