"""The race of laws over the nudging rate, on hidden campaigns and on folders.

python -m benchmarks.nudged gap*520000 friction_damper FOLDER ...

A campaign of `blind` is named by class and seed, a real set as `benchmarks.real` names it; a
folder holds model.yaml and testlog.yaml.
Printed are the laws that kept up to the last rate and those that left, each with the level that
it leaves there and its numbers, and the seconds of processor time.
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
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.diagnosis.nudged.race import raced
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog


def run(place: Path) -> None:
    """Print the race of the model and the tests of a folder."""
    model = read_model(place / "model.yaml")
    measured = tests_of(read_testlog(place / "testlog.yaml"), model).tests
    sensors = {name: model.sensors[name] for name in measured[0].sensors}
    tests = prepared([arrays(one) for one in measured], imposed=model.excitation.imposed)
    begin = time.process_time()
    campaign = campaign_of(replace(model, sensors=sensors), tests)
    none = hypothesis_of(campaign.data.model)
    one = raced(campaign.data, none, np.zeros(none.size), campaign.known, lambda _text: None)
    rates = [round(rung.rate, 3) for rung in ladder_of(campaign.data)]
    print(f"  none {one.base.level:.4g}, rates {rates}")
    for fit in one.fits:
        print(f"  {told(fit)}")
    for fit in sorted(one.left, key=lambda fit: fit.level)[:8]:
        print(f"    left: {fit.hypothesis.kinds[-1]} {fit.level:.4g}")
    print(f"  {time.process_time() - begin:.1f} s of processor time", flush=True)


def told(one: Fit) -> str:
    """Return an effect with its numbers and the level that it leaves."""
    last, part = one.hypothesis.added[-1], one.hypothesis.parts(one.x)[-1]
    return f"{last.kind} {last.between} {one.level:.4g}: {last.parameters(part)}"


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
