"""The tables of the thesis' scripts: to the letter, or without padding and its sample rate."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.crop import crop_by_threshold
from shakerproc.spectra.cross import CrossSpectra
from shakerproc.spectra.engine import cross_spectra
from shakerproc.spectra.notch_filters import thesis_notch
from shakerproc.spectra.peaks import thesis_peaks
from shakerproc.spectra.periodograms import periodogram
from shakerproc.spectra.responses import coherence, psd, psd_ratio

Mode: TypeAlias = Literal["thesis", "corrected"]

THRESHOLD: Final = 0.45 * STANDARD_GRAVITY
"""Value of control 2 between which the run lies [m/s²]."""

SEGMENT: Final = 1024
NOTCH_SEGMENT: Final = 2048
NOTCH_FREQUENCY: Final = 50.0

PERIODOGRAM_STRIDE: Final = 97
EXCERPT: Final = 3000
"""Samples of the filtered signal that its table shows from the start, middle and end."""

LOWEST: Final = 25.0
"""Frequency below which the thesis deletes PSD peaks [Hz]."""

CONTROLS: Final = (0, 1)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One table: an index and named columns of the same length.

    Attributes
    ----------
    index_name : str
        ``frequency_hz`` or ``sample_0based``.
    index : (n_rows,) array
        What the rows are.
    columns : mapping of str to (n_rows,) array
        Values by channel, ``ch1`` to ``ch5``.
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
        Whether the thesis looks at this channel for this quantity: PSD of ch4, FRF of ch3.
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
    tables : mapping of str to Table
        psd, frf, coherence, notch_psd, notch_frf, notch_coherence, notch_signal and
        periodogram_every97.
    peaks : tuple of ThesisPeak
        Peaks of every response.
    """

    mode: Mode
    crop: Mapping[str, float]
    tables: Mapping[str, Table]
    peaks: tuple[ThesisPeak, ...]


def thesis_tables(
    samples: FloatArray, sample_rate: float, *, mode: Mode = "thesis"
) -> ThesisTables:
    """Return the tables that the thesis' scripts make of one recording.

    Mode ``thesis`` follows them to the letter: an odd crop is padded with its last sample and
    the sample rate becomes N/tend, which goes into densities, the filter and the frequencies
    of the coherence. Mode ``corrected`` does neither. Both crop by control 2 at 0.45 g, use a
    symmetric Hamming window of 1024 (2048 after the filter) without detrending, divide the
    response PSD by the mean of the control PSDs and call it FRF, and pad the filter by 6.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Accelerations of control 1, control 2 and the responses [m/s²].
    sample_rate : float
        Samples per second [Hz].
    mode : str
        ``thesis`` or ``corrected``.

    Returns
    -------
    ThesisTables
        Tables in g, as the thesis has them.

    Raises
    ------
    SpectrumError
        If the recording has fewer than three channels, never reaches 0.45 g on control 2,
        or is shorter than a segment.
    ValueError
        If there is no such mode.

    References
    ----------
    .. [1] THESIS, appendix C.
    """
    if mode not in {"thesis", "corrected"}:
        raise ValueError(f"mode must be thesis or corrected, not {mode!r}")
    if samples.shape[0] < 3:
        raise SpectrumError(
            f"the thesis needs control 1, control 2 and a response, not {samples.shape[0]} "
            "channels"
        )
    crop = crop_by_threshold(samples[1], THRESHOLD, sample_rate)
    data = samples[:, crop.start : crop.stop] / STANDARD_GRAVITY
    padded = mode == "thesis" and crop.n_samples % 2 == 1
    if padded:
        data = np.concatenate([data, data[:, -1:]], axis=1)
    end, rate = _end_and_rate(crop.start, crop.stop, data.shape[1], sample_rate, mode)
    filtered = np.concatenate([data[:2], thesis_notch(data[2:], rate, NOTCH_FREQUENCY)])
    plain = cross_spectra(data, rate, segment=SEGMENT)
    notched = cross_spectra(filtered, rate, segment=NOTCH_SEGMENT)
    tables = {
        **_spectra("", plain, sample_rate),
        **_spectra("notch_", notched, sample_rate),
        "notch_signal": _excerpt(filtered),
        "periodogram_every97": _periodogram(data, rate, sample_rate),
    }
    facts = {
        "n_total": samples.shape[1],
        "threshold": THRESHOLD / STANDARD_GRAVITY,
        "start_in_file_0based": crop.start,
        "stop_in_file_0based": crop.stop - 1,
        "cropped_length": crop.n_samples,
        "fs_hz": sample_rate,
        "padded": int(padded),
        "N": data.shape[1],
        "tend": end,
        "Fs": rate,
        "segments_1024": plain.n_segments,
        "segments_2048": notched.n_segments,
    }
    return ThesisTables(mode, facts, tables, _all_peaks(tables["psd"], tables["frf"]))


