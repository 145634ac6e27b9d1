"""The thesis' tables against an Octave re-implementation of its scripts, to 1e-9."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from nptdms import TdmsFile

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.spectra.thesis import ThesisTables, thesis_tables

pytestmark = pytest.mark.shared


def read_recording(path):
    """Return the five channels in m/s² and the sample rate, by npTDMS alone."""
    with TdmsFile.open(path) as file:
        (group,) = (g for g in file.groups() if g.name.endswith("All Data"))
        samples = np.array([channel[:] for channel in group.channels()[:5]])
        increment = group.channels()[0].properties["wf_increment"]
    return samples * STANDARD_GRAVITY, 1.0 / increment


def write_tables(tables: ThesisTables, folder):
    """Write one CSV a table, peaks.csv and crop.json, as the checker wants them."""
    folder.mkdir(parents=True)
    for name, table in tables.tables.items():
        rows = np.column_stack([table.index, *table.columns.values()])
        head = ",".join([table.index_name, *table.columns])
        np.savetxt(folder / f"{name}.csv", rows, "%.17g", ",", header=head, comments="")
    with (folder / "peaks.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["quantity", "channel", "frequency_hz", "value"])
        writer.writerows([p.quantity, p.channel, p.frequency, p.value] for p in tables.peaks)
    (folder / "crop.json").write_text(json.dumps(tables.crop))


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["thesis", "corrected"])
def test_tables_pass_the_checker(mode, shared, tmp_path):
    for case in ("random_gap", "sweep_gap_5g"):
        path = shared / "reference" / "recordings" / f"{case}_5ch.tdms"
        samples, rate = read_recording(path)
        write_tables(thesis_tables(samples, rate, mode=mode), tmp_path / case)
    checker = shared / "reference" / "check_reference.py"
    options = ["--mode", mode, "--rtol", "1e-9", "--strict"]
    result = subprocess.run(
        [sys.executable, str(checker), str(tmp_path), *options],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout
    assert "PASS (rtol 1e-09, 2 case(s)" in result.stdout
