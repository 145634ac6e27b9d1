"""What a set of blind trials adds up to, as numbers and as text."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from blind.judging import exact as hit
from blind.judging import family, first_named, hidden, named, same, tied
from blind.trial import Trial

GOALS = {
    "effect": 0.90, "ties": 0.97, "none": 0.99, "unexercised": 0.95, "fault": 0.97,
    "outside": 0.85, "pair": 0.75,
}  # fmt: skip
SAYS = {
    "effect": "hidden effect named first, exactly",
    "ties": "... or among the declared ties",
    "none": "nothing missing, and none named",
    "unexercised": "unexercised, and not named",
    "fault": "measurement fault named",
    "outside": "outside the library, and refused",
    "pair": "both of two effects named",
}


def share(trials: Iterable[Trial], judge: Callable[[Trial], bool]) -> float:
    """Return the share of trials that pass; NaN of none."""
    verdicts = [judge(trial) for trial in trials]
    return float(np.mean(verdicts)) if verdicts else float("nan")


def of_family(trials: Sequence[Trial], name: str) -> list[Trial]:
    """Return the trials of a family."""
    return [trial for trial in trials if family(trial.kind) == name]


def main_parameter(trial: Trial) -> tuple[float, bool] | None:
    """Return relative error and coverage of the main parameter; None where it was not found."""
    if family(trial.kind) != "effect" or not hit(trial):
        return None
    effect = trial.truth["effects"][0]
    estimate = trial.document["effects"][0]["parameters"].get(effect["main"])
    if estimate is None or not isinstance(estimate["value"], int | float):
        return None
    truth = effect["parameters"][effect["main"]]
    covered = estimate["low"] is not None and estimate["low"] <= truth <= estimate["high"]
    return abs(estimate["value"] / truth - 1.0), bool(covered)


def ladder(trial: Trial) -> tuple[float, float, float] | None:
    """Return held-out error before and after, and the noise floor."""
    if trial.problem or not named(trial.document):
        return None
    errors = trial.document["errors"]
    return errors["held_out"]["before"], errors["held_out"]["after"], errors["noise_floor"]


def summary(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return every figure of the score."""
    goals = {name: share(of_family(trials, name), hit) for name in GOALS if name != "ties"} | {
        "ties": share(of_family(trials, "effect"), tied)
    }
    parameters = [p for trial in trials if (p := main_parameter(trial))]
    ladders = [step for trial in trials if (step := ladder(trial))]
    return {
        "trials": len(trials),
        "goals": {name: goals[name] for name in GOALS},
        "main_parameter_error_median": _median([error for error, _ in parameters]),
        "main_parameter_coverage": _mean([covered for _, covered in parameters]),
        "held_out_after_over_floor_median": _median([a / f for _, a, f in ladders if f > 0.0]),
        "held_out_above_before": int(sum(a > b for b, a, _ in ladders)),
        "seconds_median": _median([trial.seconds for trial in trials]),
        "cpu_seconds_median": _median([trial.cpu_seconds for trial in trials]),
        "seconds_max": float(max((trial.seconds for trial in trials), default=float("nan"))),
        "failed": [f"{t.kind} {t.seed}: {t.problem}" for t in trials if t.problem],
    }


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def report(trials: Sequence[Trial]) -> str:
    """Return the score as text."""
    parts = [_goals(trials), _classes(trials), _confusion(trials), _misses(trials)]
    return "\n\n".join(part for part in parts if part)


def _goals(trials: Sequence[Trial]) -> str:
    figures = summary(trials)
    lines = [f"{'goal':42s} {'reached':>8s} {'wanted':>7s}"]
    for name, goal in GOALS.items():
        reached = figures["goals"][name]
        count = len(of_family(trials, "effect" if name == "ties" else name))
        if count:
            lines.append(f"{SAYS[name]:42s} {reached:8.1%} {goal:7.0%}  of {count}")
    above = figures["held_out_above_before"]
    lines += [
        f"{'main parameter, median error':42s} "
        f"{figures['main_parameter_error_median']:8.2%} {0.03:7.0%}",
        f"{'main parameter inside its 95 % interval':42s} "
        f"{figures['main_parameter_coverage']:8.1%}  90-99%",
        f"{'held-out error after / noise floor, median':42s} "
        f"{figures['held_out_after_over_floor_median']:8.2f} {1.5:7.1f}",
        f"{'held-out error above the one before':42s} {above:8d} {0:7d}",
        f"{'seconds a campaign, median':42s} {figures['seconds_median']:8.1f} {60:7d}",
        f"{'... of which the processors worked':42s} {figures['cpu_seconds_median']:8.1f}",
    ]
    return "\n".join(lines)


def _classes(trials: Sequence[Trial]) -> str:
    """Return one line a class: hits, ties, parameter error, coverage, ladder, seconds."""
    groups: dict[str, list[Trial]] = defaultdict(list)
    for trial in trials:
        groups[trial.kind].append(trial)
    lines = [
        f"{'class':24s} {'n':>3s} {'exact':>6s} {'ties':>6s} {'error':>7s} {'inside':>6s}"
        f" {'before':>7s} {'after':>7s} {'floor':>7s} {'s':>5s}"
    ]
    for kind, group in groups.items():
        found = [p for trial in group if (p := main_parameter(trial))]
        steps = [step for trial in group if (step := ladder(trial))]
        before, after, floor = (_median([s[i] for s in steps]) for i in range(3))
        lines.append(
            f"{kind:24s} {len(group):3d} {share(group, hit):6.0%} {share(group, tied):6.0%}"
            f" {_median([e for e, _ in found]):7.2%} {_mean([c for _, c in found]):6.0%}"
            f" {before:7.4f} {after:7.4f} {floor:7.4f}"
            f" {_median([t.seconds for t in group]):5.1f}"
        )
    return "\n".join(lines)


def _confusion(trials: Sequence[Trial]) -> str:
    """Return what was named first for what was hidden, without the empty columns."""
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for trial in trials:
        table[trial.kind][first_named(trial)] += 1
    lines = ["hidden                   named first"]
    for kind, counts in table.items():
        found = ", ".join(f"{name} {n}" for name, n in counts.most_common())
        lines.append(f"{kind:24s} {found}")
    return "\n".join(lines)


def _misses(trials: Sequence[Trial]) -> str:
    """Return what was hidden and what was said, for every miss."""
    lines = []
    for trial in trials:
        if hit(trial):
            continue
        wanted = ", ".join(kind for kind, _ in hidden(trial)) or "nothing"
        found = ", ".join(kind for kind, _ in named(trial.document)) or "-"
        ties = ", ".join(trial.document.get("indistinguishable", [])) or "-"
        said = trial.problem or trial.document["verdict"]
        lines.append(
            f"{trial.kind} seed {trial.seed} ({trial.snr_db:.0f} dB): hidden {wanted};"
            f" said {said}: {found}; ties {ties}"
        )
    return "misses\n" + "\n".join(lines) if lines else ""


def misplaced(trial: Trial) -> bool:
    """Whether the right kind was named first, at the wrong place."""
    found, wanted = named(trial.document), hidden(trial)
    return bool(
        found and wanted and found[0][0] == wanted[0][0] and not same(found[0], wanted[0])
    )
