"""Write HDF5: a data set for each channel, with its unit, and the rate as attribute."""

from pathlib import Path
from typing import Final

import numpy as np

from shakerproc import files
from shakerproc.data import Recording
from shakerproc.recordings.writers.shown_units import BLOCK, blocks_in_file_units, file_unit

_SLASH: Final = "\N{DIVISION SLASH}"
"""What stands for a slash in the name of a data set, where a slash is a group."""


def write_hdf5(path: Path, recording: Recording) -> None:
    """Write a recording as HDF5, whole or not at all."""
    import h5py

    names = _names([channel.name for channel in recording.channels])
    with (
        files.atomic_path(path) as temporary,
        h5py.File(temporary, "w", track_order=True) as file,
    ):
        file.attrs["sample_rate"] = float(recording.sample_rate)
        file.attrs["title"] = recording.run
        if recording.start_time is not None:
            file.attrs["start_time"] = recording.start_time.isoformat()
        stored = []
        for name, channel in zip(names, recording.channels, strict=True):
            data = file.create_dataset(
                name, (recording.n_samples,), np.float64,
                chunks=(min(BLOCK, recording.n_samples),),
            )  # fmt: skip
            data.attrs["name"] = channel.name
            if unit := file_unit(channel)[0]:
                data.attrs["units"] = unit
            stored.append(data)
        at = 0
        for block in blocks_in_file_units(recording):
            for data, samples in zip(stored, block, strict=True):
                data[at : at + samples.size] = samples
            at += block.shape[1]


def _names(names: list[str]) -> list[str]:
    """Return the names of the data sets: no two alike, none a path."""
    plain = [name.replace("/", _SLASH).replace("\0", "") or "channel" for name in names]
    plain = ["channel" if set(name) == {"."} else name for name in plain]
    return [
        name if plain.count(name) == 1 else f"{name} {number + 1}"
        for number, name in enumerate(plain)
    ]
