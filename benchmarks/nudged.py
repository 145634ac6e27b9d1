"""The race of laws over the nudging rate, on hidden campaigns and on folders.

python -m benchmarks.nudged gap*520000 friction_damper FOLDER ...

A campaign of `blind` is named by class and seed, a real set as `benchmarks.real` names it; a
folder holds model.yaml and testlog.yaml.
Printed are, for each rate over the angular frequency of the joint's motion, the held-out error
of the best law and its noise floor, that of the model without an effect, and the best laws with
their error and how many standard errors they are behind.
"""

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from blind.campaigns import draw
from configs.benchmarks import convert

from blind import folder
from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.data.from_files import arrays, tests_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.nudged.race import Rung, race
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.diagnosis.selection.scores import Score, gain
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

SHOWN = 5


def run(place: Path) -> None:
    """Print the race of the model and the tests of a folder."""
    log = next(iter(place.glob("testlog.yaml")))
    model = read_model(place / "model.yaml")
    measured = tests_of(read_testlog(log), model).tests
    sensors = {name: model.sensors[name] for name in measured[0].sensors}
    tests = prepared([arrays(one) for one in measured], imposed=model.excitation.imposed)
    begin = time.process_time()
    campaign = campaign_of(replace(model, sensors=sensors), tests)
    rungs = race(campaign, lambda _text: None)
    for rung in rungs:
        print(told(campaign.data, rung), flush=True)
    if rungs:
        best = rungs[-1].best.fit
        for one, part in zip(
            best.hypothesis.added, best.hypothesis.parts(best.x)[1:], strict=True
        ):
            print(f"  {one.kind}: {one.parameters(part)}")
    print(f"  {time.process_time() - begin:.1f} s of processor time", flush=True)


def told(data: DataSet, rung: Rung) -> str:
    """Return what a race was at one rate."""
    share = rung.rate / (2.0 * np.pi * data.frequency)
    base = error_of(data, rung.base.fit, rung.form.held_out)
    laws = ", ".join(_law(data, rung, score) for score in rung.scores[:SHOWN])
    return (
        f"  {share:6.3f}  best {rung.error:.4g}  floor {rung.floor:.4g}  none {base:.4g}"
        f" ({gain(rung.best, rung.base).t:.0f});  {laws}"
    )


def _law(data: DataSet, rung: Rung, score: Score) -> str:
    one = score.fit.hypothesis.added[0]
    left = error_of(data, score.fit, rung.form.held_out)
    return f"{one.kind}@{one.between[1]} {left:.4g} ({gain(rung.best, score).t:.0f})"


def main(words: list[str]) -> None:
    """Print the race of each campaign or folder."""
    for word in words:
        kind, _, seed = word.partition("*")
        with tempfile.TemporaryDirectory() as temporary:
            place = Path(temporary)
            if seed:
                campaign = draw(int(seed), kind)
                folder.write(campaign, place)
                print(word, campaign.truth["effects"], f"floor {campaign.noise_floor:.4g}")
            else:
                place = convert.folder_of(word, place) if word in convert.SETS else Path(word)
                print(word)
            run(place)


if __name__ == "__main__":
    main(sys.argv[1:])
