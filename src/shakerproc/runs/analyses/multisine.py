"""Multisines: response function, noise, even and odd distortion of every line."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final, final

import numpy as np

from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, lone_force, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.spectra.multisines import (
    Kind,
    LineGrid,
    LineSpectra,
    PeriodLayout,
    Share,
    check_input,
    cut,
    grid_of,
    layout_of,
    line_spectra,
    shares_of,
    transient_periods,
)
from shakerproc.testlog import Multisine

LONGEST: Final = 2**25
"""Samples of all channels together that are read at most, 256 MiB [-]."""

NAMES: Final[Mapping[Kind, str]] = {
    "even": "even distortion",
    "odd": "odd distortion",
    "all": "distortion over the realisations",
}
"""What each kind is called."""

HINTS: Final[Mapping[Kind, str]] = {
    "even": "even: a law that differs between push and pull",
    "odd": "odd: a law that is the same both ways: a hardening spring, play, friction",
}
"""What a kind of distortion is a sign of."""

DRAWN: Final = 8
"""Responses that are drawn at most [-]."""

SMOOTHED: Final = 60
"""Points that a curve of noise or distortion is smoothed to, as far as there are more [-]."""

NOTHING: Final = "Multisine: not known"
"""Title where nothing can be said."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class MultisineReading:
    """Responses of a multisine test at every line.

    Attributes
    ----------
    grid : LineGrid
        The lines.
    layout : PeriodLayout
        Which periods were used.
    input : tuple of int
        Rows whose mean is the input.
    rows : tuple of int
        Rows of the responses.
    spectra : tuple of LineSpectra
        Of each response [SI].
    """

    grid: LineGrid
    layout: PeriodLayout
    input: tuple[int, ...]
    rows: tuple[int, ...]
    spectra: tuple[LineSpectra, ...]


