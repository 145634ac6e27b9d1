"""``python -m tests.campaign.slow_writer FOLDER N PAUSE``: N recordings in segments."""

import sys
import time
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, RootObject, TdmsWriter
from tests.small_campaign import CHANNELS, RATE, samples

from shakerproc.data import STANDARD_GRAVITY

SEGMENTS = 8
"""Parts in which a recording is written."""


def write_slowly(path, number, pause):
    """Append a recording to a file, one segment after the other."""
    rows = samples(360.0 - 40.0 * (number % 6), seed=number) / STANDARD_GRAVITY
    step = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
    path.parent.mkdir(parents=True, exist_ok=True)
    with TdmsWriter(str(path)) as writer:
        for part in np.array_split(rows, SEGMENTS, axis=1):
            named = zip(CHANNELS, part, strict=True)
            channels = [ChannelObject("G", c.name, row, step) for c, row in named]
            writer.write_segment([RootObject({}), *channels])
            time.sleep(pause)


def main(folder: Path, n_recordings: int, pause: float):
    for number in range(1, n_recordings + 1):
        write_slowly(folder / f"Test_{number}" / "Acceleration.tdms", number, pause)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
