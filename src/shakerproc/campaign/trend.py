"""Trends: a frequency of each test against a fact of the log."""

from collections.abc import Mapping
from dataclasses import dataclass

from shakerproc.runs.summary import Value


@dataclass(frozen=True, slots=True)
class TrendPoint:
    """One run in a trend.

    Attributes
    ----------
    test : str
        Its id.
    x : float or str
        Where it stands: a number, or a category.
    frequency_hz : float
        The peak frequency, interpolated [Hz].
    bin_width_hz : float
        Distance of the bins it was read from [Hz].
    present_s, promised_s : float or None
        How long its recording is, and how long it should be where it was cut short.
    """

    test: str
    x: float | str
    frequency_hz: float
    bin_width_hz: float
    present_s: float | None = None
    promised_s: float | None = None

    @property
    def incomplete(self) -> bool:
        """Whether its recording was cut short."""
        return self.promised_s is not None


@dataclass(frozen=True, slots=True)
class Trend:
    """Peak frequency against one quantity, in series.

    Attributes
    ----------
    name : str
        Name of its files.
    title, caption, x_label : str
        What it shows, and what to look for.
    channel : str
        Whose peak frequency it is.
    series : mapping
        Points by the name of the series, in order of x.
    quantity, bars : str
        What the points are, and how far their bars reach.
    """

    name: str
    title: str
    caption: str
    x_label: str
    channel: str
    series: Mapping[str, tuple[TrendPoint, ...]]
    quantity: str = "peak frequency [Hz]"
    bars: str = "width of a bin"

    def connected(self, name: str) -> bool:
        """Return whether a line through a series says something: one point for each number."""
        places = [p.x for p in self.series[name]]
        return self.numeric and len(places) > 1 and len(set(places)) == len(places)

    @property
    def numeric(self) -> bool:
        """Whether x is a number."""
        return all(isinstance(p.x, float) for points in self.series.values() for p in points)


@dataclass(frozen=True, slots=True)
class TrendValue:
    """Value that one test gives of a quantity of a trend.

    Attributes
    ----------
    test : str
        Its id.
    facts : mapping
        What the log says of the test, by column.
    frequency_hz : float or None
        The value; None where the test does not tell [Hz].
    width_hz : float
        How far its bar reaches, both sides together [Hz].
    present_s, promised_s : float or None
        As of a `TrendPoint`.
    left_out : str
        Why the test takes no part; empty where it does.
    tallest_hz : float or None
        Where the tallest peak is, if it is another one [Hz].
    unsure : frozenset of str
        Tests to which the step from this one may lead to another mode.
    how : str
        How the peak was found among others; empty for by its frequency.
    """

    test: str
    facts: Mapping[str, Value]
    frequency_hz: float | None
    width_hz: float
    present_s: float | None = None
    promised_s: float | None = None
    left_out: str = ""
    tallest_hz: float | None = None
    unsure: frozenset[str] = frozenset()
    how: str = ""


@dataclass(frozen=True, slots=True)
class TrendRequest:
    """Quantities that a trend sets against each other.

    Attributes
    ----------
    name, title, caption : str
        Name of its files, headline, what to look for.
    x : str
        Column along the axis.
    by : tuple of str
        Columns whose values make the series.
    where : tuple of (str, str)
        Columns and the value a run must have there to take part.
    """

    name: str
    title: str
    caption: str
    x: str
    by: tuple[str, ...]
    where: tuple[tuple[str, str], ...] = ()
