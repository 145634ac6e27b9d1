"""The table of the issue: which trials each row counts, rates, exact bounds, goals."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from blind import classes
from blind.judging import exact, family, named, number_of_ties, tied
from blind.score.bounds import clopper_pearson
from blind.trial import Trial

Choice = Callable[[Trial], bool]

MEAN_TIES, MOST_TIES = 0.5, 3

ERROR_OVER_FLOOR = 1.1

PROCESSOR_MEDIAN, PROCESSOR_WORST = 8.0, 60.0
"""Goals of the issue: ties of a single effect, held-out error over floor, seconds."""


def trials_of(trials: Sequence[Trial], choice: Choice) -> list[Trial]:
    """Return the trials that a row counts."""
    return [trial for trial in trials if choice(trial)]


def without_nuisances(name: str) -> Choice:
    """Return what chooses a family without nuisances, chains, forces and friction regimes."""

    def choice(trial: Trial) -> bool:
        kind = classes.parse(trial.kind)
        return family(trial.kind) == name and not (kind.nuisances or kind.form or kind.regime)

    return choice


def with_all_nuisances(trial: Trial) -> bool:
    """Whether a single effect stands beside all nuisances."""
    return family(trial.kind) == "effect" and trial.kind.endswith("@all")


def with_one_nuisance(trial: Trial) -> bool:
    """Whether one nuisance is drawn."""
    return bool(classes.parse(trial.kind).nuisances) and not trial.kind.endswith("@all")


def nothing_with_nuisances(trial: Trial) -> bool:
    """Whether nothing is missing, beside all nuisances."""
    return trial.kind == "none@all"


def chained(trial: Trial) -> bool:
    """Whether there are several masses, or a force drives, in a long campaign."""
    form = classes.parse(trial.kind).form
    return bool(form) and form not in classes.BRIEF


def brief(trial: Trial) -> bool:
    """Whether it is a decay, a push or a few ground motions."""
    return classes.parse(trial.kind).form in classes.BRIEF


def friction_class(name: str) -> Choice:
    """Return what chooses one class of dry friction."""
    return lambda trial: trial.kind == name


def tested_again(trial: Trial) -> bool:
    """Whether a proposed test was carried out."""
    return trial.retest is not None


@dataclass(frozen=True)
class Row:
    """One line of the table: a share that was counted, with its goal."""

    says: str
    goal: float
    successes: int
    trials: int
    low: float
    high: float

    @property
    def rate(self) -> float:
        """Share of successes."""
        return self.successes / self.trials

    @property
    def met(self) -> bool:
        """Whether the goal lies inside the bounds or below them."""
        return self.goal <= self.high

    def as_json(self) -> dict[str, Any]:
        """Return the row with rate and verdict."""
        return asdict(self) | {"rate": self.rate, "met": self.met}


def settled(trial: Trial) -> bool:
    """Whether the proposed test settled what was open."""
    return bool(trial.retest and trial.retest["settled"])


TABLE: tuple[tuple[str, float, Choice, Choice], ...] = (
    ("single effect exact", 0.95, without_nuisances("effect"), exact),
    ("... or among its declared ties", 0.99, without_nuisances("effect"), tied),
    ("single effect, all nuisances", 0.90, with_all_nuisances, tied),
    ("one nuisance each", 0.90, with_one_nuisance, tied),
    ("nothing missing, all nuisances", 0.90, nothing_with_nuisances, exact),
    ("two effects, both named", 0.85, without_nuisances("pair"), exact),
    ("nothing missing", 0.99, without_nuisances("none"), exact),
    ("unexercised", 0.99, without_nuisances("unexercised"), exact),
    ("measurement fault named", 0.98, without_nuisances("fault"), exact),
    ("outside the library refused", 0.90, without_nuisances("outside"), exact),
    ("the proposed next test settles it", 0.80, tested_again, settled),
    ("chains and forces, exact or tied", 0.95, chained, tied),
    ("brief campaigns, exact or tied", 0.90, brief, tied),
    *(
        (f"{name.replace(':', ', ')}", 0.90, friction_class(name), tied)
        for name in classes.friction()
    ),
)
"""What is asked, the goal, which trials count, and what is a success."""


def all_rows(trials: Sequence[Trial]) -> list[Row]:
    """Return every row that has trials."""
    out = []
    first = [trial for trial in trials if trial.retest is None]
    for says, goal, choice, judge in TABLE:
        group = trials_of(trials if judge is settled else first, choice)
        if group:
            successes = sum(judge(trial) for trial in group)
            bounds = clopper_pearson(successes, len(group))
            out.append(Row(says, goal, successes, len(group), *bounds))
    return out


def ties(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return the average and the largest number of declared ties of single effects."""
    group = trials_of(trials, without_nuisances("effect"))
    counts = [number_of_ties(trial) for trial in group if not trial.problem]
    if not counts:
        return {}
    mean, most = float(np.mean(counts)), max(counts)
    return {"mean": mean, "most": most, "met": mean <= MEAN_TIES and most <= MOST_TIES}


