"""A recording for a notebook: what is in the file, and its samples when they are asked for."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

from shakerproc import recordings
from shakerproc.data import Channel
from shakerproc.errors import ArgumentError
from shakerproc.numerals import numeral
from shakerproc.recordings.raw import AS_STATED
from shakerproc.runs.result import shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.workflows.arguments import AnyPath, file_of, number_of, switch_of, text_of
from shakerproc.workflows.processing_options import sampling_of
from shakerproc.workflows.shown import Shown, frame, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.data import Recording


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OpenedRecording(Shown):
    """Contents of a recording; its file is opened, and closed, whenever samples are read.

    Attributes
    ----------
    path : Path
        The file.
    channels : tuple of Channel
        Its channels, with their units in SI.
    sample_rate : float
        Samples per second [Hz].
    n_samples : int
        Samples of each channel.
    notes : tuple of str
        What the reader had to decide, a sentence each.
    group : str, optional
        Group of a file of several.
    said : Sampling
        What was said of its times.
    """

    path: Path
    channels: tuple[Channel, ...]
    sample_rate: float
    n_samples: int
    notes: tuple[str, ...] = ()
    group: str | None = None
    said: recordings.Sampling = AS_STATED

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.n_samples / self.sample_rate

    def to_pandas(self, start_s: float = 0.0, stop_s: float | None = None) -> "DataFrame":
        """Return the samples of every channel, accelerations in g, the others in SI units.

        Parameters
        ----------
        start_s, stop_s : float
            Part of the recording, to the nearest sample; by default all of it [s].

        Returns
        -------
        DataFrame
            A column ``time_s`` and one for each channel, which says its unit at its end.

        Raises
        ------
        ArgumentError
            If the part is empty.
        RecordingError
            If the file cannot be read any more.
        """
        start = round(number_of("start_s", start_s) * self.sample_rate)
        end = self.duration if stop_s is None else number_of("stop_s", stop_s)
        stop = min(round(end * self.sample_rate), self.n_samples)
        if not start < stop:
            raise ArgumentError(
                "start_s", f"nothing between {start_s:g} s and {min(end, self.duration):g} s"
            )
        with self._opened() as recording:
            samples = recording.samples(start, stop)
        import numpy as np

        columns = {"time_s": np.arange(start, stop) / self.sample_rate}
        for channel, row in zip(self.channels, samples, strict=True):
            unit, factor = shown_unit(channel.unit)
            columns[f"{channel.name}{spelled(unit)}"] = row * factor
        return frame(columns)

    def plot(self) -> "Figure":
        """Return every channel against time, as the extremes of each moment."""
        from shakerproc.report.runs.drawing import time_signals

        with self._opened() as recording:
            return time_signals(recording)

    def _opened(self) -> "Recording":
        return recordings.open_recording(
            self.path, part=recordings.FilePart(self.group), sample_rate=self.said
        )

    def _repr_html_(self) -> str:
        rows = [(c.name, c.unit, c.source_unit or "none") for c in self.channels]
        told = (
            f"{numeral(self.duration, 4)} s at {self.sample_rate:.6g} Hz, {self.n_samples} "
            "samples"
        )
        table = frame_of_rows(("channel", "unit", "unit in the file"), rows)
        return html(self.path.name, [told, *self.notes], table)


def open_recording(
    path: AnyPath,
    *,
    group: str | None = None,
    sample_rate_hz: float | None = None,
    override_rate: bool = False,
    time_unit: str | None = None,
    resample_hz: float | None = None,
    ignore_starts: bool = False,
) -> OpenedRecording:
    """Return the contents of a recording: channels, units, sample rate, length.

    Parameters
    ----------
    path : path
        The file, whose ending says the format: one that shakerproc reads, such as TDMS, CSV,
        MAT, UFF 58, WAV or HDF5, or what an installed reader knows.
    group : str, optional
        Group of a file of several.
    sample_rate_hz : float, optional
        Where the file does not say it, or `override_rate` [Hz].
    override_rate : bool
        Whether `sample_rate_hz` counts although the file states another.
    time_unit : str, optional
        Unit of times in the file that state none, such as ``ms``.
    resample_hz : float, optional
        Rate of the even times that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the file states.

    Raises
    ------
    ArgumentError
        If `path` is no path of a file.
    RecordingError
        If the file cannot be used.
    """
    given = file_of("path", path, "a recording")
    group = None if group is None else text_of("group", group, "the name of a group")
    said = sampling_of(
        sample_rate_hz,
        override_rate=switch_of("override_rate", override_rate),
        time_unit=None if time_unit is None else text_of("time_unit", time_unit, "a unit"),
        resample_hz=resample_hz,
        ignore_starts=switch_of("ignore_starts", ignore_starts),
    )
    with recordings.open_recording(
        given, part=recordings.FilePart(group), sample_rate=said
    ) as opened:
        return OpenedRecording(
            given,
            opened.channels,
            opened.sample_rate,
            opened.n_samples,
            opened.notes,
            group,
            said,
        )
