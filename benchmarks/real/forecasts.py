"""The next level of a real measurement: the Silverbox arrow, random noise that grows steadily.

``python -m benchmarks.real.forecasts``. The arrow is cut into parts; each is a level that is
forecast from those below it, under its measured drive, by a model with a cubic stiffness whose
numbers are fitted to those below alone. Linear scaling of the part below stands beside it.
"""

import sys
import tempfile
from itertools import pairwise
from pathlib import Path

from configs.benchmarks import convert

from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.forecasts.forecast import evidence_of
from shakerproc.forecasts.levels import decibels, drive_rms, grouped
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

EDGES_S = (8.0, 18.0, 30.0, 45.0, 66.0)
"""Where the arrow is cut: amplitudes from 12 to 100 % of its largest [s]."""

EFFECT = "  - {kind: cubic_stiffness, between: [base, box], coefficient: 4 N/m^3}\n"
"""The law that the circuit was built to have, its number a guess."""


def main() -> int:
    """Print a line for each level and quantity."""
    with tempfile.TemporaryDirectory() as temporary:
        try:
            folder = convert.folder_of("silverbox", Path(temporary))
        except FileNotFoundError as error:
            print(f"left out: {error}")
            return 0
        model, log = folder / "model.yaml", folder / "levels.yaml"
        text = model.read_text(encoding="utf-8")
        model.write_text(text.replace("excitation:", f"{EFFECT}excitation:"), encoding="utf-8")
        published = (folder / "published.yaml").read_text(encoding="utf-8")
        tests = "".join(
            f"  - {{id: {i}, recording: SNLS80mV.mat, excitation: random, from: 0.5 Hz, to: "
            f"200 Hz, processing: {{crop: {{from: {low} s, to: {high} s}}}}}}\n"
            for i, (low, high) in enumerate(pairwise(EDGES_S), 1)
        )
        log.write_text(published.split("tests:")[0] + "tests:\n" + tests, encoding="utf-8")
        known = read_model(model)
        measured = tests_of(read_testlog(log), known).tests
        found = evidence_of(
            known, grouped(measured), lambda text: print(f"  {text}", flush=True)
        )
    runs = {run.measured.name: run for run in found.runs}
    names = [run.measured.name for run in found.runs]
    print("level  above those below  quantity  measured  forecast  error  spread  linear error")
    for one in found.errors:
        if not one.distance_db:
            continue
        below = runs[names[names.index(one.test) - 1]]
        ratio = drive_rms(runs[one.test].measured) / drive_rms(below.measured)
        scale = 1.0 if one.quantity.what == "peak_frequency_hz" else ratio
        linear = decibels(scale * below.values[one.quantity] / one.measured)
        print(
            f"{one.test}      {one.distance_db:+5.1f} dB  {one.quantity.what:17s}  "
            f"{one.measured:9.4g}  {one.predicted:9.4g}  {one.error_db:+6.2f} dB  "
            f"{one.spread_db:5.2f} dB  {linear:+6.2f} dB"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
