"""Numbers for people."""

from typing import Any, Final

IN_FULL: Final = 1e7
"""From here on a power of ten is easier to read than a row of digits [-]."""


def numeral(value: Any, digits: int = 3) -> str:
    """Return a number of so many digits, in full where that is short: 1240, not 1.24e+03.

    Parameters
    ----------
    value : float
        The number, in the unit that is shown; as in a format, a cell of a table that is one.
    digits : int
        How many are told; zeros fill up.
    """
    short = f"{value:.{digits}g}"
    return f"{float(short):.0f}" if 10.0**digits <= abs(float(short)) < IN_FULL else short
