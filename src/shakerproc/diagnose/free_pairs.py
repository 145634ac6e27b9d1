"""A second effect beside dry friction, by free runs: friction hides it from the screening."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose import kernel
from shakerproc.diagnose.candidates import CUBIC, Candidate, Motion, Values, library
from shakerproc.diagnose.decide import EXPONENT
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.free_run import (
    Hunt,
    as_recorded,
    carried_on,
    coulomb_fits,
    hunt_for,
    judged,
)
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    Term,
    assemble,
    law_table,
    run,
    unaided_tuning,
)
from shakerproc.diagnose.search import DRY, Bench, Context, deviance, one_of_each

SHARES = (0.1, 0.3, 1.0)
"""Force of a second effect to try, over that of the linear spring, both rms [-]."""
OF_EACH = 3
"""Points of the grid of every effect from which fits begin."""
BEST = 4
"""Of these fits, how many are carried to their end."""


def friction_pairs(
    bench: Bench, start: Parameters, base: Fit, fits: Sequence[Fit]
) -> tuple[Context, list[Fit]] | None:
    """Return Coulomb friction and one effect more, fitted by free runs; None if it fails.

    Parameters are those of `friction_fits`.
    """
    hunt = hunt_for(bench) if bench.structure.masses.size == 1 else None
    near = [] if hunt is None else coulomb_fits(hunt, start, base, fits)
    if hunt is None or not near:
        return None
    begun = _begun(hunt, start, near[0])
    with ThreadPoolExecutor(2) as pool:
        ends = pool.map(lambda job: hunt.at.fit(job[0], job[1], hunt.pieces, 6), begun)
        found = one_of_each(sorted((f for f in ends if f is not None), key=deviance))
    if not found:
        return None
    at, best = as_recorded(hunt.at, found[0], hunt.pieces)
    found = [best, *carried_on(at, found[1:BEST], hunt.pieces)]
    found += carried_on(at, _cubic(at, min(found, key=deviance), hunt.pieces), hunt.pieces)
    found = one_of_each(sorted(found, key=deviance))[:BEST]
    final, ended = judged(bench, base.parameters, found, hunt.pieces)
    return final, sorted(ended, key=deviance)


def _begun(hunt: Hunt, start: Parameters, coulomb: Fit) -> list[tuple[Hypothesis, Parameters]]:
    """Return where to begin: the best points of every effect beside the friction."""
    d, v, motion = _moved(hunt, coulomb)
    if not motion.rms > 0.0:  # it sticks throughout: nothing moves a second effect
        return []
    *rest, term = coulomb.hypothesis.terms
    out = []
    for candidate in library(motion):
        if candidate.kind in DRY or candidate.kind == "lugre_friction":
            continue
        hypothesis = replace(
            coulomb.hypothesis, terms=(*rest, Term(candidate, term.joint, term.mass), term)
        )
        *known, force = coulomb.parameters.values
        points = [
            replace(place, values=(*known, values, force))
            for values in _values(candidate, motion, d, v, hunt)
            for place in (coulomb.parameters, start)
        ]
        with ThreadPoolExecutor(2) as pool:
            heights = list(
                pool.map(lambda p, h=hypothesis: hunt.at.height(h, p, (hunt.loudest,)), points)
            )
        order = [i for i in np.argsort(heights)[:OF_EACH] if np.isfinite(heights[i])]
        out += [(hypothesis, points[i]) for i in order]
    return out


def _cubic(at: Context, fit: Fit, pieces: tuple[Segment, ...]) -> list[Fit]:
    """Return a cubic spring in place of a power law whose exponent is about 3."""
    *rest, power, term = fit.hypothesis.terms
    if power.candidate.kind != "power_law":
        return []
    *known, (force, exponent), friction = fit.parameters.values
    if abs(exponent - EXPONENT) > 0.3:
        return []
    cubic = replace(power, candidate=CUBIC)
    size = force / float(power.candidate.fixed["reference_displacement"]) ** EXPONENT
    begun = at.fit(
        replace(fit.hypothesis, terms=(*rest, cubic, term)),
        replace(fit.parameters, values=(*known, (size,), friction)), pieces, 0,
    )  # fmt: skip
    return [] if begun is None else [begun]


def _moved(hunt: Hunt, coulomb: Fit) -> tuple[FloatArray, FloatArray, Motion]:
    """Return displacement, velocity and scales of the motion that friction alone foretells."""
    structure, p = hunt.at.bench.structure, coulomb.parameters
    whole = assemble(structure, coulomb.hypothesis, p)
    table = law_table(structure, coulomb.hypothesis, p, whole.masses.size)
    tuned = unaided_tuning(structure, np.ones(len(structure.sensing)))
    seen = run(whole, table, hunt.loudest, tuned, p, keep=True)
    d, v = (np.zeros(2), np.zeros(2)) if seen is None else seen.states
    rms, fast = float(np.std(d)), float(np.std(v))
    k, c, mass = float(p.stiffness[0]), float(p.damping[0]), float(structure.masses[0])
    frequency = fast / max(rms, 1e-300) / (2.0 * np.pi)
    peak = float(np.max(np.abs(d)))
    return d, v, Motion(peak, rms, fast, k, c, mass, frequency, 0.0, hunt.force)


def _values(
    candidate: Candidate, motion: Motion, d: FloatArray, v: FloatArray, hunt: Hunt
) -> list[Values]:
    """Return numbers of an effect whose force is of the size of the spring's."""
    out = []
    step = 1.0 / hunt.loudest.sample_rate
    for inner in candidate.grid(motion)[::2]:
        columns = candidate.columns(inner, motion.stiffness)
        if len(columns) != 1:
            continue
        op, numbers = columns[0]
        force = np.empty(d.size)
        table = np.array([[*numbers, *[0.0] * (8 - len(numbers))]])
        kernel.force_along(op, table, d, v, 0.0, step, force)
        size = float(np.sqrt(np.mean(force**2)))
        if not size > 0.0:
            continue
        signs = (1.0,) if candidate.positive[0] else (1.0, -1.0)
        for share in (s * sign for s in SHARES for sign in signs):
            weight = np.array([share * motion.stiffness * motion.rms / size])
            values = candidate.combine(inner, weight, motion)
            if values is not None:
                out.append(values)
    return out
