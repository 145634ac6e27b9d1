"""Short campaigns of the blind truth, whose every number is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from blind.campaign import Campaign, TestRun
from blind.excitations import SAMPLE_RATE, Drive, waveform
from blind.ranges import Hidden
from blind.structures import Joint, Structure
from blind.truth import move

from blind import assembly, folder

SUBSTEPS = 8
OMEGA, ZETA, MASS = 2.0 * np.pi * 120.0, 0.02, 0.4
JOINT = Joint(-1, 0, MASS * OMEGA**2, 2.0 * ZETA * MASS * OMEGA)
ONE_MASS = Structure((MASS,), (JOINT,))
TWO_MASSES = Structure((MASS, 0.3), (JOINT, Joint(0, 1, 2.5e5, 6.0)))
NOISE = 0.005


def drive(kind="random", level=5.0, number=1, *, up=True):
    high = 800.0 if kind == "random" else 400.0
    return Drive(kind, level, 20.0, high, up, 0.6, 0.1, (number, 77))


TWO_LEVELS = (drive(), drive(level=15.0, number=2))


def campaign(
    structure=ONE_MASS,
    hidden: tuple[tuple[int, Hidden], ...] = (),
    drives=TWO_LEVELS,
    hold_out=(),
    seconds=5.0,
    noise=NOISE,
) -> Campaign:
    """A campaign with these effects, each at a joint given by its number; noise is a share."""
    n = int(seconds * SAMPLE_RATE)
    rng = np.random.default_rng(5)
    truth, _ = assembly.assemble(structure, 0, [])
    for at, effect in hidden:
        more, _ = assembly.assemble(structure, at, [effect])
        truth = replace(truth, elements=truth.elements + more.elements)
    tests = []
    for i, one in enumerate(drives):
        wave = waveform(one, 2 * SUBSTEPS, n)
        still = np.zeros_like(wave)
        pushed = structure.force_on >= 0
        base, push = (still, wave) if pushed else (wave, still)
        motion = move(truth, base, push, sample_rate=SAMPLE_RATE, substeps=SUBSTEPS, limit=1.0)
        clean = {
            "acceleration": motion.acceleration[::SUBSTEPS].T,
            "displacement": motion.displacement.T,
        }[structure.measures].copy()
        given = wave[:-1][:: 2 * SUBSTEPS]
        size = noise * np.sqrt(np.mean(clean**2, axis=1, keepdims=True))
        response = clean + size * rng.standard_normal(clean.shape)
        control = np.tile(given, (1 if pushed else 2, 1))
        control = control + noise * np.std(given) * rng.standard_normal(control.shape)
        tests.append(TestRun(i + 1, one, i in hold_out, control, response, clean))
    return Campaign(1, "known", structure, structure, tuple(tests), {}, noise, {"known": ()})


def off(structure, stiffness=1.0, damping=1.0):
    """The same structure with other numbers, as a wrong model has them."""
    joints = tuple(
        replace(j, stiffness=j.stiffness * stiffness, damping=j.damping * damping)
        for j in structure.joints
    )
    return replace(structure, joints=joints)


def written(made: Campaign, path: Path, nominal=None) -> tuple[Path, Path]:
    """The log and the model of a campaign, on disk."""
    return folder.write(made if nominal is None else replace(made, nominal=nominal), path)
