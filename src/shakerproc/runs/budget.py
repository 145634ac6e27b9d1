"""Uncertainty budget of one reported number by the GUM, with parts that budgets share."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.runs.averaging import STEADY, welch
from shakerproc.runs.result import RunResult
from shakerproc.spectra import Damping
from shakerproc.spectra.peaks.damping import NORMAL

MOST: Final = 64
"""Stretches that are looked at, evenly over what lies outside of the run [-]."""

KEPT: Final = 4
"""One of so many, the quietest, is rest: others may hold the beginning of the run [-]."""

COVERAGE: Final = 2.0
"""Coverage factor k: some 95 % of a normal law [-]."""

Group: TypeAlias = Literal["calibration", "resolution", "random", "noise"]
GROUPS: Final[tuple[Group, ...]] = ("calibration", "resolution", "random", "noise")
"""Kinds of contributions, the columns of the table."""

NOT_QUIET: Final = "no quiet segment before or after the run"
NO_SHEET: Final = "no calibration sheet states it"
BY_FIT: Final = "95 % interval of the fit"


@final
@dataclass(frozen=True, slots=True, eq=False)
class QuietPart:
    """Signals of the channels while nothing drives them.

    Attributes
    ----------
    density : (n_channels, n_frequencies) array
        Mean over the quietest stretches, in the bins of the run [unit²/Hz].
    rms : (n_channels,) array
        Of the same [unit].
    origin : str
        Where it is from.
    """

    density: FloatArray
    rms: FloatArray
    origin: str


def quiet_part(recording: Recording, result: RunResult) -> QuietPart | None:
    """Return the quiet part of a recording; None where less than a segment lies outside."""
    segment, crop = result.spectra.segment, result.crop
    starts = [
        *range(0, crop.start - segment + 1, segment),
        *range(crop.stop, result.recorded.n_samples - segment + 1, segment),
    ]
    if not starts:
        return None
    chosen = np.unique(np.linspace(0, len(starts) - 1, MOST).round().astype(int))
    power = np.array([_stretch(recording, starts[k], segment).var(axis=1) for k in chosen])
    over = (
        np.where(result.averages.statistics.rms > 0.0, result.averages.statistics.rms, 1.0) ** 2
    )
    order = np.argsort((power / over).sum(axis=1), kind="stable")
    quietest = order[: -(-len(order) // KEPT)]
    density = np.zeros(result.averages.psd.shape)
    for k in chosen[quietest]:  # one after the other: segments may be long
        samples = _stretch(recording, starts[k], segment)
        density += welch([samples], result.recorded.sample_rate, result.test, ()).density
    seconds = len(quietest) * segment / result.recorded.sample_rate
    text = f"quietest {numeral(seconds, 3)} s before and after the run"
    rms = np.sqrt(power[quietest].mean(axis=0))
    return QuietPart(density / len(quietest), rms, text)


def _stretch(recording: Recording, start: int, length: int) -> FloatArray:
    """Return samples less their means, (n_channels, length)."""
    samples = recording.samples(start, start + length)
    return np.asarray(samples - samples.mean(axis=1, keepdims=True))


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
    """A reported number with its contributions to uncertainty.

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
        r"""Return the standard uncertainty of a group of contributions, or of all [any unit].

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
        """Expanded uncertainty of the known contributions [any unit]."""
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


def is_random(result: RunResult) -> bool:
    """Return whether chance of a density means anything: the run is random vibration."""
    return result.test.excitation in STEADY and result.averages.bounds is not None


def over_mean(row: int, inputs: Sequence[int]) -> dict[int, float]:
    """Return the powers of the gains in a response function over the mean of its inputs."""
    return {row: 1.0} | {i: 1.0 / len(inputs) for i in inputs}


def calibration(result: RunResult, value: float, powers: Mapping[int, float]) -> Contribution:
    """Return the contribution of calibrations to a product of powers of gains.

    `value` is the product [any unit], `powers` are by row of the channel [-].
    """
    channels = [result.channels[i] for i in powers]
    missing = [c.name for c in channels if c.uncertainty is None]
    if missing:
        return unknown("calibration", f"{NO_SHEET} of {', '.join(missing)}")
    parts = [p * (c.uncertainty or 0.0) for p, c in zip(powers.values(), channels, strict=True)]
    source = f"calibration sheet, {', '.join(c.name for c in channels)}"
    return normal("calibration", abs(value) * float(np.hypot.reduce(parts)), 2.0, source)


def of_mode(channel: str, quantity: str, at: float | None, read: Damping) -> Iterator[Budget]:
    """Yield natural frequency and damping ratio of a fit, as far as it tells them.

    `at` is the frequency of the peak [Hz].
    """
    if read.frequency is not None and read.frequency_low is not None:
        line = normal("random", read.frequency - read.frequency_low, NORMAL, BY_FIT)
        yield Budget(
            channel, f"{quantity} natural frequency", at, read.frequency, "Hz", (line,)
        )
    if read.ratio is not None and read.ratio_low is not None and read.ratio_high is not None:
        half = 0.5 * (read.ratio_high - read.ratio_low)
        yield damping(channel, quantity, at, read.ratio, half)


def damping(channel: str, quantity: str, at: float | None, ratio: float, half: float) -> Budget:
    """Return the budget of a damping ratio [-] from half its 95 % interval [-].

    `at` is the frequency of the peak [Hz].
    """
    line = normal("random", 100.0 * half, NORMAL, BY_FIT)
    return Budget(channel, f"{quantity} damping ratio", at, 100.0 * ratio, "%", (line,))
