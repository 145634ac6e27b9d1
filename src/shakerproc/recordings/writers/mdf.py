"""Write MDF 4 by asammdf: one group, the time channel first, a block at a time."""

from pathlib import Path

import numpy as np

from shakerproc import files
from shakerproc.data import Recording
from shakerproc.errors import RecordingError
from shakerproc.late import without
from shakerproc.recordings.writers.shown_units import BLOCK, blocks_in_file_units, file_unit


def write_mf4(path: Path, recording: Recording) -> None:
    """Write a recording as MDF of version 4.10, whole or not at all.

    Raises
    ------
    RecordingError
        If asammdf is not installed.
    """
    if lacks := without("asammdf", "MDF", "recorders", "write TDMS or HDF5"):
        raise RecordingError(f"{path}: {lacks}")
    from asammdf import MDF, Signal

    with files.atomic_path(path) as temporary, MDF(version="4.10") as file:
        if recording.start_time is not None:
            file.start_time = recording.start_time
        else:
            file.header.abs_time = 0  # else the time of writing would be that of the test
        for number, block in enumerate(blocks_in_file_units(recording)):
            at = np.arange(number * BLOCK, number * BLOCK + block.shape[1])
            times = at / recording.sample_rate
            if number:
                file.extend(0, [(times, None), *((samples, None) for samples in block)])
                continue
            signals = [
                Signal(samples, times, name=channel.name, unit=file_unit(channel)[0])
                for channel, samples in zip(recording.channels, block, strict=True)
            ]
            file.append(signals, comment=recording.run, common_timebase=True)
        file.save(temporary, overwrite=True)
