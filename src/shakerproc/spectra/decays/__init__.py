"""Free decays: the modes of one, and frequency and damping of each against its amplitude."""

from shakerproc.spectra.decays.curves import (
    DecayCurve,
    DecayTrend,
    at_amplitudes,
    decay_curve,
    trend_of,
)
from shakerproc.spectra.decays.lines import DecayLine, decay_lines, free_start
from shakerproc.spectra.decays.readings import DecayReading