def _end_and_rate(
    start: int, stop: int, n_samples: int, sample_rate: float, mode: Mode
) -> tuple[float, float]:
    """Return the last time [s] and the sample rate derived from it [Hz]."""
    if mode == "corrected":
        return (n_samples - 1) / sample_rate, sample_rate
    end = (stop + 1) / sample_rate - (start + 1) / sample_rate
    return end, n_samples / end


def _columns(first: int, rows: FloatArray) -> dict[str, FloatArray]:
    """Return the rows named by the thesis' channel numbers, from `first`."""
    return {f"ch{first + i}": row for i, row in enumerate(rows)}


def _spectra(prefix: str, spectra: CrossSpectra, sample_rate: float) -> dict[str, Table]:
    """Return PSD, PSD ratio and coherence, each on the frequency axis that the thesis uses."""
    responses = range(2, spectra.n_channels)
    axis = np.linspace(0.0, sample_rate / 2.0, spectra.frequency.size)
    density = psd(spectra)
    ratio = psd_ratio(spectra, CONTROLS, responses)
    coherent = coherence(spectra, CONTROLS, responses)
    return {
        f"{prefix}psd": Table("frequency_hz", axis, _columns(1, density)),
        f"{prefix}frf": Table("frequency_hz", axis, _columns(3, ratio)),
        f"{prefix}coherence": Table("frequency_hz", spectra.frequency, _columns(3, coherent)),
    }


def _excerpt(filtered: FloatArray) -> Table:
    """Return the first, middle and last samples of the filtered responses."""
    n_samples = filtered.shape[1]
    run = np.arange(min(EXCERPT, n_samples))
    middle = max(0, n_samples // 2 - 1)
    where = np.unique(np.concatenate([run, middle + run, n_samples - run.size + run]))
    where = where[where < n_samples]
    return Table("sample_0based", where.astype(float), _columns(3, filtered[2:, where]))


def _periodogram(data: FloatArray, rate: float, sample_rate: float) -> Table:
    """Return every 97th bin of the periodogram of the whole crop."""
    frequency, density = periodogram(data, rate)
    axis = np.linspace(0.0, sample_rate / 2.0, frequency.size)
    stride = slice(None, None, PERIODOGRAM_STRIDE)
    return Table("frequency_hz", axis[stride], _columns(1, density[:, stride]))


def _all_peaks(densities: Table, ratios: Table) -> tuple[ThesisPeak, ...]:
    """Return the peaks of every response, PSD first."""
    responses = [name for name in densities.columns if name not in {"ch1", "ch2"}]
    found = []
    for name in responses:
        with np.errstate(divide="ignore"):
            logarithm = np.log10(densities.columns[name])
        found += _peaks("psd", name, densities.index, logarithm, used=name == "ch4")
    for name in responses:
        found += _peaks("frf", name, ratios.index, ratios.columns[name], used=name == "ch3")
    return tuple(found)


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
