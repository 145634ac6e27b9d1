"""Forecasts of blind campaigns: levels up to L fitted, L + 6 dB and L + 12 dB forecast.

``python -m benchmarks.forecast [FIRST [COUNT]] [--store FILE] [--classes A,B]``. The model of
each campaign is the nominal one with the hidden effect, all its numbers 10 % off; of a class
that begins with ``without:`` the effect is left out: an incomplete library. Gains of channels
are off by chance, with the standard uncertainty of a sensor of which no sheet says one: 1 %.
The truth of the next level is simulated by the code of the hidden campaigns, which shares none
with the program. Linear scaling stands beside the forecast. Where the motion runs away, a
forecast has no values; whether the truth runs away there is counted. ``--store`` keeps the
values: campaigns that are there already are not run again. ``BLIND_SECONDS=7`` in the
environment makes tests of 7 s, of 20 s by default.
"""

import argparse
import json
import tempfile
import time
import zlib
from collections.abc import Iterator
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np
from blind.campaign import Campaign
from blind.campaigns import Drawn
from blind.excitations import SAMPLE_RATE
from blind.recorder import responses
from blind.truth import Motion

from blind import campaigns, folder
from shakerproc.comparison import Measured
from shakerproc.comparison.free_run_error import in_band
from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.errors import ShakerprocError, SimulationError
from shakerproc.forecasts import TestForecast, forecast_tests
from shakerproc.forecasts.quantities import densities
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element, Model
from shakerproc.testlog import Test, TestLog, read_testlog

CLASSES = (
    "none", "gap", "cubic_stiffness", "coulomb_friction", "chain:gap", "force:cubic_stiffness",
    "quadratic_damping", "jenkins", "without:gap", "without:cubic_stiffness", "stop",
    "offset_gap", "quadratic_stiffness", "power_law", "stribeck_friction", "contact_damping",
    "iwan", "bouc_wen", "attached_mode", "stiffness_drift", "constant_force", "bistable",
    "series_spring", "general_bouc_wen", "saturating", "power_iwan", "chain3:gap", "force:gap",
    "chain:cubic_stiffness", "without:coulomb_friction", "without:jenkins", "gap:sweep",
    "without:quadratic_damping", "cubic_stiffness:sweep",
)  # fmt: skip
"""LuGre friction and elements in series are left out: the truth does not say all that their
models need."""
ABOVE_DB = (6.0, 12.0)
OFF = 1.1
GAIN_SPREAD = 0.01
"""Standard deviation of the gain of a channel: that of a sensor without a sheet [-]."""
WHAT = ("rms", "peak", "peak_frequency_hz")


@dataclass(frozen=True)
class Score:
    """One quantity of one response at one level: forecast, linear scaling and truth."""

    kind: str
    above_db: float
    what: str
    value: float
    low: float
    high: float
    linear: float
    truth: float

    @property
    def inside(self) -> bool:
        """Whether the band holds the truth."""
        return self.low <= self.truth <= self.high

    def error(self, value: float) -> float:
        """Return how far a value is from the truth [dB], of a frequency [%]."""
        if self.what == "peak_frequency_hz":
            return 100.0 * abs(value / self.truth - 1.0)
        return 20.0 * abs(float(np.log10(value / self.truth)))


@dataclass(frozen=True)
class Ready:
    """A campaign with its model and its tests as the program reads them."""

    drawn: Drawn
    model: Model
    log: TestLog
    tests: tuple[Measured, ...]


def ready(seed: int, text: str) -> Ready:
    """Return the campaign of this seed and class."""
    incomplete = text.startswith("without:")
    drawn = campaigns.draw_all(seed, text.removeprefix("without:"))
    drawn = replace(drawn, campaign=_read_wrong(drawn.campaign, text))
    with tempfile.TemporaryDirectory(prefix="forecast-") as place:
        log_path, model_path = folder.write(drawn.campaign, Path(place))
        log, model = read_testlog(log_path), read_model(model_path)
        if not incomplete:
            model = replace(model, elements=(*model.elements, *_effects(drawn)))
        return Ready(drawn, model, log, tuple(tests_of(log, model).tests))


