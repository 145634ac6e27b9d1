"""Free decays: the modes of one, and frequency and damping of each against its amplitude."""

from shakerproc.spectra.decays.curves import DecayCurve, decay_curve
from shakerproc.spectra.decays.free_part import free_start
from shakerproc.spectra.decays.line import DecayLine
from shakerproc.spectra.decays.lines import decay_lines
from shakerproc.spectra.decays.reading import Reading
from shakerproc.spectra.decays.trend import DecayTrend, at_amplitudes, trend_of

__all__ = [
    "DecayCurve",
    "DecayLine",
    "DecayTrend",
    "Reading",
    "at_amplitudes",
    "decay_curve",
    "decay_lines",
    "free_start",
    "trend_of",
]
