"""Whether two channels sit in one place along one line."""

from typing import Final, TypeAlias

import numpy as np

ALONG: Final = 0.9
"""Least cosine between two directions that are one, about 25 degrees [-]: a sensor turned so
far still measures nine tenths of the motion along the blow, and logs give round directions."""

NEAR: Final = 1e-3
"""Distance up to which two positions are one place [m]: logs give them in whole millimetres."""

Triple: TypeAlias = tuple[float, float, float]

Place: TypeAlias = tuple[Triple | None, Triple | None]
"""Position [m] and direction [-] of a channel, None where the log does not say them."""


def sense_of(first: Place, second: Place) -> float:
    """Return 1 where two channels sit in one place along one line, and -1 where against it.

    0 where they do not, or where a position is not known. A direction that is not known is that
    of the other.
    """
    (where, along), (there, other) = first, second
    if where is None or there is None:
        return 0.0
    if np.linalg.norm(np.subtract(where, there)) > NEAR:
        return 0.0
    if along is None or other is None:
        return 1.0
    cosine = float(np.dot(along, other))
    return float(np.sign(cosine)) if abs(cosine) >= ALONG else 0.0