def _read_wrong(campaign: Campaign, text: str) -> Campaign:
    """Return a campaign of a class whose channels read too much or too little in all tests."""
    rng = np.random.default_rng([campaign.seed, zlib.crc32(text.encode()), 1])
    first = campaign.tests[0]
    of_inputs, of_responses = (
        1.0 + GAIN_SPREAD * rng.standard_normal((len(rows), 1))
        for rows in (first.control, first.response)
    )
    tests = (
        replace(test, control=of_inputs * test.control, response=of_responses * test.response)
        for test in campaign.tests
    )
    return replace(campaign, tests=tuple(tests))


def campaign(seed: int, text: str) -> Iterator[Score]:
    """Yield the scores of one campaign."""
    own = ready(seed, text)
    drawn, log = own.drawn, own.log
    planned = [planned_test(log.tests[2], drawn, above) for above in ABOVE_DB]
    try:
        found = forecast_tests(own.model, log, own.tests, planned).tests
    except SimulationError:  # by one of them: the lower may have a forecast
        try:
            found = forecast_tests(own.model, log, own.tests, planned[:1]).tests
        except SimulationError:
            found = ()
    for i, above in enumerate(ABOVE_DB):
        one = found[i] if i < len(found) else None
        motion = _louder(drawn, above)
        if one is None or motion is None:
            print(
                f"  {text} {seed} at {above:+.0f} dB: {_goes(one)} in the forecast, "
                f"{_goes(motion)} in truth"
            )
            continue
        truth = _truth(drawn, motion, one)
        for quantity, spread in one.spreads.items():
            if quantity.whose == "response":
                value = truth[quantity.name, quantity.what]
                yield Score(
                    text, above, quantity.what, spread.value, *spread.band,
                    one.linear[quantity], value,
                )  # fmt: skip


def _goes(found: object) -> str:
    return "runs away" if found is None else "goes on"


def _effects(drawn: Drawn) -> list[Element]:
    """Return the hidden effects with their numbers off."""
    found = []
    for effect in drawn.campaign.truth["effects"]:
        numbers = {
            name: OFF * value if isinstance(value, float) else value
            for name, value in effect["parameters"].items()
        }
        if "side" in numbers:
            numbers["side"] = "positive" if numbers["side"] > 0.0 else "negative"
        found.append(Element(EFFECTS[effect["kind"]](**numbers), tuple(effect["between"])))
    return found


def planned_test(loudest: Test, drawn: Drawn, above: float) -> Test:
    """Return the loudest test of a campaign so much above its level [dB], planned."""
    drive = drawn.plan.drives[2]
    seconds = drawn.campaign.tests[2].clean.shape[1] / SAMPLE_RATE - drive.lead_in - drive.tail
    power = 10.0 if drive.kind == "random" else 20.0
    level = (loudest.level or 0.0) * 10.0 ** (above / power)
    return replace(
        loudest, id=f"+{above:.0f} dB", recording=None, planned=True, level=level,
        duration=seconds if drive.kind == "random" else None,
    )  # fmt: skip


def _louder(drawn: Drawn, above: float) -> Motion | None:
    """Return the true motion so far above the loudest level [dB]; None where it runs away."""
    plan = drawn.plan
    drive = plan.drives[2]
    louder = replace(
        drive, level=drive.level * 10.0 ** (above / 20.0), seed=(*drive.seed, round(above))
    )
    return replace(plan, limit=100.0 * plan.limit).move(louder, 2)[1]


def _truth(drawn: Drawn, motion: Motion, one: TestForecast) -> dict[tuple[str, str], float]:
    """Return what the sensors should record of a true motion."""
    rows = recorded(drawn, motion, one.planned.compared)
    spectra = densities(rows, SAMPLE_RATE, one.planned.excited)
    found = {}
    for i, (row, spectrum) in enumerate(zip(rows, spectra, strict=True)):
        name = f"ch{3 + i}"
        found[name, "rms"] = float(np.std(row))
        found[name, "peak"] = float(np.max(np.abs(row - np.mean(row))))
        found[name, "peak_frequency_hz"] = spectrum.peak_frequency
    return found


