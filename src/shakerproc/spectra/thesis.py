"""The tables of the thesis' scripts: to the letter, or without padding and its sample rate."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.crop import Crop, crop_by_threshold
from shakerproc.spectra.peaks.finding import thesis_peaks
from shakerproc.spectra.responses import coherence, psd_ratio
from shakerproc.spectra.tones.notch_filters import thesis_notch
from shakerproc.spectra.welch.cross import CrossSpectra, Detrend, psd
from shakerproc.spectra.welch.engine import cross_spectra
from shakerproc.spectra.welch.spectrograms import periodogram

Mode: TypeAlias = Literal["thesis", "corrected"]

THRESHOLD: Final = 0.45 * STANDARD_GRAVITY
"""Value of control 2 between which the run lies [m/s²]."""


PERIODOGRAM_STRIDE: Final = 97
EXCERPT: Final = 3000
"""Samples of the filtered signal that its table shows from the start, middle and end."""

LOWEST: Final = 25.0
"""Frequency below which the thesis deletes PSD peaks [Hz]."""

LONGER: Final = 2
"""How many times longer the thesis' segments are after the filter than before it [-]."""


@final
@dataclass(frozen=True, slots=True)
class ThesisSettings:
    """The numbers that the thesis typed into its scripts; the defaults are the thesis' own.

    Attributes
    ----------
    segment, overlap : int
        Lengths in samples before the filter; after it both are twice as long.
    window : str
        Window of the segments.
    n_fft : int, optional
        Length that segments are padded to before the filter; by default the segment.
    detrend : str
        What mean is removed.
    notch_frequency : float
        Tone that the filter takes out [Hz].
    """

    segment: int = 1024
    overlap: int = 512
    window: str = "hamming"
    n_fft: int | None = None
    detrend: Detrend = "none"
    notch_frequency: float = 50.0

    def spectra(self, data: FloatArray, rate: float, times: int = 1) -> CrossSpectra:
        """Return the cross spectra with segments so many times longer.

        `data` is in the units of the channels, `rate` in [Hz].
        """
        return cross_spectra(
            data,
            rate,
            segment=times * self.segment,
            overlap=times * self.overlap,
            n_fft=None if self.n_fft is None else times * self.n_fft,
            window=self.window,
            detrend=self.detrend,
        )


@final
@dataclass(frozen=True, slots=True, eq=False)
class ThesisTable:
    """One table: an index and named columns of the same length.

    Attributes
    ----------
    index_name : str
        ``frequency_hz`` or ``sample_0based``.
    index : (n_rows,) array
        What the rows are.
    columns : mapping of str to (n_rows,) array
        Values by channel; ``ch1`` to ``ch5`` unless other names are given.
    """

    index_name: str
    index: FloatArray
    columns: Mapping[str, FloatArray]


@final
@dataclass(frozen=True, slots=True)
class ThesisPeak:
    """One peak by the thesis' rule.

    Attributes
    ----------
    quantity : str
        ``psd`` (of which the logarithm is searched) or ``frf`` (the PSD ratio).
    channel : str
        ``ch3`` and so on.
    used_by_thesis : bool
        Whether the thesis looks at this channel for this quantity: PSD of the second
        response (ch4), FRF of the first (ch3).
    rank_by_location : int
        1 is the lowest frequency, the one that the thesis reports.
    frequency : float
        Middle of the bin [Hz].
    value : float
        log10 of the PSD [g²/Hz], or the ratio [-].
    deleted : bool
        Whether the thesis drops it for lying below 25 Hz, as it does for the PSD only.
    """

    quantity: str
    channel: str
    used_by_thesis: bool
    rank_by_location: int
    frequency: float
    value: float
    deleted: bool


@final
@dataclass(frozen=True, slots=True, eq=False)
class ThesisTables:
    """All tables of one recording.

    Attributes
    ----------
    mode : str
        ``thesis`` or ``corrected``.
    crop : mapping
        What was cropped and the sample rate derived from it.
    tables : mapping of str to ThesisTable
        psd, frf, coherence, notch_psd, notch_frf, notch_coherence, notch_signal and
        periodogram_every97.
    peaks : tuple of ThesisPeak
        Peaks of every response.
    """

    mode: Mode
    crop: Mapping[str, float]
    tables: Mapping[str, ThesisTable]
    peaks: tuple[ThesisPeak, ...]