def read_multisine(
    recording: Recording, result: RunResult, said: Multisine
) -> MultisineReading:
    """Return the responses of a multisine test at every line.

    Parameters
    ----------
    recording : Recording
        Open.
    result : RunResult
        What is known of the run already.
    said : Multisine
        How the multisine repeats.

    Raises
    ------
    SpectrumError
        If there is no input or no response, or the run does not repeat as the log says.
    """
    driving, rows = _roles(result)
    crop, rate = result.crop, result.recorded.sample_rate
    if crop.n_samples * len(result.channels) > LONGEST:
        raise SpectrumError(
            f"{numeral(crop.n_samples / rate)} s of {len(result.channels)} channels are too "
            "long to "
            "be read as one multisine; crop: {from: ..., to: ...} to fewer realisations"
        )
    layout = layout_of(
        crop.n_samples,
        rate,
        said.period,
        periods=said.periods,
        realisations=said.realisations,
        every=said.every,
    )
    samples = recording.samples(crop.start, crop.stop)
    force = samples[list(driving)].mean(axis=0)
    used = np.concatenate([force[np.newaxis], samples[list(rows)]])
    spacing, band = rate / layout.n_period, result.band
    first = max(1, int(np.ceil(band[0] / spacing - 1e-6)))
    last = min((layout.n_period - 1) // 2, int(band[1] / spacing + 1e-6))
    lines = 2.0 / layout.n_period * np.fft.rfft(cut(used, layout))[..., first : last + 1]
    layout = layout.without(transient_periods(lines))
    check_input(force, layout, rate)
    lines = lines[:, :, layout.left_out :]
    grid = grid_of(lines[0], spacing, band, first)
    kept = lines[..., grid.number - first]
    spectra = tuple(line_spectra(kept[0], one, grid) for one in kept[1:])
    return MultisineReading(grid, layout, driving, rows, spectra)


def _roles(result: RunResult) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the rows of the input and of the responses.

    Raises
    ------
    SpectrumError
        If there are none.
    """
    force = lone_force(result.channels)
    driving = result.controls or (() if force is None else (force,))
    rows = tuple(i for i in range(len(result.channels)) if i not in driving)
    if not driving or not rows:
        there = ", ".join(f"{c.name} ({c.role})" for c in result.channels)
        raise SpectrumError(
            "a multisine test needs controls or one force as its input, and a response; there "
            f"are {there}; correct the roles under channels: in the log"
        )
    return driving, rows


def moving_rms(values: FloatArray, width: int) -> FloatArray:
    """Return the root mean square over so many neighbours, (n,) array in the same unit."""
    kernel = np.ones(min(width, values.size))
    counts = np.convolve(np.ones(values.size), kernel, "same")
    result: FloatArray = np.sqrt(np.convolve(values**2, kernel, "same") / counts)
    return result


def sentence(
    name: str,
    shares: Mapping[Kind, Share],
    noise: float | None,
    band: tuple[float, float],
) -> str:
    """Return whether a response is linear, and within how much, else how it is distorted.

    Parameters
    ----------
    name : str
        The response.
    shares : mapping
        What is known of each kind of distortion.
    noise : float, optional
        Share of the response that does not repeat [-]; None where it is not known.
    band : (float, float)
        First and last excited line [Hz].
    """
    where = f"{name}, {numeral(band[0], 4)} to {numeral(band[1], 4)} Hz"
    if not shares:
        text = "is not known" if noise is None else f"{_percent(noise)} of the response"
        return f"{where}: noise {text}; distortion is not known."
    if noise is None:
        parts = [f"{NAMES[one.kind]} {_percent(one.value)}" for one in shares.values()]
        return f"{where}: {', '.join(parts)} of the response (rms), with the noise in them."
    distorted = [one for one in shares.values() if one.bands]
    noise_text = f"noise {_percent(noise)}"
    if not distorted:
        most = max(one.limit for one in shares.values())
        return f"{where}: linear within {_percent(most)} of the response; {noise_text}."
    rest = [one for one in shares.values() if not one.bands]
    parts = [
        f"{NAMES[one.kind]} of {_percent(one.value)} of the response (rms), out of the noise "
        f"{_bands(one)}, {_percent(one.largest)} at {numeral(one.at, 4)} Hz"
        for one in distorted
    ]
    parts += [f"{NAMES[one.kind]} below {_percent(one.limit)}" for one in rest]
    parts.append(noise_text)
    hints = [HINTS[one.kind] for one in distorted if one.kind in HINTS]
    return f"{where}: {'; '.join(parts)}.{f' {_first_upper(hints)}.' if hints else ''}"


def _first_upper(hints: list[str]) -> str:
    text = "; ".join(hints)
    return text[:1].upper() + text[1:]


def _percent(share: float) -> str:
    return f"{numeral(100.0 * share, 2)} %"


def _bands(share: Share) -> str:
    first = [
        f"from {numeral(low, 4)} to {numeral(high, 4)} Hz" for low, high in share.bands[:3]
    ]
    more = len(share.bands) - len(first)
    return " and ".join(first) + (f" and in {more} more bands" if more else "")


def about(reading: MultisineReading) -> Iterator[str]:
    """Yield sentences on the data in use, and on figures that are not available."""
    layout, grid = reading.layout, reading.grid
    used = layout.periods - layout.left_out
    spacing = grid.frequency[0] / grid.number[0]
    yield (
        f"{layout.realisations} realisation{'s' * (layout.realisations > 1)} of {used} "
        f"period{'s' * (used > 1)} of {1.0 / spacing:.6g} s. {int(grid.excited.sum())} of "
        f"{grid.number.size} lines from {numeral(grid.frequency[0], 4)} to "
        f"{numeral(grid.frequency[-1], 4)} Hz are excited, {numeral(spacing, 4)} Hz apart; "
        f"{int(grid.even.sum())} even and {int(grid.odd.sum())} odd ones detect distortion."
    )
    if not grid.common:
        yield _shared_lines(grid)
    if layout.left_out:
        yield (
            f"The first {layout.left_out} of {layout.periods} periods do not repeat (a "
            "transient) and are left out."
        )
    elif layout.periods == 2:
        yield "Two periods do not tell whether the first still holds a transient."
    if layout.realisations == 1:
        yield (
            "One realisation: distortion at the excited lines is not known; two or more tell "
            "it, seven tell it within 3 dB."
        )
    if not grid.even.any():
        yield _no_detection(reading)


def problems(reading: MultisineReading) -> Iterator[str]:
    """Yield the reasons why a measurement does not tell noise or distortion."""
    if reading.layout.periods - reading.layout.left_out == 1:
        yield (
            "one period only: the noise is not known, and distortion holds it; record two "
            "periods or more of each realisation, better eight"
        )
    if reading.grid.even.any() or np.any(reading.grid.n_exciting > 1):
        return
    alone = "one realisation" if reading.layout.realisations == 1 else "no line excited twice"
    yield (
        f"no detection lines and {alone}: noise is known and distortion is not. "
        "Excite odd lines only and leave some of them out, or record several realisations of "
        "the same lines"
    )


def _shared_lines(grid: LineGrid) -> str:
    """Return how far the realisations share their lines."""
    shared = int(np.sum(grid.n_exciting > 1))
    each = grid.excited_in.sum(axis=1)
    text = (
        f"Each realisation excites lines of its own, {each.min()} to {each.max()} of them; "
        f"{shared} are excited in two or more"
    )
    if not shared:
        return f"{text}: distortion at the excited lines is not known."
    return f"{text} and tell the scatter. Each line is averaged over the realisations it has."


def _no_detection(reading: MultisineReading) -> str:
    if reading.grid.excited_in.all():
        return (
            "No detection lines: every line is excited, so that even and odd distortion are "
            "not told apart."
        )
    return (
        "No detection lines: even lines are excited too, so that even and odd distortion are "
        "not told apart."
    )


@final
class MultisineAnalysis(AbstractAnalysis):
    """Response function, noise and distortion of a multisine test, before any model."""

    kind: ClassVar[str] = "multisine"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the analysis of every line; None of other tests. A failure is a flag."""
        said = result.test.multisine
        if result.test.excitation != "multisine" or said is None:
            return None
        try:
            reading = read_multisine(recording, result, said)
        except SpectrumError as error:
            return Analysis(self.kind, NOTHING, {}, (), (), (str(error),), (str(error),))
        shares = [shares_of(one) for one in reading.spectra]
        band = (float(reading.grid.frequency[0]), float(reading.grid.frequency[-1]))
        names = [result.channels[row].name for row in reading.rows]
        return Analysis(
            kind=self.kind,
            title="Multisine: response function, noise and distortion",
            columns=_columns(reading, result),
            summary=tuple(
                _row(*one) for one in zip(names, reading.spectra, shares, strict=True)
            ),
            panels=tuple(
                _panel(i, reading, result) for i in range(min(len(reading.rows), DRAWN))
            ),
            sentences=(
                *(
                    sentence(name, share, one.noise_share, band)
                    for name, share, one in zip(names, shares, reading.spectra, strict=True)
                ),
                *about(reading),
            ),
            problems=tuple(problems(reading)),
        )


def _driving(reading: MultisineReading, result: RunResult) -> tuple[str, Channel]:
    """Return the name of the input, and a channel of it."""
    first = result.channels[reading.input[0]]
    return (first.name if len(reading.input) == 1 else "controls"), first


def _columns(reading: MultisineReading, result: RunResult) -> dict[str, Any]:
    """Return the table: a row for each line."""
    grid = reading.grid
    name, channel = _driving(reading, result)
    unit, factor = shown_unit(channel.unit)
    kinds = np.where(grid.excited, "excited", np.where(grid.number % 2 == 0, "even", "odd"))
    columns: dict[str, Any] = {
        "line": grid.number,
        "frequency_hz": grid.frequency,
        "kind": kinds.astype(object),
        "excited_realisations": grid.n_exciting,
        f"input_{name}{spelled(unit)}": np.where(
            grid.excited, factor * reading.spectra[0].input, np.nan
        ),
    }
    for row, one in zip(reading.rows, reading.spectra, strict=True):
        response = result.channels[row]
        of, scale = shown_unit(response.unit)
        ratio = "" if of == unit else f"{spelled(of)}_per{spelled(unit)}"
        function = np.where(grid.excited, one.function, np.nan) * scale / factor
        over = f"{response.name}_over_{name}"
        columns[f"magnitude_{over}{ratio}"] = np.abs(function)
        columns[f"phase_{over}_deg"] = np.degrees(np.angle(function))
        for what, values in (
            ("response", one.level),
            ("noise", one.noise),
            ("distortion_and_noise", one.distortion),
            ("scatter", one.scatter),
        ):
            columns[f"{what}_{response.name}{spelled(of)}"] = scale * values
    return columns


def _row(name: str, spectra: LineSpectra, shares: Mapping[Kind, Share]) -> dict[str, Cell]:
    """Return a response in one line, everything as a share of its rms at excited lines."""
    excited = spectra.grid.excited
    noise = spectra.noise_share
    cells: dict[str, Cell] = {
        "channel": name,
        "from_hz": float(spectra.grid.frequency[0]),
        "to_hz": float(spectra.grid.frequency[-1]),
        "excited_lines": float(excited.sum()),
        "realisations": float(spectra.realisations),
        "periods": float(spectra.periods),
        "noise_percent": None if noise is None else 100.0 * noise,
    }
    kinds: tuple[Kind, ...] = ("even", "odd", "all")
    for kind in kinds:
        share = shares.get(kind)
        called = "scatter" if kind == "all" else kind
        cells[f"{called}_percent"] = None if share is None else 100.0 * share.value
        cells[f"{called}_limit_percent"] = None if share is None else 100.0 * share.limit
        cells[f"{called}_stands_out"] = None if share is None else bool(share.bands)
    return cells


def _panel(i: int, reading: MultisineReading, result: RunResult) -> Panel:
    """Return the response function, and below it noise and distortion over the input."""
    one, grid = reading.spectra[i], reading.grid
    name, channel = _driving(reading, result)
    response = result.channels[reading.rows[i]]
    (out_unit, out_factor), (in_unit, in_factor) = (
        shown_unit(response.unit),
        shown_unit(channel.unit),
    )
    scale = out_factor / in_factor
    unit = "-" if response.unit == channel.unit else f"{out_unit}/{in_unit}"
    curves = [("response function", grid.excited, np.abs(one.function[grid.excited]))]
    every = np.ones(grid.number.size, dtype=bool)
    for label, chosen, values in (
        ("noise", every, one.noise),
        ("even distortion", grid.even, one.distortion),
        ("odd distortion", grid.odd, one.distortion),
        ("scatter of realisations", grid.n_exciting > 1, one.scatter),
    ):
        if chosen.any() and not np.isnan(values[chosen]).any():
            width = max(1, int(chosen.sum()) // SMOOTHED)
            curves.append((label, chosen, moving_rms((values / one.input)[chosen], width)))
    lines = [
        PanelLine(label, grid.frequency[chosen], scale * values, style=style)
        for style, (label, chosen, values) in enumerate(curves)
    ]
    return Panel(
        f"multisine_{i + 1}",
        f"{response.name} over {name}: response function, noise and distortion",
        "Noise (of the mean over the periods of a realisation) and distortion, over the "
        "amplitude of the input; root mean squares of neighbouring lines. What lies on the "
        "noise is noise.",
        PanelScale("frequency [Hz]"),
        PanelScale(f"{response.name} over {name} [{unit}]"),
        tuple(lines),
    )
