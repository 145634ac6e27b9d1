"""Every resolved peak of a run for people: one row each, and why a damping is withheld."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

from shakerproc.numerals import numeral
from shakerproc.runs.levels import density_unit
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary

COLUMNS: Final = (
    "channel",
    "peak [Hz]",
    "height",
    "by fit",
    "f_n [Hz]",
    "Q",
    "zeta, 95 % [%]",
    "coherence",
)
"""Headers of `PeakRow.cells`."""


@final
@dataclass(frozen=True, slots=True)
class PeakRow:
    """One peak of a response.

    Attributes
    ----------
    channel : ChannelSummary
        Whose it is.
    peak : PeakSummary
        What is known of it.
    unit : str
        Of its height; empty where the channel has the unit of the control.
    """

    channel: ChannelSummary
    peak: PeakSummary
    unit: str = ""

    @property
    def cells(self) -> tuple[object, ...]:
        """Cells under `COLUMNS`; None for an empty cell."""
        peak = self.peak
        least = f"{numeral(peak.height)} {self.unit}".strip()
        interval = None
        if peak.damping_low is not None and peak.damping_high is not None:
            interval = (
                f"{numeral(100.0 * peak.damping_low)} to {numeral(100.0 * peak.damping_high)}"
            )
        return (
            self.channel.name,
            peak.frequency_hz,
            in_unit(peak.height, self.unit) if peak.resolved else f"> {least}",
            in_unit(peak.fitted_height, self.unit),
            peak.natural_frequency_hz,
            peak.quality,
            interval,
            peak.coherence,
        )


SWEPT_COLUMNS: Final = (
    "channel", "sweep", "peak [Hz]", "gain", "steady [Hz]", "steady gain", "Q",
)  # fmt: skip
"""Headers of `swept_rows`."""


def swept_rows(run: RunSummary) -> list[tuple[object, ...]]:
    """Return the tallest point of each swept response, and what a slow sweep would show."""
    return [
        (
            channel.name,
            peak.direction,
            peak.frequency_hz,
            in_unit(peak.gain, gain_unit(run, channel)),
            peak.steady_hz,
            in_unit(peak.steady_gain, gain_unit(run, channel)),
            None if peak.damping_ratio is None else 0.5 / peak.damping_ratio,
        )
        for channel in run.channels
        for peak in channel.swept_peaks
    ]


def steady_withheld(run: RunSummary) -> str:
    """Return of which swept responses no steady gain is known; empty where there are none."""
    of = [
        f"{channel.name} {peak.direction}"
        for channel in run.channels
        for peak in channel.swept_peaks
        if peak.steady_gain is None
    ]
    return (
        f"steady gain withheld ({', '.join(of)}): no linear mode fits; the joint is nonlinear, "
        "or the sweep is too fast and the gain that it shows too low: sweep slower to tell"
        if of
        else ""
    )


def quantity_of(run: RunSummary) -> str:
    """Return the quantity of the peaks: ``|H1|``, or ``PSD`` where there is no control."""
    return "|H1|" if any(c.role == "control" for c in run.channels) else "PSD"


def gain_unit(run: RunSummary, channel: ChannelSummary) -> str:
    """Return the unit of a response of a channel over the controls; empty of an own one."""
    over = next((c.unit for c in run.channels if c.role == "control"), channel.unit)
    return "" if over == channel.unit else f"{channel.unit}/{over}"


def in_unit(value: float | None, unit: str) -> object:
    """Return a value with its unit for people; the number itself where it has none.

    `value` may be in any unit.
    """
    return value if value is None or not unit else f"{numeral(value, 4)} {unit}"


def peak_rows(run: RunSummary) -> tuple[PeakRow, ...]:
    """Return every resolved peak of every response, by channel and frequency."""
    of_response = quantity_of(run) == "|H1|"
    return tuple(
        PeakRow(
            channel,
            peak,
            gain_unit(run, channel) if of_response else density_unit(channel.unit),
        )
        for channel in run.channels
        if channel.role != "control"
        for peak in sorted(
            channel.response_peaks if of_response else channel.psd_peaks,
            key=lambda found: found.frequency_hz,
        )
    )


def unresolved(run: RunSummary, rows: tuple[PeakRow, ...]) -> str:
    """Return the meaning of ``>`` beside a height; empty where the bins resolve every peak."""
    if run.spectrum is None or all(row.peak.resolved for row in rows):
        return ""
    return (
        f"> bins of {numeral(run.spectrum.bin_width_hz)} Hz are too coarse for these peaks: "
        "their height is at least this; the fit allows for the bins"
    )


def withheld(rows: tuple[PeakRow, ...]) -> Iterator[str]:
    """Yield each reason why a damping is withheld, once, with the peaks that it concerns."""
    told: dict[str, dict[str, list[str]]] = {}
    for row in rows:
        if row.peak.why_not:
            places = told.setdefault(row.peak.why_not, {})
            places.setdefault(numeral(row.peak.frequency_hz, 4), []).append(row.channel.name)
    for reason, places in told.items():
        where = "; ".join(f"{', '.join(names)} at {hz} Hz" for hz, names in places.items())
        yield f"Q withheld ({where}): {reason}"
