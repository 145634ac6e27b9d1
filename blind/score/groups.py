"""Which trials a row of the score counts."""

from collections.abc import Callable, Sequence

from blind import classes
from blind.judging import family
from blind.trial import Trial

Choice = Callable[[Trial], bool]


def of(trials: Sequence[Trial], choice: Choice) -> list[Trial]:
    """Return the trials that a row counts."""
    return [trial for trial in trials if choice(trial)]


def plain(name: str) -> Choice:
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
    """Whether there are several masses, or a force drives."""
    return bool(classes.parse(trial.kind).form)


def friction_class(name: str) -> Choice:
    """Return what chooses one class of dry friction."""
    return lambda trial: trial.kind == name


def tested_again(trial: Trial) -> bool:
    """Whether a proposed test was carried out."""
    return trial.retest is not None
