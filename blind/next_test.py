"""The test that a diagnosis proposes, carried out by the truth: whether it settles the matter.

`python -m blind --next-test TRIALS.json`: of every trial in that file that ended with ties or
with "cannot tell", the first proposal is simulated by the truth, recorded by the same chain and
added to the campaign, which is then diagnosed again. Settled is: exactly right, without a tie.
Play that never closed is then to be called a gap where the new test closed it, and a locked
joint by its law where the new test made it slip; where it did not, the first answer stays open.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from blind import nuisances
from blind.campaign import Campaign, TestRun
from blind.campaigns import Drawn, draw_all
from blind.excitations import Drive
from blind.judging import exact, family, hidden, named, number_of_ties, same_set
from blind.recorder import responses
from blind.structures import G
from blind.trial import Diagnose, Trial, diagnosed

UNITS = {"g": G, "m/s^2": 1.0, "N": 1.0}
LEVEL = re.compile(r"^\s*([-+.\deE]+)\s*\(?([a-zA-Z/^2]+?)\)?(\^2/Hz)?(\s+rms)?\s*$")
HIGHEST_HZ = 2500.0
"""Most of the recorder's band that a drive may use [Hz]."""


def open_ends(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials that ended with ties or could not tell, and propose a test."""
    return [
        trial
        for trial in trials
        if not trial.problem
        and (number_of_ties(trial) or trial.document["verdict"] == "cannot tell")
        and trial.document.get("next_test")
    ]


def drive_of(asked: dict[str, Any], like: Drive, number: int) -> Drive:
    """Return the drive of a proposed test; what it leaves open is as in a test of the campaign.

    Raises
    ------
    ValueError
        If level or excitation cannot be read.
    """
    found = LEVEL.match(str(asked["level"]))
    if not found or found[2] not in UNITS:
        raise ValueError(f"level {asked['level']!r} of the proposed test cannot be read")
    kind = str(asked["excitation"])
    if kind not in {"random", "sine sweep"}:
        raise ValueError(f"no truth moves under the proposed excitation {kind!r}")
    ends = asked.get("band_hz") or (like.low_hz, like.high_hz)
    low, high = max(min(ends), 2.0), min(max(ends), HIGHEST_HZ)
    value = float(found[1])
    level = np.sqrt(value * (high - low)) if found[3] else value
    if found[4] and kind == "sine sweep":
        level *= np.sqrt(2.0)
    return replace(
        like, kind=kind, level=float(level) * UNITS[found[2]], low_hz=low, high_hz=high,
        seed=(*like.seed[:2], number),
    )  # fmt: skip


def extended(drawn: Drawn, asked: dict[str, Any]) -> Campaign:
    """Return the campaign with the proposed test behind its others.

    Raises
    ------
    RuntimeError
        If the truth runs away in it.
    """
    plan, campaign = drawn.plan, drawn.campaign
    number = len(campaign.tests) + 1
    drive = drive_of(asked, plan.drives[1], number)
    louder = replace(plan, limit=plan.limit * max(1.0, drive.level / plan.drives[2].level))
    wave, motion = louder.move(drive, 3)
    if motion is None:
        raise RuntimeError("the specimen runs away in the proposed test")
    clean = responses(plan.structure, motion, plan.drawn, filtered=drawn.filtered)
    middle, _ = plan.move(plan.drives[1], 1)
    forced = plan.structure.force_on >= 0
    felt = nuisances.inputs(plan.drawn, [wave, middle], forced=forced)
    rng, flickering = (
        np.random.default_rng([plan.seed, 7]),
        np.random.default_rng([plan.seed, 8]),
    )
    quiet = [clean, campaign.tests[1].clean]
    inputs, noisy = drawn.channels.record(rng, flickering, felt, quiet)[0]
    more = TestRun(number, drive, hold_out=False, control=inputs, response=noisy, clean=clean)
    return replace(campaign, tests=(*campaign.tests, more))


def settled(trial: Trial) -> bool:
    """Whether a second diagnosis is exactly right and leaves no tie."""
    if trial.problem or number_of_ties(trial):
        return False
    if exact(trial) and family(trial.kind) not in {"locked", "unexercised"}:
        return True
    wanted = [
        ("gap" if kind == "unexercised" else kind, place) for kind, place in hidden(trial)
    ]
    found = named(trial.document)
    return (
        bool(wanted) and trial.document["verdict"] == "effect found" and same_set(found, wanted)
    )


def again(trial: Trial, judge: Diagnose, *, limit: float = 0.0) -> Trial:
    """Return the trial after the proposed test; a test that cannot be run settles nothing."""
    asked = trial.document["next_test"][0]
    try:
        campaign = extended(draw_all(trial.seed, trial.kind), asked)
    except (ValueError, RuntimeError) as error:
        after = replace(trial, problem=str(error))
    else:
        after = diagnosed(campaign, judge, limit=limit)
    first = {
        "asked": asked,
        "verdict": trial.document["verdict"],
        "effects": named(trial.document),
        "indistinguishable": trial.document.get("indistinguishable", []),
    }
    return replace(after, retest=first | {"settled": settled(after)})
