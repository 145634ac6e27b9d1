"""The diagnosis of a component test: the motion is imposed, the force is explained."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnose.decide import CALIBRATION, as_effect
from shakerproc.diagnose.imposed_choice import (
    ABOVE,
    Choice,
    choose,
    is_series,
    lead,
    squares,
    sureness,
)
from shakerproc.diagnose.imposed_fit import Bench, Fitted, bench, spread
from shakerproc.diagnose.imposed_laws import PLAY_AND_SLIDER, Law, motion_of
from shakerproc.diagnose.imposed_motion import loops
from shakerproc.diagnose.next_test import loudest, times_level
from shakerproc.diagnose.pipeline import MATTERS
from shakerproc.diagnose.problem import Hypothesis, Parameters, Term
from shakerproc.diagnose.translate import Skeleton
from shakerproc.diagnosis.data import TestArrays
from shakerproc.diagnosis.result import (
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    NextTest,
    Pair,
    Tried,
    Verdict,
    Where,
)

NEGLIGIBLE = 0.01
"""Share of the force that is as good as explained: what sensors are calibrated to [-]."""
HALF = 0.5
"""Share of what the linear model leaves (squared) that a law must explain to be named where
what it leaves is above the scatter between repeats [-]."""


def diagnose_imposed(
    known: Skeleton,
    tests: Sequence[TestArrays],
    base: Hypothesis,
    start: Parameters,
    clearances: Sequence[float],
    say: Callable[[str], None],
    seed: int,
) -> Diagnosis | None:
    """Return the diagnosis of a component test, or None where the motion is not imposed."""
    found = loops(known.structure, tests)
    if found is None:
        return None
    mass = float(known.structure.masses[0])
    at = bench(found, motion_of(found, mass))
    if np.unique(at.swing).size < 6 or np.all(at.hold_out):
        return None
    law = Law(tuple(term.candidate for term in base.terms))
    values = tuple(float(x) for own in start.values for x in own)
    choice = choose(at, law, values, say)
    say("the verdict")
    before = at.force - at.law(law, values)
    before = before - start.stiffness[0] * at.displacement - start.damping[0] * at.velocity
    for i in range(len(at.loops)):
        before[at.test == i] -= np.mean(before[at.test == i])
    return _worded(known, at, choice, before, len(law.parts), tests, clearances, seed)


def _worded(
    known: Skeleton, at: Bench, choice: Choice, before: FloatArray, n_base: int,
    tests: Sequence[TestArrays], clearances: Sequence[float], seed: int,
) -> Diagnosis:  # fmt: skip
    real = bool(choice.ordered) and _matters(at, choice)
    chosen = choice.ordered[0] if real else choice.linear
    kept = np.isfinite(chosen.scored)
    errors = Errors(
        Pair(_share(at, before, ~at.hold_out), _share(at, chosen.left, ~at.hold_out)),
        Pair(_share(at, before, kept), _share(at, chosen.scored, kept)),
        choice.floor.scatter,
    )
    between = known.between(0)
    outside = _outside(at, choice, errors, chosen)
    reach = float(np.max(np.abs(at.displacement)))
    unclosed = [c for c in clearances if c > reach]
    verdict: Verdict = "effect found"
    if outside:
        verdict = "outside library"
    elif not real:
        verdict = "cannot tell" if unclosed else "nothing missing"
    same = tuple(dict.fromkeys(
        kind for one in choice.same for kind in one.law.kinds
        if kind not in choice.ordered[0].law.kinds
    )) if real else ()  # fmt: skip
    effects = _findings(at, chosen, n_base, between, sureness(at, choice)) if real else ()
    sentence = _sentence(verdict, chosen, n_base, effects, between, errors, choice, same, reach)
    _, joint = spread(at, chosen)
    a, b = between
    linear = {
        f"stiffness {a}-{b}": _not_negative(chosen.stiffness, float(joint[0]), "N/m"),
        f"damping {a}-{b}": _not_negative(chosen.damping, float(joint[1]), "N s/m"),
    }
    return Diagnosis(
        verdict=verdict,
        sentence=sentence,
        effects=effects if verdict == "effect found" else (),
        indistinguishable=same if verdict == "effect found" else (),
        errors=errors,
        candidates=_tried(at, choice, n_base, between),
        where=_where(at, before),
        next_test=_next(verdict, unclosed, reach, tests),
        linear=linear,
        notes=_notes(at, choice, chosen, errors),
        seed=seed,
    )


def _matters(at: Bench, choice: Choice) -> bool:
    """Return whether the first explains more than chance and more than a trifle."""
    gain, error = lead(at, choice.ordered[0], choice.linear)
    left = np.sqrt(squares(choice.linear)) / at.rms
    trifle = max(ABOVE * choice.floor.scatter, NEGLIGIBLE)
    return gain > max(2.0 * error, MATTERS * squares(choice.linear)) and left > trifle


def _outside(at: Bench, choice: Choice, errors: Errors, chosen: Fitted) -> bool:
    """Return whether clearly more could be explained than the chosen law does.

    Within 1.5 times the scatter between repeats nothing is left. Above it a free curve of the
    motion says what could be explained at all: what neither it nor the law explains does not
    depend on the motion that was measured (a rig that rings).
    """
    after = errors.held_out.after
    if after <= max(ABOVE * choice.floor.scatter, NEGLIGIBLE):
        return False
    if after > ABOVE * choice.floor.reachable:
        return True
    return chosen is not choice.linear and bool(
        squares(chosen) > (1.0 - HALF) * squares(choice.linear)
    )


def _share(at: Bench, left: FloatArray, kept: NDArray[np.bool_]) -> float:
    """Return rms of what is left over rms of the force, over these samples [-]."""
    return float(np.sqrt(np.mean(left[kept] ** 2) / np.mean(at.force[kept] ** 2)))


def _not_negative(value: float, half: float, unit: str) -> Estimate:
    half = float(np.hypot(half, 1.96 * CALIBRATION * value))
    return Estimate(value, max(value - half, 0.0), value + half, unit)


def _estimates(at: Bench, fitted: Fitted) -> list[dict[str, Estimate]]:
    """Return the numbers of every part with 95 % intervals, by their names in the part."""
    half, _ = spread(at, fitted)
    wide, first, out = np.hypot(half, 1.96 * CALIBRATION), 0, []
    for part, values in zip(fitted.law.parts, fitted.law.split(fitted.values), strict=True):
        own: dict[str, Estimate] = {}
        for i, (name, unit, value) in enumerate(
            zip(part.names, part.units, values, strict=True)
        ):
            by = float(wide[first + i])
            if part.positive[i]:
                factor = float(np.exp(min(by, 50.0)))
                own[name] = Estimate(value, value / factor, value * factor, unit)
            else:
                own[name] = Estimate(
                    value, value - by * abs(value), value + by * abs(value), unit
                )
        first += len(part.names)
        mass = at.motion.mass
        out.append(own if part is PLAY_AND_SLIDER else as_effect(Term(part, 0, mass), own))
    return out


def _findings(
    at: Bench, fitted: Fitted, n_base: int, between: tuple[str, str], sure: float
) -> tuple[Finding, ...]:
    out = []
    numbers = _estimates(at, fitted)
    for part, own in zip(fitted.law.parts[n_base:], numbers[n_base:], strict=True):
        if part is not PLAY_AND_SLIDER:
            out.append(Finding(part.kind, between, sure, own))
            continue
        slider = {"sliding_force": own.pop("sliding_force")}
        out.append(Finding("coulomb_friction", between, sure, slider))
        out.append(Finding("gap", between, sure, own))
    return tuple(out)


def _tried(
    at: Bench, choice: Choice, n_base: int, between: tuple[str, str]
) -> tuple[Tried, ...]:
    out = []
    for one in choice.ordered:
        numbers = _estimates(at, one)[n_base:]
        parts = one.law.parts[n_base:]
        named = {
            f"{part.kind} {name}" if len(parts) > 1 else name: estimate
            for part, own in zip(parts, numbers, strict=True)
            for name, estimate in own.items()
        }
        if is_series(one):
            named["arrangement"] = Estimate("in series", None, None, "")
        kept = np.isfinite(one.scored)
        out.append(Tried(
            "+".join(part.kind for part in parts), between,
            _share(at, one.left, ~at.hold_out), _share(at, one.scored, kept), named,
        ))  # fmt: skip
    return (*out, Tried("attached_mode", between, None, None, {}))


def _sentence(
    verdict: Verdict, chosen: Fitted, n_base: int, effects: Sequence[Finding],
    between: tuple[str, str], errors: Errors, choice: Choice, same: tuple[str, ...],
    reach: float,
) -> str:  # fmt: skip
    named = " and ".join(effect.kind.replace("_", " ") for effect in effects)
    place = " and ".join(between)
    held, floor = errors.held_out, errors.noise_floor
    if verdict == "outside library":
        nearest = f"the nearest, {named}," if named else "the refitted model"
        return (
            f"Something is missing between {place} that is not in the library: {nearest} "
            f"leaves {held.after:.3g} of the force, a free curve of the motion "
            f"{choice.floor.free:.3g}, repeats differ by {floor:.3g}."
        )
    if verdict == "effect found":
        how = ""
        if is_series(chosen):
            force, stiffness, play = chosen.law.split(chosen.values)[
                chosen.law.parts.index(PLAY_AND_SLIDER)
            ]
            how = (
                f", which act in series: {2e3 * play:.3g} mm of free way, then a contact of "
                f"{stiffness:.3g} N/m, until the slider behind it gives way at {force:.4g} N"
            )
        doubt = f"; {', '.join(same)} would do as well on these tests" if same else ""
        return (
            f"The model lacks {named} between {place}{how}: the held-out error of the force "
            f"falls from {held.before:.3g} to {held.after:.3g}{doubt}."
        )
    if verdict == "cannot tell":
        return (
            f"The joint moved {reach:.3g} m at most and has a clearance beyond that: it never "
            "closed."
        )
    return (
        f"Nothing is missing up to a motion of {reach:.3g} m: the refitted model leaves "
        f"{held.after:.3g} of the force, repeats differ by {floor:.3g}."
    )


def _where(at: Bench, before: FloatArray) -> Where:
    """Return where the model as it was fails: motions and tests above the average."""
    tests = [float(np.mean(before[at.test == i] ** 2)) for i in range(len(at.loops))]
    average = float(np.mean(before**2))
    names = [loop.name for loop in at.loops]
    return Where(
        (),
        _range(np.abs(at.displacement), before**2),
        _range(np.abs(at.velocity), before**2),
        tuple(n for n, value in zip(names, tests, strict=True) if value >= 0.99 * average),
    )


def _range(size: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Return the range of a motion over which more than the average is left."""
    shares = np.array_split(np.argsort(size), 20)
    bad = [own for own in shares if own.size and np.mean(left[own]) > np.mean(left)]
    if not bad:
        return float(np.min(size)), float(np.max(size))
    return float(np.min(size[bad[0]])), float(np.max(size[bad[-1]]))