def errors(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return the held-out error after over the floor, of all documents that name an effect."""
    ratios, worse, floors = [], 0, []
    for trial in trials:
        if trial.problem or not named(trial.document):
            continue
        said = trial.document["errors"]
        worse += said["held_out"]["after"] > said["held_out"]["before"]
        if said["noise_floor"] is not None and said["noise_floor"] > 0.0:
            ratios.append(said["held_out"]["after"] / said["noise_floor"])
            floors.append(said["noise_floor"] / trial.noise_floor)
    if not ratios:
        return {}
    median = float(np.median(ratios))
    return {
        "over_floor_median": median,
        "met": median <= ERROR_OVER_FLOOR,
        "above_before": worse,
        "floor_over_noise_of_the_sensors_median": float(np.median(floors)),
    }


def seconds(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return median and worst of the processor time [s], and the class of the worst."""
    if not trials:
        return {}
    slowest = max(trials, key=lambda trial: trial.cpu_seconds)
    median = float(np.median([trial.cpu_seconds for trial in trials]))
    worst = slowest.cpu_seconds
    return {
        "median": median,
        "worst": worst,
        "slowest": f"{slowest.kind} {slowest.seed}",
        "met": median <= PROCESSOR_MEDIAN and worst <= PROCESSOR_WORST,
    }


def text(trials: Sequence[Trial]) -> str:
    """Return the table as text."""
    lines = [f"{'asked':36s} {'right':>9s} {'rate':>6s} {'95 % bounds':>13s} {'goal':>5s}"]
    for row in all_rows(trials):
        lines.append(
            f"{row.says:36s} {row.successes:4d}/{row.trials:<4d} {row.rate:6.1%}"
            f" {row.low:6.1%}-{row.high:6.1%} {row.goal:5.0%} {_mark(met=row.met)}"
        )
    first = [trial for trial in trials if trial.retest is None]
    if found := ties(first):
        said = f"{found['mean']:.2f}, at most {found['most']}"
        lines.append(f"{'declared ties of a single effect':36s} {said} {_goal(found)}")
    if found := errors(first):
        said = (
            f"{found['over_floor_median']:.2f}; above the error before {found['above_before']}"
        )
        lines.append(f"{'held-out error over floor, median':36s} {said} {_goal(found)}")
    if found := seconds(first):
        said = f"{found['median']:.1f} / {found['worst']:.0f} ({found['slowest']})"
        lines.append(f"{'processor seconds, median / worst':36s} {said} {_goal(found)}")
    return "\n".join(lines)


def _mark(*, met: bool) -> str:
    return "met" if met else "NOT MET"


def _goal(found: dict[str, Any]) -> str:
    return _mark(met=found["met"])
