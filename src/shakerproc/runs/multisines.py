"""The periods of a multisine test: cut, settled ones kept, and every response read."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.result import RunResult, lone_force
from shakerproc.spectra.multisines import (
    LineGrid,
    LineSpectra,
    PeriodLayout,
    cut,
    grid_of,
    layout_of,
    line_spectra,
    transient_periods,
)
from shakerproc.spectra.multisines.periods import check_input
from shakerproc.testlog import Multisine

LONGEST: Final = 2**25
"""Samples of all channels together that are read at most, 256 MiB [-]."""


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
    crop, rate = result.crop, result.sample_rate
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
