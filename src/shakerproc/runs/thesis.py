"""The tables of the thesis' scripts for a run, with its roles, crop and averaging."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from shakerproc import files
from shakerproc.data import STANDARD_GRAVITY, Channel, Recording
from shakerproc.errors import SpectrumError
from shakerproc.runs.result import RunResult
from shakerproc.runs.roles import without_tachometers
from shakerproc.spectra import ThesisSettings, ThesisTables, thesis_tables
from shakerproc.testlog import ThresholdCrop


def thesis_tables_of(result: RunResult, recording: Recording) -> ThesisTables:
    """Return the thesis' tables of a processed run.

    Controls, responses and the crop are the run's; segments, window and mean are those of its
    processing (the thesis' own by default), and the filter takes out the tone that the log
    names, else 50 Hz.

    Parameters
    ----------
    result : RunResult
        The run.
    recording : Recording
        Its recording, open.

    Raises
    ------
    SpectrumError
        If a control is no acceleration, there is none, or no response is one.
    """
    test, channels = result.test, result.channels
    forces = [channels[i].name for i in result.controls if channels[i].unit != "m/s^2"]
    if forces:
        raise SpectrumError(
            f"{result.run}: --thesis divides accelerations by accelerations, and the control "
            f"{forces[0]} is not one; leave --thesis out"
        )
    rows = _rows(result)
    welch = test.processing.welch
    settings = ThesisSettings(
        segment=welch.segment,
        overlap=welch.overlap,
        window=welch.window,
        n_fft=welch.n_fft,
        detrend=test.processing.detrend,
        notch_frequency=test.notch_hz or ThesisSettings().notch_frequency,
    )
    try:
        return thesis_tables(
            without_tachometers(recording).select(rows).samples(),
            result.sample_rate,
            crop=result.crop,
            n_controls=len(result.controls),
            names=thesis_names([channels[i] for i in rows], len(result.controls)),
            settings=settings,
        )
    except SpectrumError as error:
        raise SpectrumError(f"{result.run}: --thesis: {error}") from error


def _rows(result: RunResult) -> list[int]:
    """Return the controls, then the responses that are accelerations."""
    responses = [i for i in result.responses if result.channels[i].unit == "m/s^2"]
    return [*result.controls, *responses]


def thesis_names(channels: Sequence[Channel], n_controls: int) -> list[str]:
    """Return names for channels, the controls first: the log's, else the thesis' numbers.

    The thesis calls its controls ch1 and ch2 and its responses ch3 and on. Where the log gives
    such a name to another channel, the one without keeps its name in the recording.
    """
    shift = max(0, 2 - n_controls)
    numbers = [f"ch{i + 1 + (shift if i >= n_controls else 0)}" for i in range(len(channels))]
    given = {c.name for c in channels if c.name != c.source_name}
    return [
        number if c.name == c.source_name and number not in given else c.name
        for c, number in zip(channels, numbers, strict=True)
    ]


def write_thesis_tables(result: RunResult, recording: Recording, folder: Path) -> list[Path]:
    """Write the tables of the thesis' scripts, and return the files."""
    found = thesis_tables_of(result, recording)
    names = list(found.tables["psd"].columns)
    written = []
    for name, table in found.tables.items():
        written.append(folder / f"{name}.csv")
        files.write_csv(written[-1], {table.index_name: table.index, **table.columns})
    written.append(folder / "peaks.csv")
    files.write_csv(written[-1], _peak_columns(found))
    written.append(folder / "crop.json")
    files.write_json(written[-1], {**found.crop, **_said(result, names), "mode": found.mode})
    return written


def _peak_columns(found: ThesisTables) -> dict[str, list[Any]]:
    return {
        "quantity": [p.quantity for p in found.peaks],
        "channel": [p.channel for p in found.peaks],
        "used_by_thesis": [p.used_by_thesis for p in found.peaks],
        "rank_by_location": [p.rank_by_location for p in found.peaks],
        "frequency_hz": [p.frequency for p in found.peaks],
        "value": [p.value for p in found.peaks],
        "deleted": [p.deleted for p in found.peaks],
    }


def _said(result: RunResult, names: Sequence[str]) -> dict[str, object]:
    """Return where the crop comes from, and which channel of the file each column is."""
    crop, channels = result.test.processing.crop, result.channels
    threshold = crop.threshold if isinstance(crop, ThresholdCrop) else None
    row = result.crop_channel
    rows = _rows(result)
    return {
        "threshold": None if threshold is None else threshold / STANDARD_GRAVITY,
        "crop_channel": None if row is None else channels[row].source_name,
        "channels": {
            name: channels[i].source_name for name, i in zip(names, rows, strict=True)
        },
        "left_out": [c.source_name for i, c in enumerate(channels) if i not in rows],
    }
