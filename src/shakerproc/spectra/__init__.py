"""Signal processing, arrays in and arrays out: crop, Welch engine, responses, peaks, sweeps."""

from shakerproc.spectra.bounds import (
    Bounds,
    gain_random_error,
    psd_bounds,
    response_bounds,
)
from shakerproc.spectra.crop import (
    Crop,
    ThresholdNotReachedError,
    crop_by_threshold,
    crop_by_time,
    sample_at,
)
from shakerproc.spectra.cross import CrossSpectra, Detrend
from shakerproc.spectra.damping import (
    Damping,
    damping_of_density,
    damping_of_response,
    half_power_ratio,
    is_resolved,
)
from shakerproc.spectra.description import Statistics, statistics
from shakerproc.spectra.engine import cross_spectra
from shakerproc.spectra.levels import (
    Imbalance,
    control_imbalance,
    cumulative_rms,
    rms_in_band,
)
from shakerproc.spectra.lines import Line, beside_lines, steady_lines
from shakerproc.spectra.masks import driven, excited, masked
from shakerproc.spectra.notch_filters import Notched, notch, thesis_notch
from shakerproc.spectra.passing import SweptMode, fastest_rate, swept_mode
from shakerproc.spectra.peaks import Peak, effective_frequencies, find_peaks
from shakerproc.spectra.periodograms import periodogram
from shakerproc.spectra.responses import (
    coherence,
    h1,
    h1_of_inputs,
    h2,
    hv,
    multiple_coherence,
    psd,
    psd_ratio,
)
from shakerproc.spectra.spectrograms import Spectrogram, spectrogram
from shakerproc.spectra.swept import Sweep, stitched, swept_response
from shakerproc.spectra.thesis import (
    Table,
    ThesisPeak,
    ThesisSettings,
    ThesisTables,
    thesis_tables,
)
from shakerproc.spectra.tones import Tone, stepped_response, tone_response
from shakerproc.spectra.windows import COSINE_TERMS, effective_averages, window_samples

__all__ = [
    "COSINE_TERMS",
    "Bounds",
    "Crop",
    "CrossSpectra",
    "Damping",
    "Detrend",
    "Imbalance",
    "Line",
    "Notched",
    "Peak",
    "Spectrogram",
    "Statistics",
    "Sweep",
    "SweptMode",
    "Table",
    "ThesisPeak",
    "ThesisSettings",
    "ThesisTables",
    "ThresholdNotReachedError",
    "Tone",
    "beside_lines",
    "coherence",
    "control_imbalance",
    "crop_by_threshold",
    "crop_by_time",
    "cross_spectra",
    "cumulative_rms",
    "damping_of_density",
    "damping_of_response",
    "driven",
    "effective_averages",
    "effective_frequencies",
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
    "masked",
    "multiple_coherence",
    "notch",
    "periodogram",
    "psd",
    "psd_bounds",
    "psd_ratio",
    "response_bounds",
    "rms_in_band",
    "sample_at",
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
