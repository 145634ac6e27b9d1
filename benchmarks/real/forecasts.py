"""The next level of real measurements: levels below fitted, the next one forecast.

``python -m benchmarks.real.forecasts [SET ...]``. Each level is forecast from those below it
under its measured drive, by a model with the effect that `diagnose` names there; its numbers
are fitted to those below alone. Linear scaling of the level below stands beside it. The arrow
of the Silverbox is cut into parts; of base isolation the first nine seconds of the quake stand
for a level below the whole; three masses are a simulated campaign. A set of one level
(ring-down: one blow), or whose motion is imposed (the dampers), has no next level.
"""

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from configs.benchmarks import convert

from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.errors import ShakerprocError
from shakerproc.forecasts import ModelEvidence
from shakerproc.forecasts.forecast import evidence_of
from shakerproc.forecasts.levels import decibels, drive_rms, grouped
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element
from shakerproc.testlog import read_testlog


@dataclass(frozen=True)
class Series:
    """Levels of one set.

    `effect` is an element of the model, `parts` are from where to where `recording` is cut [s],
    `band` is what is compared in a part.
    """

    effect: Element
    recording: str = ""
    band: str = ""
    parts: tuple[tuple[float, float], ...] = ()


SETS = {
    "silverbox": Series(
        Element(EFFECTS["cubic_stiffness"](coefficient=4.0), ("base", "box")),
        "SNLS80mV.mat", "from: 0.5 Hz, to: 200 Hz",
        ((8.0, 18.0), (18.0, 30.0), (30.0, 45.0), (45.0, 66.0)),
    ),
    "base_isolation": Series(
        Element(
            EFFECTS["bouc_wen"](stiffness=40.0, yield_displacement=0.02, exponent=1.0),
            ("base", "floor1"),
        ),
        "quake.npz", "from: 0.15 Hz, to: 4 Hz", ((0.0, 9.0), (0.0, 40.0)),
    ),
    "three_masses": Series(
        Element(EFFECTS["gap"](clearance=3e-5, stiffness=1e5), ("m2", "m3"))
    ),
}  # fmt: skip


def levels_of(name: str, place: Path) -> ModelEvidence:
    """Return how far the model of a set misses each level from those below it."""
    folder, series = convert.folder_of(name, place), SETS[name]
    log = folder / "testlog.yaml"
    if series.parts:
        published = folder / "published.yaml"  # whose crop is not that of training
        head = (published if published.exists() else log).read_text(encoding="utf-8")
        head = head.split("tests:")[0]
        tests = "".join(
            f"  - {{id: {i}, recording: {series.recording}, excitation: random, {series.band}, "
            f"processing: {{crop: {{from: {low} s, to: {high} s}}}}}}\n"
            for i, (low, high) in enumerate(series.parts, 1)
        )
        log.write_text(f"{head}tests:\n{tests}", encoding="utf-8")
    known = read_model(folder / "model.yaml")
    known = replace(known, elements=(*known.elements, series.effect))
    measured = tests_of(read_testlog(log), known).tests
    return evidence_of(known, grouped(measured), lambda text: print(f"  {text}", flush=True))


def told(name: str, found: ModelEvidence) -> None:
    """Print a line for each level that was forecast, response and quantity."""
    runs = {run.measured.name: run for run in found.runs}
    order = sorted(runs, key=lambda one: drive_rms(runs[one].measured))
    for one in found.errors:
        if not one.distance_db:
            continue
        below = runs[order[order.index(one.test) - 1]]
        ratio = drive_rms(runs[one.test].measured) / drive_rms(below.measured)
        scale = 1.0 if one.quantity.what == "peak_frequency_hz" else ratio
        linear = decibels(scale * below.values[one.quantity] / one.measured)
        print(
            f"{name:14s} {one.test:>4s} {one.distance_db:+5.1f} dB  {one.quantity.name:12s} "
            f"{one.quantity.what:17s}  {one.measured:9.4g}  {one.predicted:9.4g}  "
            f"{one.error_db:+6.2f} dB  {one.of_model.error_db:+6.2f} dB  "
            f"{one.spread_db:5.2f} dB  {linear:+6.2f} dB",
            flush=True,
        )


def main(names: Sequence[str]) -> int:
    """Print the table of each set."""
    print("set, test, above those below, response, quantity, measured, forecast, error, "
          "of the model alone, spread, error of linear scaling")  # fmt: skip
    for name in names or SETS:
        with tempfile.TemporaryDirectory() as temporary:
            try:
                told(name, levels_of(name, Path(temporary)))
            except (FileNotFoundError, ShakerprocError) as error:
                print(f"{name} left out: {error}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
