"""Signal processing, arrays in and arrays out: crop, Welch engine, responses, peaks, sweeps."""

from shakerproc.spectra.crop import (
    Crop,
    ThresholdNotReachedError,
    crop_by_threshold,
    crop_by_time,
    sample_at,
)
from shakerproc.spectra.peaks.damping import (
    Damping,
    damping_of_density,
    damping_of_response,
    half_power_ratio,
    is_resolved,
    longer_may_resolve,
    resonance_width,
    smeared_height,
)
from shakerproc.spectra.peaks.finding import Peak, find_peaks
from shakerproc.spectra.responses.bounds import (
    Bounds,
    gain_random_error,
    psd_bounds,
    response_bounds,
)
from shakerproc.spectra.responses.estimators import (
    coherence,
    conditioned,
    driven,
    excited,
    h1,
    h1_of_inputs,
    h2,
    hv,
    masked,
    multiple_coherence,
    psd_ratio,
)
from shakerproc.spectra.thesis import (
    ThesisPeak,
    ThesisSettings,
    ThesisTable,
    ThesisTables,
    thesis_tables,
)
from shakerproc.spectra.tones.lines import SpectralLine, clear_of_lines, steady_lines
from shakerproc.spectra.tones.notch_filters import Notched, notch, thesis_notch
from shakerproc.spectra.tones.passing import SweptMode, fastest_rate, swept_mode
from shakerproc.spectra.tones.steady import Tone, stepped_response, tone_response
from shakerproc.spectra.tones.swept import Sweep, stitched, swept_response
from shakerproc.spectra.welch.blocks import Statistics, statistics
from shakerproc.spectra.welch.cross import (
    CrossSpectra,
    Detrend,
    Imbalance,
    control_imbalance,
    cumulative_rms,
    psd,
    rms_in_band,
)
from shakerproc.spectra.welch.engine import cross_spectra
from shakerproc.spectra.welch.spectrograms import Spectrogram, periodogram, spectrogram
from shakerproc.spectra.welch.windows import COSINE_TERMS, effective_averages, window_samples

__all__ = [
    "COSINE_TERMS",
    "Bounds",
    "Crop",
    "CrossSpectra",
    "Damping",
    "Detrend",
    "Imbalance",
    "Notched",
    "Peak",
    "SpectralLine",
    "Spectrogram",
    "Statistics",
    "Sweep",
    "SweptMode",
    "ThesisPeak",
    "ThesisSettings",
    "ThesisTable",
    "ThesisTables",
    "ThresholdNotReachedError",
    "Tone",
    "clear_of_lines",
    "coherence",
    "conditioned",
    "control_imbalance",
    "crop_by_threshold",
    "crop_by_time",
    "cross_spectra",
    "cumulative_rms",
    "damping_of_density",
    "damping_of_response",
    "driven",
    "effective_averages",
    "excited",
    "fastest_rate",
    "find_peaks",
    "gain_random_error",
    "h1",
    "h1_of_inputs",
    "h2",
    "half_power_ratio",
    "hv",
    "is_resolved",
    "longer_may_resolve",
    "masked",
    "multiple_coherence",
    "notch",
    "periodogram",
    "psd",
    "psd_bounds",
    "psd_ratio",
    "resonance_width",
    "response_bounds",
    "rms_in_band",
    "sample_at",
    "smeared_height",
    "spectrogram",
    "statistics",
    "steady_lines",
    "stepped_response",
    "stitched",
    "swept_mode",
    "swept_response",
    "thesis_notch",
    "thesis_tables",
    "tone_response",
    "window_samples",
]
