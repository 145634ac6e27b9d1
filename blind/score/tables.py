"""What was said for what was hidden: classes, verdicts, names, misses."""

from collections import Counter, defaultdict
from collections.abc import Sequence

import numpy as np

from blind.judging import exact, family, first_named, hidden, named, tied
from blind.score import coverage
from blind.trial import Trial


def by_class(trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    """Return the trials of every class, in the order in which they came."""
    groups: dict[str, list[Trial]] = defaultdict(list)
    for trial in trials:
        groups[trial.kind].append(trial)
    return groups


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def classes(trials: Sequence[Trial]) -> str:
    """Return one line a class: rates, parameters, errors, seconds."""
    lines = [
        f"{'class':34s} {'n':>3s} {'exact':>6s} {'ties':>6s} {'error':>7s} {'inside':>7s}"
        f" {'before':>7s} {'after':>7s} {'floor':>7s} {'cpu s':>6s}"
    ]
    for kind, group in by_class(trials).items():
        found = [i for trial in group for i in coverage.intervals(trial) if i.exercised]
        offs = [i.error for i in found if i.error is not None]
        said = [t.document["errors"] for t in group if not t.problem and named(t.document)]
        steps = [
            _median([e["held_out"]["before"] for e in said]),
            _median([e["held_out"]["after"] for e in said]),
            _median([e["noise_floor"] for e in said if e["noise_floor"] is not None]),
        ]
        inside = f"{sum(i.holds for i in found)}/{len(found)}"
        lines.append(
            f"{kind:34s} {len(group):3d} {np.mean([exact(t) for t in group]):6.0%}"
            f" {np.mean([tied(t) for t in group]):6.0%} {_median(offs):7.2%} {inside:>7s}"
            f" {steps[0]:7.4f} {steps[1]:7.4f} {steps[2]:7.4f}"
            f" {_median([t.cpu_seconds for t in group]):6.1f}"
        )
    return "\n".join(lines)


def verdicts(trials: Sequence[Trial]) -> dict[str, dict[str, int]]:
    """Return how often each verdict was given, for each family of classes."""
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for trial in trials:
        said = "failed" if trial.problem else trial.document["verdict"]
        table[family(trial.kind)][said] += 1
    return {name: dict(counts.most_common()) for name, counts in table.items()}


def confusion(trials: Sequence[Trial]) -> str:
    """Return the verdicts of each family, and what was named for what was hidden."""
    lines = ["hidden      verdicts"]
    for name, counts in verdicts(trials).items():
        lines.append(f"{name:11s} " + ", ".join(f"{said} {n}" for said, n in counts.items()))
    lines += ["", f"{'hidden':34s} named"]
    for kind, group in by_class(trials).items():
        counts = Counter(first_named(trial) for trial in group)
        found = ", ".join(f"{name} {n}" for name, n in counts.most_common())
        lines.append(f"{kind:34s} {found}")
    return "\n".join(lines)


def misses(trials: Sequence[Trial]) -> str:
    """Return what was hidden and what was said, for every miss and every tie."""
    lines = []
    for trial in trials:
        if exact(trial):
            continue
        wanted = ", ".join(kind for kind, _ in hidden(trial)) or "nothing"
        found = ", ".join(f"{kind} at {'-'.join(at)}" for kind, at in named(trial.document))
        ties = ", ".join(trial.document.get("indistinguishable", [])) or "-"
        said = trial.problem or trial.document["verdict"]
        lines.append(
            f"{'tie ' if tied(trial) else 'MISS'} {trial.kind} seed {trial.seed}"
            f" ({trial.snr_db:.0f} dB): hidden {wanted}; said {said}: {found or '-'};"
            f" ties {ties}"
        )
    return "misses and ties\n" + "\n".join(lines) if lines else ""


def against(trials: Sequence[Trial], others: Sequence[Trial]) -> str:
    """Return, class by class and on the same draws, which of two sets is right more often."""
    both = {(t.kind, t.seed) for t in trials} & {(t.kind, t.seed) for t in others}
    mine, theirs = (
        by_class([t for t in group if (t.kind, t.seed) in both]) for group in (trials, others)
    )
    lines = [f"{'class':34s} {'n':>3s} {'these':>12s} {'the others':>12s}  exact/tied"]
    for kind, group in mine.items():
        a, b = _rights(group), _rights(theirs[kind])
        mark = "WORSE" if a < b else ("better" if a > b else "")
        lines.append(
            f"{kind:34s} {len(group):3d} {a[0]:5d} /{a[1]:5d} {b[0]:5d} /{b[1]:5d}  {mark}"
        )
    return "\n".join(lines)


def _rights(group: Sequence[Trial]) -> tuple[int, int]:
    return sum(exact(t) for t in group), sum(tied(t) for t in group)
