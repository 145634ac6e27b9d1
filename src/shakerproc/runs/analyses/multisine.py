"""Multisines: response function, noise, even and odd distortion of every line."""

from collections.abc import Mapping
from typing import Any, ClassVar, Final, final

import numpy as np

from shakerproc.data import Channel, Recording
from shakerproc.errors import SpectrumError
from shakerproc.runs.analyses.base import AbstractAnalysis
from shakerproc.runs.analyses.multisine_words import about, problems, sentence
from shakerproc.runs.analysis import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.multisines import MultisineReading, moving_rms, read_multisine
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.spectra.multisines import LineSpectra, Share, shares_of
from shakerproc.spectra.multisines.distortion import Kind

DRAWN: Final = 8
"""Responses that are drawn at most [-]."""

SMOOTHED: Final = 60
"""Points that a curve of noise or distortion is smoothed to, as far as there are more [-]."""

NOTHING: Final = "Multisine: not known"
"""Title where nothing can be said."""


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
            told=(
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
        "excited_realisations": grid.carried,
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
        ("scatter of realisations", grid.carried > 1, one.scatter),
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
