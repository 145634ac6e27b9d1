"""The figures of one run as files: time with crop, densities, responses, coherence, notch."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from shakerproc import files
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.report import style
from shakerproc.runs.result import RunResult, shown_ratio, shown_unit
from shakerproc.runs.summarising import shown_part
from shakerproc.testlog import ThresholdCrop

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOTS_PER_INCH: Final = 130
LEFT: Final = 0.8  # margin [in]


def draw_run(result: RunResult, title: str, folder: Path) -> list[Path]:
    """Draw every figure that a run has, and return the files."""
    written = []
    for name, draw in FIGURES.items():
        with style.look():
            figure = draw(result, title)
        if figure is not None:
            written.append(save(figure, folder / f"{name}.png"))
    return written


def save(figure: "Figure", path: Path) -> Path:
    """Write a figure as PNG, whole or not at all, the same bytes for the same figure."""
    with files.atomic_path(path) as temporary:
        figure.savefig(
            temporary,
            format="png",
            dpi=DOTS_PER_INCH,
            metadata={"Software": "shakerproc"},
            pil_kwargs={"compress_level": 4},
        )
    return path


def _styles(result: RunResult) -> list[int]:
    return style.styles([c.role or "response" for c in result.channels])


def time_series(result: RunResult, title: str) -> "Figure":
    """Return every channel over the whole recording, what was cropped away shaded."""
    n = len(result.channels)
    figure, axes = style.figure(7.0, 0.5 + 0.85 * n, n, sharex=True, left=LEFT, legend=False)
    e, chosen = result.envelope, _styles(result)
    start = result.crop.start / result.sample_rate
    stop = result.crop.stop / result.sample_rate
    for i, axis in enumerate(axes):
        unit, factor = shown_unit(result.channels[i].unit)
        axis.fill_between(
            e.time,
            e.low[i] * factor,
            e.high[i] * factor,
            color=style.COLOURS[chosen[i]],
            lw=0.3,
        )
        axis.axvspan(0.0, start, color="#888888", alpha=0.25, lw=0.0)
        axis.axvspan(stop, result.promised_duration, color="#888888", alpha=0.25, lw=0.0)
        style.name(axis, result.channels[i].name, unit)
    _threshold(axes, result)
    _events(axes, result)
    if result.incomplete:
        for axis in axes:
            axis.axvline(result.duration, color="#a62b00", lw=1.2)
    _head(axes[0], result, title, f"processed {start:.2f} to {stop:.2f} s", legend=False)
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(0.0, result.promised_duration)
    return figure


def _events(axes: Sequence["Axes"], result: RunResult) -> None:
    """Draw what happened during the test: a line through all, the note at the top."""
    for event in result.test.events:
        for axis in axes:
            axis.axvline(event.time, color="#222222", lw=0.8, ls=(0, (1, 1.5)))
        late = event.time > 0.6 * result.promised_duration
        axes[0].annotate(
            files.printable(event.note),
            (event.time, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-3 if late else 3, -2),
            textcoords="offset points",
            ha="right" if late else "left",
            va="top",
            fontsize=8.0,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        )


def _threshold(axes: Sequence["Axes"], result: RunResult) -> None:
    """Draw the threshold on the channel that it is compared with, and a doubtful start."""
    crop, row = result.test.processing.crop, result.crop_channel
    if not isinstance(crop, ThresholdCrop) or row is None:
        return
    level = crop.threshold * shown_unit(result.channels[row].unit)[1]
    for sign in (1.0, -1.0) if crop.absolute else (1.0,):
        axes[row].axhline(sign * level, color="#d55e00", lw=0.8, ls=(0, (4, 2)))
    if result.crop.warning is not None:
        axes[row].annotate(
            "stands alone: a spike?",
            (result.crop.start / result.sample_rate, level),
            xytext=(14, -16),
            textcoords="offset points",
            color="#a62b00",
            fontsize=8.0,
            arrowprops={"arrowstyle": "->", "color": "#a62b00"},
        )


def _head(
    axis: "Axes", result: RunResult, title: str, more: str = "", *, legend: bool = True
) -> None:
    """Write the title of the run, and below it what is shown and whether it was cut short."""
    notes = [more] if more else []
    if result.incomplete:
        notes.insert(0, f"INCOMPLETE: {result.told_length}")
    style.head(axis, title, ", ".join(notes), alarming=result.incomplete, legend=legend)


def _frequency_axis(axis: "Axes", result: RunResult) -> None:
    shown = result.spectra.frequency[shown_part(result)]
    axis.set_xlim(0.0, shown[-1])
    if result.test.excitation != "sine":
        for low, high in ((0.0, result.band[0]), (result.band[1], shown[-1])):
            axis.axvspan(low, high, color="#888888", alpha=0.13, lw=0.0)
    axis.set_xlabel("frequency [Hz]")


def _units(result: RunResult, rows: Sequence[int]) -> list[str]:
    """Return the SI units of some channels, each once."""
    return list(dict.fromkeys(result.channels[i].unit for i in rows))


def psd(result: RunResult, title: str) -> "Figure":
    """Return the density of every channel, an axis a unit, with bounds for responses."""
    units = _units(result, range(len(result.channels)))
    n = len(units)
    figure, axes = style.figure(7.0, 3.5 if n == 1 else 2.4 * n, n, sharex=True, left=LEFT)
    for axis, unit in zip(axes, units, strict=True):
        _draw_psd(axis, result, unit)
    for axis in axes[:-1]:
        axis.set_xlabel("")
    _head(axes[0], result, title, _worth(result))
    return figure


def _worth(result: RunResult) -> str:
    cross = result.spectra
    return f"bins {cross.bin_width:.3g} Hz, {cross.degrees_of_freedom:.0f} DOF"


def _draw_psd(axis: "Axes", result: RunResult, unit: str) -> None:
    """Draw the densities of the channels of one SI unit."""
    shown, chosen = shown_part(result), _styles(result)
    x = result.spectra.frequency[shown]
    name, factor = shown_unit(unit)
    rows = [i for i, channel in enumerate(result.channels) if channel.unit == unit]
    for i in rows:
        density = _positive(result.psd[i, shown] * factor**2)
        axis.plot(x, density, label=result.channels[i].name, **style.line(chosen[i]))
        if i in result.responses and result.bounds is not None:
            low, high = (
                _positive(b[i, shown] * factor**2)
                for b in (result.bounds.low, result.bounds.high)
            )
            axis.fill_between(x, low, high, color=style.COLOURS[chosen[i]], alpha=0.18, lw=0.0)
    axis.set_ylabel(f"PSD [{style.density_unit(name)}]")
    _decades(axis, [result.psd[i, shown] * factor**2 for i in rows])
    _mark_peak(axis, result, rows)
    _frequency_axis(axis, result)
    style.legend(axis)


def _mark_peak(axis: "Axes", result: RunResult, channels: Sequence[int]) -> None:
    """Mark the peak frequency: the tallest peak of any response among some channels."""
    if result.test.excitation == "sine":
        return
    rows = [i for i in result.responses if i in channels and result.psd_peaks[i]]
    if not rows:
        return
    i = max(rows, key=lambda row: result.psd_peaks[row][0].peak.value)
    peak = result.psd_peaks[i][0].peak
    height = peak.value * shown_unit(result.channels[i].unit)[1] ** 2
    axis.annotate(
        f"peak {peak.frequency:.1f} Hz",
        (peak.frequency, height),
        xytext=(8, -2),
        textcoords="offset points",
        fontweight="bold",
    )
    axis.plot([peak.frequency], [height], "o", ms=4, color="black")


def _decades(axis: "Axes", rows: Sequence[FloatArray], most: int = 9) -> None:
    """Make the vertical axis logarithmic, whole decades around the values."""
    values = np.concatenate([row[np.isfinite(row) & (row > 0.0)] for row in rows])
    if values.size:
        high = np.ceil(np.log10(values.max()) + 0.1)  # room for the mark of the peak
        low = max(np.floor(np.log10(values.min()) - 0.05), high - most)
        style.logarithmic(axis, 10.0**low, 10.0**high)


def unbroken_phase(response: ComplexArray) -> FloatArray:
    """Return the phase from -270 to 90 degrees, with the line broken where it wraps.

    `response` may be in any unit.
    """
    phase = np.degrees(np.angle(response))
    phase = np.where(phase > 90.0, phase - 360.0, phase)
    jump = np.abs(np.diff(phase, prepend=phase[:1])) > 180.0
    return np.where(jump, np.nan, phase)


def _positive(values: FloatArray) -> FloatArray:
    return np.where(values > 0.0, values, np.nan)


def response(result: RunResult, title: str) -> "Figure | None":
    """Return gain of H1 and root of the PSD ratio, an axis a unit, and the phase of H1."""
    if result.against is None or result.test.excitation == "sine":
        return None
    units = _units(result, result.responses)
    n = len(units) + 1
    figure, axes = style.figure(7.0, 2.6 * n, n, sharex=True, left=LEFT)
    *gains, phase = axes
    shown, chosen, against = shown_part(result), _styles(result), result.against
    x = result.spectra.frequency[shown]
    for axis, unit in zip(gains, units, strict=True):
        _draw_gain(axis, result, unit)
    for row, i in enumerate(result.responses):
        h1 = np.where(against.valid, against.h1[row], np.nan)[shown]
        phase.plot(x, unbroken_phase(h1), **style.line(chosen[i]))
    _head(gains[0], result, title, "H1; thin: root of the PSD ratio")
    _phase_axis(phase, "phase of H1 [°]")
    _frequency_axis(phase, result)
    return figure


def _draw_gain(axis: "Axes", result: RunResult, unit: str) -> None:
    """Draw |H1| and the root of the PSD ratio of the responses of one SI unit."""
    against = result.against
    assert against is not None  # noqa: S101 - the caller returns before
    shown, chosen = shown_part(result), _styles(result)
    x, drawn = result.spectra.frequency[shown], []
    ratio, factor = "", 1.0
    for row, i in enumerate(result.responses):
        if result.channels[i].unit != unit:
            continue
        ratio, factor = shown_ratio(*result.units_of_response(i))
        gain = np.where(against.valid, factor * np.abs(against.h1[row]), np.nan)[shown]
        root = np.where(against.valid, factor * np.sqrt(against.psd_ratio[row]), np.nan)[shown]
        label = f"{result.channels[i].name} |H1|"
        axis.plot(x, _positive(gain), label=label, **style.line(chosen[i]))
        axis.plot(x, _positive(root), color=style.COLOURS[chosen[i]], lw=0.6)
        drawn += [gain, root]
    _decades(axis, drawn)
    axis.set_ylabel(f"response over control [{ratio or '-'}]")
    style.legend(axis)


def coherence(result: RunResult, title: str) -> "Figure | None":
    """Return the coherence of every response, multiple coherence thin where it differs."""
    if result.against is None or result.test.excitation == "sine":
        return None
    figure, (axis,) = style.figure(7.0, 2.9, left=LEFT)
    _draw_coherence(axis, result)
    _head(
        axis,
        result,
        title,
        "coherence with the mean control; thin: multiple, with all controls",
    )
    return figure


def _draw_coherence(axis: "Axes", result: RunResult) -> None:
    against = result.against
    assert against is not None  # noqa: S101 - the callers return before
    shown, chosen = shown_part(result), _styles(result)
    x = result.spectra.frequency[shown]
    for row, i in enumerate(result.responses):
        ordinary = np.where(against.valid, against.coherence[row], np.nan)[shown]
        axis.plot(x, ordinary, label=result.channels[i].name, **style.line(chosen[i]))
        if len(result.controls) > 1:
            multiple = np.where(against.valid, against.multiple_coherence[row], np.nan)[shown]
            axis.plot(x, multiple, color=style.COLOURS[chosen[i]], lw=0.6)
    axis.set_ylim(0.0, 1.05)
    axis.set_ylabel("coherence [-]")
    style.legend(axis)
    _frequency_axis(axis, result)


def psd_and_response(result: RunResult, title: str) -> "Figure | None":
    """Return the thesis' two-in-one figure: densities above, PSD ratio below.

    At a single frequency a ratio of densities says nothing: the harmonics stand there instead.
    """
    single = result.test.excitation == "sine"
    if result.against is None or (single and not result.tracking.tones):
        return None
    figure, (above, below) = style.figure(7.0, 6.2, 2, sharex=not single, left=LEFT)
    _draw_psd(above, result, result.channels[result.controls[0]].unit)
    _head(above, result, title, _worth(result))
    if single:
        _draw_harmonics(below, result)
    else:
        above.set_xlabel("")
        _draw_psd_ratio(below, result)
    return figure


def _draw_psd_ratio(axis: "Axes", result: RunResult) -> None:
    against = result.against
    assert against is not None  # noqa: S101 - the caller returns before
    shown, chosen = shown_part(result), _styles(result)
    x = result.spectra.frequency[shown]
    for row, i in enumerate(result.responses):
        ratio = np.where(against.valid, against.psd_ratio[row], np.nan)[shown]
        axis.plot(x, _positive(ratio), **style.line(chosen[i]))
    _decades(axis, [r[shown][against.valid[shown]] for r in against.psd_ratio])
    axis.set_ylabel("PSD ratio [-]")
    _frequency_axis(axis, result)


def _draw_harmonics(axis: "Axes", result: RunResult) -> None:
    """Draw the amplitude of the tone and its harmonics in each channel, side by side."""
    tone, chosen = result.tracking.tones[0], _styles(result)
    count, number = len(result.channels), np.arange(1, tone.harmonics.shape[1] + 1)
    heights = []
    for i, channel in enumerate(result.channels):
        heights.append(np.abs(tone.harmonics[i]) * shown_unit(channel.unit)[1])
        place = number + 0.8 * ((i + 0.5) / count - 0.5)
        axis.bar(place, heights[-1], 0.8 / count, color=style.COLOURS[chosen[i] % 8])
    _decades(axis, heights, 6)
    axis.set_xticks(number, [f"{k} x {tone.frequency:.4g} Hz" for k in number])
    unit = {shown_unit(c.unit)[0] for c in result.channels}
    axis.set_ylabel(f"amplitude [{unit.pop() if len(unit) == 1 else 'unit'}]")
    axis.set_xlabel("harmonic")


def notched(result: RunResult, title: str) -> "Figure | None":
    """Return two periods before and after the tone was taken out (figures 5.41 to 5.44)."""
    notch = result.notch
    if notch is None:
        return None
    n = len(result.responses)
    figure, axes = style.figure(7.0, 0.9 + 1.1 * n, n, sharex=True, left=LEFT)
    chosen = _styles(result)
    for row, (axis, i) in enumerate(zip(axes, result.responses, strict=True)):
        unit, factor = shown_unit(result.channels[i].unit)
        axis.plot(
            notch.time, notch.before[row] * factor, color="#767676", lw=1.0, label="before"
        )
        axis.plot(notch.time, notch.after[row] * factor, label="after", **style.line(chosen[i]))
        style.name(axis, result.channels[i].name, unit)
    _head(axes[0], result, title, f"two periods, {notch.frequency:g} Hz taken out")
    style.legend(axes[0])
    axes[-1].set_xlabel("time [s]")
    return figure


def notched_psd(result: RunResult, title: str) -> "Figure | None":
    """Return the density of each response with and without the tone (figures 5.43 and 5.44)."""
    notch = result.notch
    if notch is None:
        return None
    n = len(result.responses)
    figure, axes = style.figure(7.0, 0.5 + 1.8 * n, n, sharex=True, left=LEFT)
    chosen, shown = _styles(result), shown_part(result)
    x = result.spectra.frequency[shown]
    for row, (axis, i) in enumerate(zip(axes, result.responses, strict=True)):
        unit, factor = shown_unit(result.channels[i].unit)
        before = _positive(result.psd[i, shown] * factor**2)
        after = _positive(notch.psd[row, shown] * factor**2)
        axis.plot(x, before, color="#767676", lw=1.0, label="before")
        axis.plot(x, after, label="after", **style.line(chosen[i]))
        _decades(axis, [before, after])
        style.name(axis, result.channels[i].name, f"{unit}²/Hz")
    _head(axes[0], result, title, f"PSD, {notch.frequency:g} Hz taken out")
    style.legend(axes[0])
    _frequency_axis(axes[-1], result)
    return figure


def sweep(result: RunResult, title: str) -> "Figure | None":
    """Return the fundamental along each sweep, and the harmonics of the loudest response."""
    sweeps, loudest = result.tracking.sweeps, result.loudest
    if not sweeps or loudest not in result.responses:
        return None
    figure, (gain, phase, below) = style.figure(7.0, 6.6, 3, sharex=True, left=LEFT)
    chosen, ratios = _styles(result), []
    for number, one in enumerate(sweeps):
        for i in result.responses:
            label = f"{result.channels[i].name} {one.direction}"
            how = style.line(chosen[i] if len(sweeps) == 1 else number)
            gain.plot(one.frequency, _positive(np.abs(one.gain[i])), label=label, **how)
            phase.plot(one.frequency, unbroken_phase(one.gain[i]), **how)
        fundamental = _positive(np.abs(one.harmonics[loudest, 0]))
        for k in range(1, one.harmonics.shape[1]):
            ratio = _positive(np.abs(one.harmonics[loudest, k]) / fundamental)
            ratios.append(ratio)
            label = f"harmonic {k + 1}" if number == 0 else "_"  # hidden from the legend
            below.plot(one.frequency, ratio, label=label, **style.line(k - 1))
    _decades(gain, [np.abs(s.gain[i]) for s in sweeps for i in result.responses], 5)
    _decades(below, ratios, 6)
    gain.set_ylabel("fundamental over\ncontrol [-]")
    _head(gain, result, title, "swept response" + _spans(result))
    style.legend(gain)
    _phase_axis(phase, "phase of the\nfundamental [°]")
    below.set_ylabel(f"harmonics of {result.channels[loudest].name}\nover its fundamental [-]")
    below.legend(ncols=4, loc="upper right")
    lowest = min(float(s.frequency.min()) for s in sweeps)
    highest = max(float(s.frequency.max()) for s in sweeps)
    below.set_xlim(0.98 * lowest, 1.02 * highest)
    below.set_xlabel("frequency [Hz]")
    return figure


def _spans(result: RunResult) -> str:
    """Return from where to where each sweep goes, in words."""
    told = [
        f"{s.direction} {s.frequency.min():.4g} to {s.frequency.max():.4g} Hz"
        for s in result.tracking.sweeps
    ]
    return f": {', '.join(told)}" if len(told) <= 4 else f", {len(told)} sweeps"


def _phase_axis(axis: "Axes", label: str) -> None:
    axis.set_ylabel(label)
    axis.set_ylim(-275.0, 95.0)
    axis.set_yticks([-270, -180, -90, 0, 90])


def spectrogram(result: RunResult, title: str) -> "Figure | None":
    """Return the density of the loudest response against time and frequency."""
    found = result.spectrogram
    if found is None or found.time.size < 2:
        return None
    figure, (axis,) = style.figure(7.0, 3.6, left=LEFT, legend=False)
    unit, factor = shown_unit(result.channels[result.loudest].unit)
    drawn = found.frequency <= result.spectra.frequency[shown_part(result)][-1]
    decibel = 10.0 * np.log10(np.maximum(found.density[0, drawn] * factor**2, 1e-30))
    start = result.crop.start / result.sample_rate
    image = axis.imshow(
        decibel,
        origin="lower",
        aspect="auto",
        extent=(
            start + found.time[0],
            start + found.time[-1],
            found.frequency[0],
            found.frequency[drawn][-1],
        ),
        vmin=float(decibel.max()) - 80.0,
        vmax=float(decibel.max()),
        cmap="viridis",
        interpolation="nearest",
    )
    axis.grid(visible=False)
    axis.set_ylim(0.0, float(found.frequency[drawn][-1]))
    axis.set_xlabel("time [s]")
    axis.set_ylabel("frequency [Hz]")
    bar = figure.colorbar(image, ax=axis, pad=0.02)
    bar.set_label(f"dB re 1 {unit}²/Hz")
    _head(
        axis,
        result,
        title,
        f"spectrogram of {result.channels[result.loudest].name}",
        legend=False,
    )
    return figure


FIGURES: Mapping[str, Callable[[RunResult, str], "Figure | None"]] = MappingProxyType({
    "time": time_series,
    "psd": psd,
    "response": response,
    "coherence": coherence,
    "psd_and_response": psd_and_response,
    "notch": notched,
    "notch_psd": notched_psd,
    "sweep": sweep,
    "spectrogram": spectrogram,
})
