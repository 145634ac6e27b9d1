"""Orders of a rotating machine against the speed that a tachometer shows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.roles import is_called, row_asked_for
from shakerproc.runs.tables import spelled
from shakerproc.spectra import Crop
from shakerproc.spectra.tones.orders import (
    Rotation,
    order_amplitudes,
    rotation,
    rotation_at_angle,
    rotation_at_speed,
)
from shakerproc.testlog.processing import Orders

MOST_ROWS: Final = 2000
"""Most stretches that are fitted, spread evenly over a longer run, which is told: finer than a
figure shows [-]."""

MOST_TOLD: Final = 5
"""Most pulses whose times are told one by one [-]."""

RESOLVED: Final = 2.0
"""Least distance between orders, over one in the revolutions of a stretch: half the main lobe
of a Hann window [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Tracked:
    """Orders of a run: (n,) times [s] and speeds [rev/min], (n_channels, n_orders, n) rows."""

    time: FloatArray
    speed: FloatArray
    amplitudes: ComplexArray


@final
class OrderAnalysis(AbstractAnalysis):
    """Amplitude and phase of orders over speed and time."""

    kind: ClassVar[str] = "orders"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the orders of every channel but the tachometer."""
        wanted = result.test.processing.orders
        shaft = result.over_time.shaft
        if wanted is None or shaft is None:
            return None
        _check_distance(wanted)
        rows = [
            i
            for i, channel in enumerate(result.channels)
            if not is_called(channel, wanted.tachometer)
        ]
        tracked = _tracked(recording.select(rows), result, wanted, shaft)
        labels = [f"order {order:g}" for order in wanted.track]
        slowest, fastest = tracked.speed.min(), tracked.speed.max()
        return Analysis(
            kind=self.kind,
            title=f"Orders against the speed of {wanted.tachometer}",
            columns=_columns(result, rows, labels, tracked),
            summary=tuple(
                _row(result, row, label, tracked, (i, j))
                for i, row in enumerate(rows)
                for j, label in enumerate(labels)
            ),
            panels=(_speed(tracked), *_panels(result, rows, labels, tracked)),
            sentences=(
                f"Speed {slowest:.5g} to {fastest:.5g} rev/min, "
                f"{shaft.revolutions:.5g} revolutions.",
                *_thinned(shaft, wanted),
                *_irregular(shaft, wanted, result),
            ),
        )


def _stretches(shaft: Rotation, wanted: Orders) -> int:
    """Return how many stretches there are, each over half of the one before."""
    return int(2.0 * (shaft.revolutions - wanted.revolutions) / wanted.revolutions) + 1


def _thinned(shaft: Rotation, wanted: Orders) -> list[str]:
    """Return a sentence where not all stretches of a run are fitted."""
    there = _stretches(shaft, wanted)
    if there <= MOST_ROWS:
        return []
    all_of_it = np.ceil(2.0 * shaft.revolutions / MOST_ROWS)
    return [
        f"{MOST_ROWS} of {there} stretches of {wanted.revolutions:g} revolutions, spread "
        f"evenly over the run; revolutions: {all_of_it:g} would use all of it."
    ]


def _irregular(shaft: Rotation, wanted: Orders, result: RunResult) -> list[str]:
    """Return sentences that say which pulses are missing and which are one too many."""
    start = result.crop.start / result.recorded.sample_rate
    pulses = shaft.pulses
    return [
        f"Tachometer {wanted.tachometer}: {how} at {_listed(times + start)}; {done}."
        for times, how, done in (
            (pulses.missing, "pulses missing", "their angle is allowed for"),
            (pulses.extra, "extra pulses", "they were left out"),
        )
        if times.size
    ]


def _listed(times: FloatArray) -> str:
    more = f" and {times.size - MOST_TOLD} more" if times.size > MOST_TOLD else ""
    return ", ".join(f"{time:.6g} s" for time in sorted(times)[:MOST_TOLD]) + more


def _check_distance(wanted: Orders) -> None:
    """Pass orders that a stretch can tell apart, and from an offset.

    Raises
    ------
    SpectrumError
        If two are closer.
    """
    track = np.array([0.0, *sorted(wanted.track)])
    least = float(np.diff(track).min())
    if least * wanted.revolutions < RESOLVED * (1.0 - 1e-9):
        near = int(np.argmin(np.diff(track)))
        first = "an offset" if near == 0 else f"order {track[near]:g}"
        raise SpectrumError(
            f"orders: {first} and order {track[near + 1]:g} are not separable within "
            f"{wanted.revolutions:g} revolutions; give revolutions: "
            f"{np.ceil(RESOLVED / least) if least else np.inf:g}, or leave one out"
        )


def shaft_of(recording: Recording, crop: Crop, wanted: Orders | None) -> Rotation | None:
    """Return the rotation, times from the start of the run; None where no orders are wanted.

    Raises
    ------
    SpectrumError
        If there is no such channel, or it shows no pulses or too few revolutions.
    """
    if wanted is None:
        return None
    todo = "Name the tachometer among them"
    row = row_asked_for(recording.channels, wanted.tachometer, "orders", todo=todo)
    samples = recording.select([row]).samples(crop.start, crop.stop)[0]
    try:
        shaft = _rotation(samples, recording, row, wanted)
    except SpectrumError as error:
        raise SpectrumError(
            f"orders: tachometer {wanted.tachometer}: {error}; check its cable and its range, "
            "or name another channel"
        ) from error
    if shaft.revolutions < wanted.revolutions:
        raise SpectrumError(
            f"orders: tachometer {wanted.tachometer}: {shaft.revolutions:g} revolutions in "
            f"the run, where {wanted.revolutions:g} are needed; give fewer revolutions"
        )
    return shaft


def _rotation(samples: FloatArray, recording: Recording, row: int, wanted: Orders) -> Rotation:
    """Return the rotation that a speed, an angle or pulses tell, by the unit of the channel.

    Raises
    ------
    SpectrumError
        If they tell none.
    """
    rate = recording.sample_rate
    direct = {"rad/s": rotation_at_speed, "rad": rotation_at_angle}
    speed_unit = direct.get(recording.channels[row].unit)
    if speed_unit is None:
        return rotation(samples, rate, wanted.pulses_per_revolution)
    return speed_unit(samples, rate)


def _tracked(
    recording: Recording, result: RunResult, wanted: Orders, shaft: Rotation
) -> _Tracked:
    """Return orders in stretches of equal angle, spread evenly over the run.

    Raises
    ------
    SpectrumError
        If an order lies above half the sample rate.
    """
    half = 0.5 * wanted.revolutions
    n = min(_stretches(shaft, wanted), MOST_ROWS)
    middles = np.linspace(half, shaft.revolutions - half, n)
    ends = np.array([shaft.time(middles - half), shaft.time(middles + half)])
    speed = wanted.revolutions / (ends[1] - ends[0])  # of each stretch, revolutions per second
    highest, rate = max(wanted.track), result.recorded.sample_rate
    if highest * speed.max() >= 0.5 * rate:
        raise SpectrumError(
            f"orders: order {highest:g} reaches {numeral(highest * speed.max(), 4)} Hz at "
            f"{60.0 * speed.max():.5g} rev/min, above half the sample rate of {rate:g} Hz; "
            f"give orders below {numeral(0.5 * rate / speed.max(), 4)}, or record faster"
        )
    orders, start = np.array(wanted.track), result.crop.start
    first = np.maximum(np.ceil(ends[0] * rate), 0.0).astype(int)
    last = np.minimum(np.floor(ends[1] * rate) + 1.0, result.crop.n_samples).astype(int)
    fitted = [
        order_amplitudes(
            recording.samples(start + a, start + b), shaft.angle(np.arange(a, b) / rate), orders
        )
        for a, b in zip(first, last, strict=True)
    ]
    time = shaft.time(middles) + start / rate
    return _Tracked(time, 60.0 * speed, np.stack(fitted, axis=-1))


def _columns(
    result: RunResult, rows: Sequence[int], labels: Sequence[str], tracked: _Tracked
) -> dict[str, FloatArray]:
    columns = {"time_s": tracked.time, "speed_rev_per_min": tracked.speed}
    for i, row in enumerate(rows):
        unit, factor = shown_unit(result.channels[row].unit)
        for j, label in enumerate(labels):
            name = f"{label.replace(' ', '_')}_{result.channels[row].name}"
            columns[f"{name}_amplitude{spelled(unit)}"] = (
                np.abs(tracked.amplitudes[i, j]) * factor
            )
            columns[f"{name}_phase_deg"] = np.degrees(np.angle(tracked.amplitudes[i, j]))
    return columns


def _row(
    result: RunResult, row: int, label: str, tracked: _Tracked, at: tuple[int, int]
) -> dict[str, Cell]:
    """Return the largest amplitude of an order, and when it is that large."""
    unit, factor = shown_unit(result.channels[row].unit)
    amplitude = np.abs(tracked.amplitudes[at]) * factor
    peak = int(np.argmax(amplitude))
    return {
        "channel": result.channels[row].name,
        "order": label.removeprefix("order "),
        "largest": float(amplitude[peak]),
        "unit": unit,
        "phase_deg": float(np.degrees(np.angle(tracked.amplitudes[at][peak]))),
        "speed_rev_per_min": float(tracked.speed[peak]),
        "time_s": float(tracked.time[peak]),
    }


def _speed(tracked: _Tracked) -> Panel:
    return Panel(
        "orders_speed", "Speed", "Mean speed of each stretch of revolutions.",
        PanelScale("time [s]", logarithmic=False),
        PanelScale("speed [rev/min]", logarithmic=False),
        (PanelLine("speed", tracked.time, tracked.speed),),
    )  # fmt: skip


def _panels(
    result: RunResult, rows: Sequence[int], labels: Sequence[str], tracked: _Tracked
) -> list[Panel]:
    """Return the amplitudes of all orders against speed, one figure a channel."""
    panels = []
    for i, row in enumerate(rows):
        channel = result.channels[row]
        unit, factor = shown_unit(channel.unit)
        lines = tuple(
            PanelLine(label, tracked.speed, np.abs(tracked.amplitudes[i, j]) * factor, style=j)
            for j, label in enumerate(labels)
        )
        panels.append(
            Panel(
                f"orders_{i + 1}", f"Orders of {channel.name}",
                "Amplitude of each order against the speed of the shaft.",
                PanelScale("speed [rev/min]", logarithmic=False),
                PanelScale(f"amplitude [{unit}]", logarithmic=False), lines,
            )
        )  # fmt: skip
    return panels
