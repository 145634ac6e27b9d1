"""Write .mat (version 5): one matrix of samples with names, units and rate beside it."""

from pathlib import Path
from typing import Final

import numpy as np

from shakerproc import files
from shakerproc.data import Recording
from shakerproc.errors import RecordingError
from shakerproc.recordings.writers.shown_units import blocks_in_file_units, file_unit

LARGEST: Final = (1 << 31) - 1024
"""Bytes of a variable in version 5."""


def write_mat(path: Path, recording: Recording) -> None:
    """Write a recording for MATLAB, whole or not at all.

    Raises
    ------
    RecordingError
        If it is longer than the format can hold.
    """
    from scipy import io as scipy_io

    size = 8 * recording.n_samples * len(recording.channels)
    if size > LARGEST:
        raise RecordingError(
            f"{recording.run}: {size >> 20} MB are more than a .mat file can hold. "
            "Convert it to Parquet or TDMS, or crop it first."
        )
    samples = np.concatenate(list(blocks_in_file_units(recording)), axis=1).T
    units = [file_unit(channel)[0] for channel in recording.channels]
    content = {
        "samples": samples,
        "names": np.array([c.name for c in recording.channels], dtype=object),
        "units": np.array(units, dtype=object),
        "sample_rate_hz": recording.sample_rate,
        "start_time": recording.start_time.isoformat() if recording.start_time else "",
    }
    with files.atomic_path(path) as temporary:
        scipy_io.savemat(temporary, content, do_compression=False, oned_as="column")
