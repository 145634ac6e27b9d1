"""Numbers fitted to blind campaigns, the effect in the model: how many lie in their intervals.

``python -m benchmarks.fitted_numbers [FIRST [COUNT]]``. The model of each campaign is the
nominal one with the hidden effect, all its numbers 10 % off, as in `benchmarks.forecast`; gains
of channels are off by chance, 1 % one standard deviation, which the intervals hold. Numbers
that no test tells have no interval. ``BLIND_SECONDS=7`` makes tests of 7 s, of 20 s by default.
"""

import argparse

import numpy as np
from blind.structures import Structure

from benchmarks.forecast import CLASSES, Ready, ready
from shakerproc.diagnosis.estimation.uncertain import WIDTH
from shakerproc.diagnosis.fitted_numbers import fit_of, numbers_of
from shakerproc.diagnosis.hypotheses.own_numbers import OwnNumber
from shakerproc.models import Model

WITHOUT = (
    "without:", "bistable", "constant_force", "stiffness_drift", "saturating", "power_law",
)  # fmt: skip
"""Classes whose truth has no number for each of the model, or one at another reference."""
TOLD = 1.0
"""Standard deviation of a logarithm from which a number is not told [-]."""


def truth_of(own: Ready, model: Model, number: OwnNumber) -> float:
    """Return the true value of a number of the model [SI]."""
    structure: Structure = own.drawn.plan.structure
    if number.element is None:
        return float(structure.masses[list(model.masses).index(number.name)])
    kinds = [element.effect.kind for element in model.elements]
    hidden = own.drawn.campaign.truth["effects"]
    first = len(kinds) - len(hidden)
    if number.element >= first:
        return float(hidden[number.element - first]["parameters"][number.name])
    before = kinds[: number.element].count(kinds[number.element])
    return float(getattr(structure.joints[before], number.name))


def scores(own: Ready) -> list[tuple[str, float, float]]:
    """Return each number with how far it is off, and its standard uncertainty [-]."""
    fit = fit_of(own.model, [test for test in own.tests if not test.test.hold_out])
    numbers, model = numbers_of(fit), fit.hypothesis.model
    spread = np.sqrt(np.diag(numbers.covariance))[: fit.x.size]
    found = []
    for number, x, own_spread in zip(fit.hypothesis.own, fit.x, spread, strict=True):
        off = float(x) - float(np.log(truth_of(own, model, number) / number.value(model)))
        found.append((number.name, off, float(own_spread)))
    return found


def main() -> None:
    """Print each campaign, and the share of numbers that lie in their intervals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", nargs="?", type=int, default=701, help="seed")
    parser.add_argument("count", nargs="?", type=int, default=17, help="campaigns")
    asked = parser.parse_args()
    classes = [text for text in CLASSES if not text.startswith(WITHOUT)]
    held = told = 0
    for i in range(asked.count):
        seed, text = asked.first + i // len(classes), classes[i % len(classes)]
        every = [one for one in scores(ready(seed, text)) if one[2] < TOLD]
        within = [abs(off) <= WIDTH * spread for _, off, spread in every]
        held, told = held + sum(within), told + len(within)
        print(f"{text} {seed}: {sum(within)} of {len(within)}", flush=True)
        for (name, off, spread), inside in zip(every, within, strict=True):
            print(f"  {name:24s} off {off:+.2%}, standard uncertainty {spread:.2%}"
                  f"{'' if inside else '  <- outside'}")  # fmt: skip
    print(f"{held} of {told} in their 95 % intervals")


if __name__ == "__main__":
    main()