def _next(
    verdict: Verdict, unclosed: Sequence[float], reach: float, tests: Sequence[TestArrays]
) -> tuple[NextTest, ...]:
    if verdict not in {"cannot tell", "nothing missing"}:
        return ()
    like = loudest(tests)
    times = 1.2 * min(unclosed) / reach if unclosed else 2.0
    reason = "closes the clearance of the log" if unclosed else "moves beyond what was tested"
    level = times_level(like, times, forced=True)
    return (NextTest(like.excitation, level, (), reason, like.band, like.name),)


def _notes(at: Bench, choice: Choice, chosen: Fitted, errors: Errors) -> tuple[str, ...]:
    worst = max(loop.inertia for loop in at.loops)
    floor = choice.floor
    source = (
        "repeats of the same swing differ" if floor.repeated
        else "no swing was repeated; the noise of the force sensor is"
    )  # fmt: skip
    out = [
        f"Inertia is {100.0 * worst:.2g} % of the force at most, so the motion counts as "
        "imposed and the force is what is explained; errors are shares of the force.",
        f"Of the force {source} {floor.scatter:.3g}, and a free curve of displacement, "
        f"velocity and way since the last turn leaves {floor.free:.3g} of swings it was not "
        "fitted to.",
    ]
    if is_series(chosen):
        out.append(
            "Gap and friction act one behind the other. In a model file that takes a small "
            "mass between them: the gap on its one side, the friction on the other."
        )
    if chosen is not choice.linear and errors.held_out.after > ABOVE * floor.scatter:
        out.append(
            "What is left is more than repeats differ by, but a free curve of the motion does "
            "not do clearly better, as where a rig rings; the intervals hold the scatter "
            "between swings."
        )
    if not np.any(at.hold_out):
        out.append(
            "No test is marked hold_out: true; the held-out error is of every third swing in "
            "turn, by fits that it took no part in."
        )
    return tuple(out)
