"""Hidden campaigns: three levels and a held-out test, drawn by seed and class.

Seeds below 100000 are for tuning; seeds from 100000 on are looked at once. `BLIND_CACHE` names
a folder in which drawn campaigns are kept.
"""

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind import brief, cache, classes, nuisances
from blind.campaign import Campaign, TestRun
from blind.draws import Rng
from blind.plan import Plan, Wanted, make_plan, will_do
from blind.ranges import friction
from blind.recorder import Channels, draw_fault, responses, rms
from blind.structures import draw_structure, nominal_of
from blind.truth import Motion

TUNING_SEEDS_END = 100_000
ATTEMPTS = 40
"""Draws of one campaign at most."""


@dataclass(frozen=True)
class Drawn:
    """A campaign with all that it takes to record one more test of it."""

    campaign: Campaign
    plan: Plan
    channels: Channels
    filtered: bool


def draw(seed: int, text: str) -> Campaign:
    """Return the campaign of this seed and class."""
    if classes.parse(text).form in classes.BRIEF:
        return brief.draw(seed, text)
    stored = cache.load(seed, text)
    if stored is None:
        stored = draw_all(seed, text).campaign
        cache.store(stored)
    return stored


def draw_all(seed: int, text: str) -> Drawn:
    """Return the campaign of this seed and class, with its plan.

    Raises
    ------
    RuntimeError
        If no draw exercises the effect.
    """
    kind = classes.parse(text)
    rng = np.random.default_rng([seed, zlib.crc32(kind.base.encode())])
    snr = rng.uniform(30.0, 60.0)
    if kind.regime == "locked" and kind.name == "lugre_friction":
        snr = 30.0 + 0.25 * (snr - 30.0)  # no bristle is rigid to less noise
    for attempt in range(ATTEMPTS):
        structure = draw_structure(rng, kind.form)
        louder = 0.0 if kind.regime == "locked" else 6.0 * (attempt // 6)
        loud = min(snr + louder, 60.0)
        drawn = _attempt(rng, make_plan(rng, Wanted(seed, text, kind), structure, loud))
        if drawn is not None:
            return drawn
    raise RuntimeError(f"{text}, seed {seed}: no draw exercises the effect")


def _attempt(rng: Rng, plan: Plan) -> Drawn | None:
    control: dict[int, np.ndarray] = {}
    motions: dict[int, Motion] = {}
    for i in (2, 0, 1, 3):
        control[i], motion = plan.move(plan.drives[i], i)
        if motion is None or (i == 2 and not will_do(plan, motion)):
            return None
        if plan.kind.regime == "locked" and friction.slips(plan.hidden[0][1], motion):
            return None
        motions[i] = motion
    filtered = bool(rng.random() < 0.5)
    clean = [
        responses(plan.structure, motions[i], plan.drawn, filtered=filtered) for i in range(4)
    ]
    own = bool(rng.random() < 0.3)
    spoil, fault_numbers = draw_fault(rng, plan.fault, clean, plan.noise)
    faulty = int(rng.integers(clean[0].shape[0]))
    channels = Channels(plan.noise, own, faulty, spoil, plan.drawn)
    fault = {"kind": plan.fault, "channel": f"ch{3 + faulty}", **fault_numbers}
    truth = _truth(plan, fault if plan.fault else None, motions)
    campaign = _record(rng, plan, channels, ([control[i] for i in range(4)], clean), truth)
    return Drawn(campaign, plan, channels, filtered)


def _record(
    rng: Rng,
    plan: Plan,
    channels: Channels,
    quiet: tuple[list[np.ndarray], list[np.ndarray]],
    truth: dict[str, Any],
) -> Campaign:
    """Return the campaign whose excitations and responses without noise are `quiet`."""
    control, clean = quiet
    flickering = np.random.default_rng([plan.seed, zlib.crc32(plan.text.encode()), 1])
    inputs = nuisances.inputs(plan.drawn, control, forced=plan.structure.force_on >= 0)
    recorded = channels.record(rng, flickering, inputs, clean)
    tests = tuple(
        TestRun(i + 1, drive, i == 3, *recorded[i], clean[i])
        for i, drive in enumerate(plan.drives)
    )
    floor = plan.noise * rms(clean[3 if channels.own else 1][0]) / rms(clean[3][0])
    nominal = nominal_of(rng, plan.structure)
    details = {
        "snr_db": plan.snr, "noise_follows_level": channels.own, "known": _known(plan),
    }  # fmt: skip
    return Campaign(plan.seed, plan.text, plan.structure, nominal, tests, truth, floor, details)


def _known(plan: Plan) -> list[dict[str, Any]]:
    """Return the elements that the user's model holds besides springs and dampers."""
    between = plan.between
    return [
        {"kind": kind, "between": between, **numbers}
        for _, effect in plan.hidden
        for kind, numbers in effect.known
    ]


def _truth(
    plan: Plan, fault: dict[str, Any] | None, motions: dict[int, Motion]
) -> dict[str, Any]:
    effects = [hidden.as_truth(name, plan.between) for name, hidden in plan.hidden]
    truth = {"class": plan.text, "effects": effects, "fault": fault}
    if plan.drawn.numbers:
        truth["nuisances"] = plan.drawn.numbers
    if plan.kind.regime:
        carried = max(float(np.max(np.abs(motions[i].force[:, 0]))) for i in range(3))
        truth |= {"regime": plan.kind.regime, "largest_force": carried}
    return truth
