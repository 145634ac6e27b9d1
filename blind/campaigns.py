"""Hidden campaigns: three levels and a held-out test, drawn by seed and class.

Seeds below 100000 are for tuning; seeds from 100000 on are looked at once. `BLIND_CACHE` names
a folder in which drawn campaigns are kept.
"""

import zlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from blind import cache, classes, nuisances, ranges
from blind.assembly import assemble, exercised
from blind.campaign import Campaign, TestRun
from blind.classes import CampaignClass
from blind.draws import Rng
from blind.excitations import SAMPLE_RATE, Drive, waveform
from blind.nuisances import Nuisances
from blind.ranges import Hidden, friction
from blind.recorder import SUBSTEPS, Channels, draw_fault, responses, rms
from blind.structures import (
    Structure,
    draw_drives,
    draw_structure,
    linear_stretch,
    nominal_of,
    rigid_force,
    scale_of,
)
from blind.truth import Motion, move

TUNING_SEEDS_END = 100_000
ATTEMPTS, GROWTH_LIMIT = 40, 100.0
"""Draws of one campaign at most; a motion beyond so many linear ones has run away."""


@dataclass(frozen=True)
class Wanted:
    """Which campaign is to be drawn."""

    seed: int
    text: str
    kind: CampaignClass


@dataclass(frozen=True)
class Plan:
    """What one attempt at a campaign draws before anything moves."""

    seed: int
    text: str
    kind: CampaignClass
    structure: Structure
    at: int
    drives: list[Drive]
    hidden: list[tuple[str, Hidden]]
    fault: str | None
    snr: float
    drawn: Nuisances
    limit: float

    @property
    def noise(self) -> float:
        """Noise over the response [-]."""
        return float(10.0 ** (-self.snr / 20.0))

    @property
    def between(self) -> list[str]:
        """Return the two places of the joint."""
        joint = self.structure.joints[self.at]
        return [self.structure.name(joint.first), self.structure.name(joint.second)]

    def move(self, drive: Drive, number: int) -> tuple[np.ndarray, Motion | None]:
        """Return the excitation at the samples, and the motion of a test or None."""
        wave = waveform(drive, 2 * SUBSTEPS)
        truth, _ = assemble(
            self.structure, self.at, [h for _, h in self.hidden], self.drawn, number
        )
        still = np.zeros_like(wave)
        base, force = (still, wave) if truth.force_on >= 0 else (wave, still)
        motion = move(
            truth, base, force, sample_rate=SAMPLE_RATE, substeps=SUBSTEPS, limit=self.limit
        )
        return wave[:-1][:: 2 * SUBSTEPS], motion


