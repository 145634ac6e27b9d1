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
from shakerproc.spectra.responses import (
    Bounds,
    coherence,
    conditioned,
    driven,
    gain_random_error,
    h1,
    h1_of_inputs,
    h2,
    hv,
    masked,
    multiple_coherence,
    psd_bounds,
    psd_ratio,
    response_bounds,
)
from shakerproc.spectra.thesis import ThesisSettings, ThesisTables, thesis_tables
from shakerproc.spectra.tones.lines import SpectralLine, clear_of_lines, steady_lines
from shakerproc.spectra.tones.notch_filters import notch, thesis_notch
from shakerproc.spectra.tones.passing import fastest_rate, swept_mode
from shakerproc.spectra.tones.steady import Tone, stepped_response, tone_response
from shakerproc.spectra.tones.swept import Sweep, stitched, swept_response
from shakerproc.spectra.welch.blocks import Statistics, statistics
from shakerproc.spectra.welch.cross import (
    CrossSpectra,
    Imbalance,
    control_imbalance,
    cumulative_rms,
    psd,
    rms_in_band,
)
from shakerproc.spectra.welch.engine import cross_spectra
from shakerproc.spectra.welch.spectrograms import Spectrogram, periodogram, spectrogram
from shakerproc.spectra.welch.windows import effective_averages, window_samples
