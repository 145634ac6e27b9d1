"""What one attempt at a campaign draws before anything moves, and whether it will do."""

from dataclasses import dataclass, replace

import numpy as np

from blind import nuisances, ranges
from blind.assembly import assemble, exercised, shows
from blind.classes import CampaignClass
from blind.draws import Rng
from blind.excitations import SAMPLE_RATE, Drive, waveform
from blind.nuisances import Nuisances
from blind.ranges import Hidden, friction
from blind.recorder import SUBSTEPS, rms
from blind.structures import (
    Structure,
    draw_drives,
    linear_stretch,
    rigid_force,
    scale_of,
)
from blind.truth import Motion, move

GROWTH_LIMIT = 100.0
"""A motion beyond so many linear ones has run away [-]."""


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
        return wave[:-1][:: 2 * SUBSTEPS], self.driven(wave, number)

    def driven(self, wave: np.ndarray, number: int) -> Motion | None:
        """Return the motion of a test under an excitation, 2 * SUBSTEPS values a sample."""
        truth, _ = assemble(
            self.structure, self.at, [h for _, h in self.hidden], self.drawn, number
        )
        still = np.zeros_like(wave)
        base, force = (still, wave) if truth.force_on >= 0 else (wave, still)
        return move(
            truth, base, force, sample_rate=SAMPLE_RATE, substeps=SUBSTEPS, limit=self.limit
        )


def make_plan(rng: Rng, wanted: Wanted, structure: Structure, snr: float) -> Plan:
    """Return what a campaign of this structure and noise is to hold."""
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


def will_do(plan: Plan, motion: Motion) -> bool:
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
    return shows(shown, plan.noise)


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