def draw(seed: int, text: str) -> Campaign:
    """Return the campaign of this seed and class.

    Raises
    ------
    RuntimeError
        If no draw exercises the effect.
    """
    stored = cache.load(seed, text)
    if stored is not None:
        return stored
    kind = classes.parse(text)
    rng = np.random.default_rng([seed, zlib.crc32(kind.base.encode())])
    snr = rng.uniform(30.0, 60.0)
    if kind.regime == "locked" and kind.name == "lugre_friction":
        snr = 30.0 + 0.25 * (snr - 30.0)  # no bristle is rigid to less noise
    for attempt in range(ATTEMPTS):
        structure = draw_structure(rng, kind.form)
        louder = 0.0 if kind.regime == "locked" else 6.0 * (attempt // 6)
        loud = min(snr + louder, 60.0)
        plan = _plan(rng, Wanted(seed, text, kind), structure, loud)
        campaign = _attempt(rng, plan)
        if campaign is not None:
            cache.store(campaign)
            return campaign
    raise RuntimeError(f"{text}, seed {seed}: no draw exercises the effect")


def _attempt(rng: Rng, plan: Plan) -> Campaign | None:
    control: dict[int, np.ndarray] = {}
    motions: dict[int, Motion] = {}
    for i in (2, 0, 1, 3):
        control[i], motion = plan.move(plan.drives[i], i)
        if motion is None or (i == 2 and not _wanted(plan, motion)):
            return None
        if plan.kind.regime == "locked" and friction.slips(plan.hidden[0][1], motion):
            return None
        motions[i] = motion
    filtered = bool(rng.random() < 0.5)
    clean = [
        responses(plan.structure, motions[i], plan.drawn, filtered=filtered) for i in range(4)
    ]
    return _record(rng, plan, [control[i] for i in range(4)], clean, motions)


def _plan(rng: Rng, wanted: Wanted, structure: Structure, snr: float) -> Plan:
    kind = wanted.kind
    drives = draw_drives(rng, wanted.seed, structure, kind.drive)
    wave = waveform(drives[1], 2 * SUBSTEPS)[:-1][:: 2 * SUBSTEPS]
    middle = linear_stretch(structure, wave)
    louder = drives[2].level / drives[1].level
    peak = np.max(np.abs(middle), axis=1) * louder
    at = int(rng.integers(len(structure.joints)))
    names, fault = _contents(rng, kind)
    scale = scale_of(structure, structure.joints[at], middle[at])
    rigid = rms(rigid_force(structure, at, wave)) * louder
    rigid *= 1.0 if drives[0].kind == "random" else np.sqrt(2.0)
    hidden = []
    for name in names:
        if name == "unexercised":
            effect = _unexercised(rng, scale, float(peak[at]))
        else:
            effect = {**ranges.EFFECTS, **ranges.OUTSIDE}[name](rng, scale)
        if kind.regime:
            mass, drive = sum(structure.masses[at:]), drives[0].kind
            effect = friction.in_regime(rng, effect, kind.regime, drive, rigid=(rigid, mass))
        hidden.append((name, effect))
    drawn = nuisances.draw(wanted.seed, kind.base, kind.nuisances, len(structure.masses))
    limit = GROWTH_LIMIT * float(np.max(peak))
    return Plan(
        wanted.seed, wanted.text, kind, structure, at, drives, hidden, fault, snr, drawn, limit
    )


def _unexercised(rng: Rng, scale: ranges.Scale, peak: float) -> Hidden:
    """Return a gap that never closes."""
    scale = replace(scale, displacement=peak * rng.uniform(1.5, 3.0) / 0.9)
    while True:
        effect = ranges.EFFECTS["gap"](rng, scale)
        if effect.parameters["clearance"] >= 1.3 * peak:
            return effect


def _contents(rng: Rng, kind: CampaignClass) -> tuple[list[str], str | None]:
    """Return the hidden effects and the fault of a class."""
    if kind.name == "none":
        return [], None
    if kind.name in ranges.FAULTS:
        return [], kind.name
    if kind.name == "outside":
        return [kind.chosen or str(rng.choice(list(ranges.OUTSIDE)))], None
    if kind.name == "pair":
        pair = ranges.PAIRS[rng.integers(len(ranges.PAIRS))] if not kind.chosen else ()
        labels = pair or tuple(kind.chosen.split("+"))
        effects = [label for label in labels if label not in ranges.FAULTS]
        return effects, next((label for label in labels if label in ranges.FAULTS), None)
    return [kind.name], None


def _wanted(plan: Plan, motion: Motion) -> bool:
    """Whether the loudest test exercises what is hidden, in the regime that is asked for."""
    if plan.kind.name == "unexercised":
        return True
    effects = [effect for _, effect in plan.hidden]
    _, columns = assemble(plan.structure, plan.at, effects, plan.drawn, 2)
    shown = exercised(plan.structure, plan.at, motion, columns)
    if plan.kind.regime:
        if not _in_regime(plan, motion, columns[0][0]):
            return False
        if plan.kind.regime == "locked":
            return True
    for effect in effects:
        z = motion.stretch[:, columns[0][0]]
        if effect.wells and not np.min(z) < -0.5 * abs(effect.start) < 0.5 * abs(
            effect.start
        ) < np.max(z):
            return False
    return all(e > max(0.03, 3.0 * plan.noise) for e in shown)


def _in_regime(plan: Plan, motion: Motion, column: int) -> bool:
    """Whether a law of dry friction slides, sticks or is locked as the class asks."""
    driven = slice(int(1.4 * SAMPLE_RATE), -int(0.4 * SAMPLE_RATE))
    rate, force = motion.rate[driven, column], motion.force[driven, column]
    effect = plan.hidden[0][1]
    share = friction.sticking_share(effect, rate, force)
    relative = rms(np.diff(rate)) * SAMPLE_RATE
    mass = plan.structure.joints[plan.at].second
    departure = relative / rms(motion.acceleration[:, mass])
    return friction.accepted(plan.kind.regime, share, departure, plan.noise)


def _record(
    rng: Rng,
    plan: Plan,
    control: list[np.ndarray],
    clean: list[np.ndarray],
    motions: dict[int, Motion],
) -> Campaign:
    own = bool(rng.random() < 0.3)
    spoil, fault_numbers = draw_fault(rng, plan.fault, clean, plan.noise)
    faulty = int(rng.integers(clean[0].shape[0]))
    flickering = np.random.default_rng([plan.seed, zlib.crc32(plan.text.encode()), 1])
    channels = Channels(plan.noise, own, faulty, spoil, plan.drawn)
    inputs = nuisances.inputs(plan.drawn, control, forced=plan.structure.force_on >= 0)
    recorded = channels.record(rng, flickering, inputs, clean)
    tests = tuple(
        TestRun(i + 1, drive, i == 3, *recorded[i], clean[i])
        for i, drive in enumerate(plan.drives)
    )
    fault = {"kind": plan.fault, "channel": f"ch{3 + faulty}", **fault_numbers}
    truth = _truth(plan, fault if plan.fault else None, motions)
    floor = plan.noise * rms(clean[3 if own else 1][0]) / rms(clean[3][0])
    nominal = nominal_of(rng, plan.structure)
    details = {"snr_db": plan.snr, "noise_follows_level": own, "known": _known(plan)}
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
    effects = [
        {
            "kind": h.kind or name,
            "between": plan.between,
            "parameters": h.parameters,
            "main": h.main,
        }
        for name, h in plan.hidden
    ]
    truth = {"class": plan.text, "effects": effects, "fault": fault}
    if plan.drawn.numbers:
        truth["nuisances"] = plan.drawn.numbers
    if plan.kind.regime:
        carried = max(float(np.max(np.abs(motions[i].force[:, 0]))) for i in range(3))
        truth |= {"regime": plan.kind.regime, "largest_force": carried}
    return truth