def recorded(drawn: Drawn, motion: Motion, band: tuple[float, float]) -> np.ndarray:
    """Return what the sensors record of a motion within a band [Hz] while it is driven."""
    drive = drawn.plan.drives[2]
    nothing = replace(drawn.plan.drawn, gains=())
    rows = responses(drawn.plan.structure, motion, nothing, filtered=drawn.filtered)
    driven = slice(
        int(drive.lead_in * SAMPLE_RATE), rows.shape[1] - int(drive.tail * SAMPLE_RATE)
    )
    return in_band(rows, SAMPLE_RATE, band)[:, driven]


def table(scores: list[Score]) -> list[str]:
    """Return the lines of the table: share within 1 dB or 1 %, coverage, linear scaling."""
    lines = [
        "level   quantity            n  within 1 dB (1 %)  median error  band holds  "
        "band, half [dB]  linear within  linear median"
    ]
    for above in ABOVE_DB:
        for what in WHAT:
            own = [s for s in scores if s.above_db == above and s.what == what]
            if own:
                lines.append(f"+{above:<4.0f}dB {what:18s} {_line(own)}")
    for kind in dict.fromkeys(s.kind for s in scores):
        own = [s for s in scores if s.kind == kind]
        lines.append(f"{kind:26s} {_line(own)}")
    return lines


def _line(own: list[Score]) -> str:
    errors, linear = [s.error(s.value) for s in own], [s.error(s.linear) for s in own]
    width = np.median([10.0 * np.log10(s.high / s.low) for s in own])
    return (
        f"{len(own):3d}  {np.mean(np.array(errors) <= 1.0):17.0%}  {np.median(errors):12.2f}  "
        f"{np.mean([s.inside for s in own]):10.0%}  {width:15.2f}  "
        f"{np.mean(np.array(linear) <= 1.0):13.0%}  {np.median(linear):13.2f}"
    )


def _stored(path: Path | None) -> dict[str, list[Score]]:
    """Return the scores in a file, by campaign."""
    if path is None or not path.exists():
        return {}
    rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return {row["campaign"]: [Score(*one) for one in row["scores"]] for row in rows}


def main() -> None:
    """Print the scores of so many campaigns, each class once before any comes twice."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.forecast")
    parser.add_argument("first", type=int, nargs="?", default=1, help="first seed")
    parser.add_argument("count", type=int, nargs="?", default=len(CLASSES), help="campaigns")
    parser.add_argument("--store", type=Path, help="file that keeps the values")
    parser.add_argument("--classes", help="only these, with commas between")
    asked = parser.parse_args()
    classes = asked.classes.split(",") if asked.classes else CLASSES
    known, scores = _stored(asked.store), list[Score]()
    for i in range(asked.count):
        kind, seed = classes[i % len(classes)], asked.first + i // len(classes)
        name, start = f"{kind} {seed}", time.process_time()
        try:
            own = known[name] if name in known else list(campaign(seed, kind))
        except (ShakerprocError, RuntimeError) as error:
            print(f"{name}: {error}", flush=True)
            own = []
        scores += own
        if asked.store is not None and name not in known:
            row = {"campaign": name, "scores": [astuple(one) for one in own]}
            with asked.store.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        _tell(name, own, time.process_time() - start)
    print("\n".join(table(scores)))


def _tell(name: str, own: list[Score], seconds: float) -> None:
    held = sum(s.inside for s in own)
    print(f"{name}: {held} of {len(own)} in their bands, {seconds:.0f} s", flush=True)
    for s in own:
        print(f"  +{s.above_db:.0f} dB {s.what:18s} {s.value:.5g} ({s.low:.5g} to "
              f"{s.high:.5g}), truth {s.truth:.5g}, linear {s.linear:.5g}"
              f"{'' if s.inside else '  <- outside'}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
