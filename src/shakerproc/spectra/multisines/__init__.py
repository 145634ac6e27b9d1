"""Multisines: response function, noise, even and odd distortion, before any model."""

from shakerproc.spectra.multisines.distortion import LineSpectra, Share, line_spectra, shares_of
from shakerproc.spectra.multisines.periods import (
    LineGrid,
    PeriodLayout,
    cut,
    grid_of,
    layout_of,
    samples_of_period,
    transient_periods,
)