def thesis_tables(
    samples: FloatArray,
    sample_rate: float,
    *,
    mode: Mode = "thesis",
    crop: Crop | None = None,
    n_controls: int = 2,
    names: Sequence[str] | None = None,
    settings: ThesisSettings | None = None,
) -> ThesisTables:
    """Return the tables that the thesis' scripts make of one recording.

    Mode ``thesis`` follows them to the letter: an odd crop is padded with its last sample and
    the sample rate becomes N/tend, which goes into densities, the filter and the frequencies
    of the coherence. Mode ``corrected`` does neither. Both, unless told otherwise, crop by
    control 2 at 0.45 g, use a symmetric Hamming window of 1024 (2048 after the filter)
    without detrending, divide the response PSD by the mean of the control PSDs and call it
    FRF, and pad the filter by 6.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Accelerations of the whole recording, the controls first, then the responses [m/s²].
    sample_rate : float
        Samples per second [Hz].
    mode : str
        ``thesis`` or ``corrected``.
    crop : Crop, optional
        Which samples are the run; by default those that the thesis' threshold finds.
    n_controls : int
        How many of the channels are controls.
    names : sequence of str, optional
        Names of the channels in the tables; by default ``ch1``, ``ch2`` and so on.
    settings : ThesisSettings, optional
        Segments, window and filter; by default the thesis' own.

    Returns
    -------
    ThesisTables
        Tables in g, as the thesis has them.

    Raises
    ------
    SpectrumError
        If the recording has no control or no response, never reaches 0.45 g on the last of
        its first two controls, or is shorter than a segment.
    ValueError
        If there is no such mode, or not one name for each channel.

    References
    ----------
    .. [1] THESIS, appendix C.
    """
    if mode not in {"thesis", "corrected"}:
        raise ValueError(f"mode must be thesis or corrected, not {mode!r}")
    if not 1 <= n_controls < samples.shape[0]:
        raise SpectrumError(
            f"the thesis needs a control and a response, not {samples.shape[0]} channels of "
            f"which {n_controls} are controls"
        )
    names = names or [f"ch{i + 1}" for i in range(samples.shape[0])]
    if len(names) != samples.shape[0]:
        raise ValueError(f"{samples.shape[0]} channels need as many names, not {len(names)}")
    layout = _Layout(tuple(names), n_controls)
    settings = settings or ThesisSettings()
    crop = crop or crop_by_threshold(samples[min(1, n_controls - 1)], THRESHOLD, sample_rate)
    data = samples[:, crop.start : crop.stop] / STANDARD_GRAVITY
    padded = mode == "thesis" and crop.n_samples % 2 == 1
    if padded:
        data = np.concatenate([data, data[:, -1:]], axis=1)
    end, rate = _end_and_rate(crop.start, crop.stop, data.shape[1], sample_rate, mode)
    without = thesis_notch(data[n_controls:], rate, settings.notch_frequency)
    filtered = np.concatenate([data[:n_controls], without])
    plain = settings.spectra(data, rate)
    notched = settings.spectra(filtered, rate, LONGER)
    tables = {
        **_spectra("", plain, sample_rate, layout),
        **_spectra("notch_", notched, sample_rate, layout),
        "notch_signal": _excerpt(filtered, layout),
        "periodogram_every97": _periodogram(data, rate, sample_rate, layout),
    }
    facts = {
        "n_total": samples.shape[1],
        "start_in_file_0based": crop.start,
        "stop_in_file_0based": crop.stop - 1,
        "cropped_length": crop.n_samples,
        "fs_hz": sample_rate,
        "padded": int(padded),
        "N": data.shape[1],
        "tend": end,
        "Fs": rate,
        f"segments_{plain.segment}": plain.n_segments,
        f"segments_{notched.segment}": notched.n_segments,
    }
    peaks = _all_peaks(tables["psd"], tables["frf"], layout)
    return ThesisTables(mode, facts, tables, peaks)


