"""Uncertainty budget of one reported number, as the GUM makes it."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

COVERAGE: Final = 2.0
"""Coverage factor k: some 95 % of a normal law [-]."""

Group: TypeAlias = Literal["calibration", "resolution", "random", "noise"]
GROUPS: Final[tuple[Group, ...]] = ("calibration", "resolution", "random", "noise")
"""Kinds of contributions, the columns of the table."""


@final
@dataclass(frozen=True, slots=True)
class Contribution:
    """One line of a budget.

    Attributes
    ----------
    group : Group
        What kind of contribution it is.
    given : float or None
        Half width, expanded uncertainty or standard deviation, in the unit of the number
        [any unit]; None where nothing tells it.
    distribution : str
        ``normal``, ``rectangular`` or ``bias, not corrected``.
    divisor : float
        What makes a standard uncertainty of it [-].
    source : str
        Where it comes from, or why it is not known.
    """

    group: Group
    given: float | None
    distribution: str
    divisor: float
    source: str

    @property
    def standard(self) -> float | None:
        """Standard uncertainty [any unit]."""
        return None if self.given is None else self.given / self.divisor


def normal(group: Group, given: float, divisor: float, source: str) -> Contribution:
    """Return a contribution of a normal law.

    `given` is in the unit of the number [any unit]; `divisor` is its coverage factor [-].
    """
    return Contribution(group, given, "normal", divisor, source)


def rectangular(group: Group, half: float, source: str) -> Contribution:
    """Return a contribution of which only the limits are known.

    `half` is half their distance [any unit].
    """
    return Contribution(group, half, "rectangular", math.sqrt(3.0), source)


def bias(group: Group, size: float, source: str) -> Contribution:
    """Return a known departure that is not corrected, all of which counts (GUM F.2.4.5).

    `size` is how large it is [any unit].
    """
    return Contribution(group, size, "bias, not corrected", 1.0, source)


def unknown(group: Group, why: str) -> Contribution:
    """Return a contribution that nothing tells."""
    return Contribution(group, None, "", 1.0, why)


@final
@dataclass(frozen=True, slots=True)
class Budget:
    """A reported number with what it is uncertain by.

    Attributes
    ----------
    channel, quantity : str
        Whose it is, and what.
    at : float or None
        Frequency of the peak that it belongs to [Hz].
    value : float
        The number [any unit].
    unit : str
        Its unit.
    lines : tuple of Contribution
        What it is uncertain by, independent of each other.
    """

    channel: str
    quantity: str
    at: float | None
    value: float
    unit: str
    lines: tuple[Contribution, ...]

    def standard(self, group: Group | None = None) -> float | None:
        r"""Return the standard uncertainty, of what is known of a group or of all [any unit].

        .. math:: u = \sqrt{\sum_i u_i^2}

        None where nothing of the group is known.

        References
        ----------
        .. [1] JCGM 100:2008, "Guide to the expression of uncertainty in measurement", 5.1.2.
        """
        known = [
            line.standard
            for line in self.lines
            if line.standard is not None and group in {None, line.group}
        ]
        return math.hypot(*known) if known else None

    @property
    def expanded(self) -> float:
        """Expanded uncertainty of what is known [any unit]."""
        return COVERAGE * (self.standard() or 0.0)

    @property
    def missing(self) -> tuple[str, ...]:
        """Groups of which a contribution is not known."""
        return tuple(dict.fromkeys(line.group for line in _unknown(self.lines)))

    def share(self, value: float | None) -> float | None:
        """Return an uncertainty of it in per cent; `value` is in its unit [any unit]."""
        return None if value is None or self.value == 0.0 else 100.0 * value / abs(self.value)


def _unknown(lines: Iterable[Contribution]) -> Iterable[Contribution]:
    return (line for line in lines if line.given is None)
