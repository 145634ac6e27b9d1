"""What other processes do in the tests of the runner."""

import os
import time

from blind.campaigns import draw
from blind.trial import Trial, diagnosed


def by_class(seed, kind, limit):
    """Answer at once, compute for ever, or die, by the seed."""
    if seed == 2:
        return diagnosed(draw(seed, kind), compute_for_ever, limit=limit)
    if seed == 3:
        os._exit(7)
    return Trial(seed, kind, 40.0, 0.01, {"effects": [], "fault": None}, {}, 1.0, 1.0)


def compute_for_ever(log, model, seed):
    while time.time() > 0.0:
        pass
