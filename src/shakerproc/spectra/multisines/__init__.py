"""Multisines: response function, noise, even and odd distortion, before any model."""

from shakerproc.spectra.multisines.judging import Share, shares_of
from shakerproc.spectra.multisines.lines import Grid, grid_of
from shakerproc.spectra.multisines.measuring import LineSpectra, line_spectra
from shakerproc.spectra.multisines.periods import (
    PeriodLayout,
    cut,
    layout_of,
    samples_of_period,
    settled,
)

__all__ = [
    "Grid",
    "LineSpectra",
    "PeriodLayout",
    "Share",
    "cut",
    "grid_of",
    "layout_of",
    "line_spectra",
    "samples_of_period",
    "settled",
    "shares_of",
]