@final
@dataclass(frozen=True, slots=True)
class _Layout:
    """Names of the channels, the controls first."""

    names: tuple[str, ...]
    n_controls: int

    @property
    def controls(self) -> range:
        return range(self.n_controls)

    @property
    def responses(self) -> range:
        return range(self.n_controls, len(self.names))

    def columns(self, rows: FloatArray, channels: range | None = None) -> dict[str, FloatArray]:
        """Return rows by the names of their channels, by default of all."""
        channels = channels or range(len(self.names))
        return {self.names[i]: row for i, row in zip(channels, rows, strict=True)}


def _end_and_rate(
    start: int, stop: int, n_samples: int, sample_rate: float, mode: Mode
) -> tuple[float, float]:
    """Return the last time [s] and the sample rate derived from it [Hz]."""
    if mode == "corrected":
        return (n_samples - 1) / sample_rate, sample_rate
    end = (stop + 1) / sample_rate - (start + 1) / sample_rate
    return end, n_samples / end


def _spectra(
    prefix: str, spectra: CrossSpectra, sample_rate: float, layout: _Layout
) -> dict[str, ThesisTable]:
    """Return PSD, PSD ratio and coherence, each on the frequency axis that the thesis uses."""
    controls, responses = layout.controls, layout.responses
    axis = spectra.frequency * (sample_rate / spectra.sample_rate)
    ratio = layout.columns(psd_ratio(spectra, controls, responses), responses)
    coherent = layout.columns(coherence(spectra, controls, responses), responses)
    return {
        f"{prefix}psd": ThesisTable("frequency_hz", axis, layout.columns(psd(spectra))),
        f"{prefix}frf": ThesisTable("frequency_hz", axis, ratio),
        f"{prefix}coherence": ThesisTable("frequency_hz", spectra.frequency, coherent),
    }


def _excerpt(filtered: FloatArray, layout: _Layout) -> ThesisTable:
    """Return the first, middle and last samples of the filtered responses."""
    n_samples = filtered.shape[1]
    run = np.arange(min(EXCERPT, n_samples))
    middle = max(0, n_samples // 2 - 1)
    where = np.unique(np.concatenate([run, middle + run, n_samples - run.size + run]))
    where = where[where < n_samples]
    rows = filtered[layout.n_controls :, where]
    return ThesisTable(
        "sample_0based", where.astype(float), layout.columns(rows, layout.responses)
    )


def _periodogram(
    data: FloatArray, rate: float, sample_rate: float, layout: _Layout
) -> ThesisTable:
    """Return every 97th bin of the periodogram of the whole crop."""
    frequency, density = periodogram(data, rate)
    axis = frequency * (sample_rate / rate)
    stride = slice(None, None, PERIODOGRAM_STRIDE)
    return ThesisTable("frequency_hz", axis[stride], layout.columns(density[:, stride]))


def _all_peaks(
    densities: ThesisTable, ratios: ThesisTable, layout: _Layout
) -> tuple[ThesisPeak, ...]:
    """Return the peaks of every response, PSD first."""
    responses = [layout.names[i] for i in layout.responses]
    peaks = []
    for i, name in enumerate(responses):
        with np.errstate(divide="ignore"):
            logarithm = np.log10(densities.columns[name])
        peaks += _peaks("psd", name, densities.index, logarithm, used=i == 1)
    for i, name in enumerate(responses):
        peaks += _peaks("frf", name, ratios.index, ratios.columns[name], used=i == 0)
    return tuple(peaks)


def _peaks(
    quantity: str, channel: str, frequency: FloatArray, values: FloatArray, *, used: bool
) -> list[ThesisPeak]:
    """Return the peaks of one response by the rule for this quantity."""
    rule = {"psd": (0.49, -np.inf), "frf": (0.4, 5.0)}[quantity]
    return [
        ThesisPeak(
            quantity=quantity,
            channel=channel,
            used_by_thesis=used,
            rank_by_location=rank,
            frequency=float(frequency[k]),
            value=float(values[k]),
            deleted=quantity == "psd" and frequency[k] < LOWEST,
        )
        for rank, k in enumerate(thesis_peaks(values, *rule), start=1)
    ]
