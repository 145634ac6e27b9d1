"""Whether a document says what is true: one rule for every class.

Exactly right is: the verdict, and all kinds with their joints (channels, for faults), no more
and no less. A joint that never slipped (`locked`) is right where the document says so in
`locked`, a list of `{"between": [...], "holds_at_least": {"value": ..., "unit": "N"}}`: the
joint is there, the force is above 0 and at most the truth's breakaway force (2 % more are
allowed for noise); the verdict is "nothing missing" or "cannot tell"; and what stands in
`effects` is none, or laws of dry friction at that joint whose forces have no upper bound.
"""

from typing import Any

from blind import classes, ranges
from blind.trial import Trial

Name = tuple[str, tuple[str, ...]]
"""A kind, and the two places of an effect or the channel of a fault."""
LOCKED_TOLERANCE = 1.02
"""Bound over the truth's breakaway force at most: noise is part of the largest force [-]."""
FAMILY_OF_FRICTION = (*ranges.FRICTION, "jenkins", "iwan", "bouc_wen")


def family(kind: str) -> str:
    """Return what a class asks for: effect, locked, none, unexercised, fault, outside, pair."""
    parsed = classes.parse(kind)
    if parsed.regime == "locked":
        return "locked"
    if parsed.name in {**ranges.EFFECTS, **ranges.BENCH}:
        return "effect"
    return "fault" if parsed.name in ranges.FAULTS else parsed.name


def named(document: dict[str, Any]) -> list[Name]:
    """Return the effects and faults that a document names: kind and place."""
    return [(e["kind"], tuple(e["between"])) for e in document.get("effects", [])]


def hidden(trial: Trial) -> list[Name]:
    """Return the effects and faults that were hidden: kind and place."""
    effects = [(e["kind"], tuple(e["between"])) for e in trial.truth["effects"]]
    fault = trial.truth["fault"]
    return effects + ([(fault["kind"], (fault["channel"],))] if fault else [])


def same(found: Name, wanted: Name) -> bool:
    """Whether the same kind was named at the same place (an attached mode has only one end)."""
    if found[0] not in {wanted[0], *ranges.ALSO_CALLED.get(wanted[0], ())}:
        return False
    if wanted[0] in ranges.FAULTS or wanted[0] == "attached_mode":
        return wanted[1][-1] in found[1] or not found[1]
    return set(found[1]) == set(wanted[1])


def same_set(found: list[Name], wanted: list[Name]) -> bool:
    """Whether all that is wanted was found, and nothing else."""
    return len(found) == len(wanted) and all(any(same(f, w) for f in found) for w in wanted)


def first_named(trial: Trial) -> str:
    """Return what stands in the verdict: kinds, or the verdict itself."""
    if trial.problem:
        return "failed"
    if trial.document.get("locked") and not named(trial.document):
        return "locked"
    found = named(trial.document)
    return " + ".join(kind for kind, _ in found) if found else str(trial.document["verdict"])


def locked_said(trial: Trial) -> bool:
    """Whether the document says that the joint is locked, as the module states the rule."""
    effect = trial.truth["effects"][0]
    numbers = effect["parameters"]
    holds = numbers.get("breakaway_force", numbers["sliding_force"])
    joint = set(effect["between"])
    bounds = [
        entry["holds_at_least"]["value"]
        for entry in trial.document.get("locked") or []
        if set(entry["between"]) == joint
    ]
    if not any(0.0 < bound <= LOCKED_TOLERANCE * holds for bound in bounds):
        return False
    if not named(trial.document):
        return trial.document["verdict"] in {"nothing missing", "cannot tell"}
    return all(_unbounded(e, joint) for e in trial.document["effects"])


def _unbounded(effect: dict[str, Any], joint: set[str]) -> bool:
    """Whether a named effect is dry friction at the joint, with no upper bound on its force."""
    forces = [p for name, p in effect["parameters"].items() if name.endswith("_force")]
    friction = effect["kind"] in FAMILY_OF_FRICTION and set(effect["between"]) == joint
    return friction and all(p.get("high") is None for p in forces)


def exact(trial: Trial) -> bool:
    """Whether verdict, kinds and joints are exactly right."""
    if trial.problem:
        return False
    found, wanted, verdict = named(trial.document), hidden(trial), trial.document["verdict"]
    kind = family(trial.kind)
    if kind == "locked":
        return locked_said(trial)
    if kind == "none":
        return not found and verdict == "nothing missing"
    if kind == "unexercised":
        return not found and verdict in {"nothing missing", "cannot tell"}
    if kind == "outside":
        return not found and verdict == "outside library"
    right = {"measurement fault"} if kind == "fault" else {"effect found"}
    if trial.truth["fault"] and trial.truth["effects"]:
        right = {"measurement fault", "effect found"}
    return verdict in right and (same_set(found, wanted) or _as_a_set(trial, found, wanted))


def _as_a_set(trial: Trial, found: list[Name], wanted: list[Name]) -> bool:
    """Whether several effects were named that are the hidden one from another origin."""
    kinds = ranges.ALSO_SETS.get(classes.parse(trial.kind).name, ())
    place = wanted[0][1] if wanted else ()
    return bool(kinds) and same_set(found, [(kind, place) for kind in kinds])


def number_of_ties(trial: Trial) -> int:
    """Return how many kinds are declared to be as good as the one named."""
    return len(trial.document.get("indistinguishable", []))


def tied(trial: Trial) -> bool:
    """Whether the trial is exact, or the truth is among what it cannot tell apart.

    Ties of a pair are written `A + B`; the joint of a tie is that of what was named.
    """
    if exact(trial) or trial.problem:
        return exact(trial)
    if family(trial.kind) not in {"effect", "fault"}:
        return False
    (kind, place), found = hidden(trial)[0], named(trial.document)
    ties = trial.document.get("indistinguishable", [])
    wanted = {kind, *ranges.ALSO_CALLED.get(kind, ())}
    return (
        len(found) == 1
        and bool(wanted & set(ties))
        and same((kind, found[0][1]), (kind, place))
    )
