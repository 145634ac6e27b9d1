"""The whole loop on one set: diagnose, add, compare, the published protocol, and once more."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.real import steps
from benchmarks.real.protocols import published_errors
from shakerproc.errors import ShakerprocError
from shakerproc.model_files import read_model


@dataclass
class Round:
    """One turn of the loop: what was named, and what the model is worth with it.

    Attributes
    ----------
    diagnosis : dict
        JSON of the diagnosis; empty where it failed.
    seconds : float
        Processor time of the diagnosis [s].
    failure : str
        Why the diagnosis, or what followed, failed.
    error_before, error_after : float or None
        Free-run error of `compare` before and after the effects were added [-].
    published : dict of str to float
        Error of the published protocol with the effects added, by test [SI].
    """

    diagnosis: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
    failure: str = ""
    error_before: float | None = None
    error_after: float | None = None
    published: dict[str, float] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        """The verdict, or that there is none."""
        return str(self.diagnosis.get("verdict", "failed"))

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Effects that were named."""
        return list(self.diagnosis.get("effects", []))


def judge(folder: Path, *, rounds: int, limit: int = steps.LIMIT_S) -> list[Round]:
    """Return the turns of the loop on a set, until nothing more is named.

    A set with a log `modal.yaml` has a model of the modes that are found by it, in `modal`.
    """
    found, model = [], folder / "model.yaml"
    if (folder / "modal.yaml").exists() and (
        step := steps.modal(folder / "modal.yaml")
    ).failure:
        return [Round(seconds=step.seconds, failure=step.failure)]
    for number in range(1, rounds + 1):
        turn, new = _turn(folder, model, number, limit)
        found.append(turn)
        if turn.diagnosis.get("further"):
            found.append(_asked_next(folder, new or model, turn.diagnosis["further"]))
        if new is None:
            break
        model = new
    return found


def _asked_next(folder: Path, model: Path, kinds: list[str]) -> Round:
    """Return what the model is worth with what a diagnosis asked to add next."""
    log, turn = folder / "testlog.yaml", Round({"verdict": "asked next"})
    for i, kind in enumerate(kinds):
        new = folder / f"model_next{'abc'[i]}.yaml"
        step = steps.add({"kind": kind, "between": []}, model, log, new)
        turn.seconds += step.seconds
        turn.diagnosis["effects"] = [*turn.effects, {"kind": kind, "between": []}]
        if step.failure:
            turn.failure = step.failure
            return turn
        model = new
    _worth(turn, folder, model)
    return turn


def _worth(turn: Round, folder: Path, model: Path) -> None:
    """Write what a model is worth, on the tests and in the published protocol."""
    turn.error_after = _error(model, folder / "testlog.yaml")
    if (folder / "published.yaml").exists():
        try:
            turn.published = published_errors(read_model(model), folder)
        except (ShakerprocError, ValueError) as error:
            turn.failure = str(error)


def _turn(folder: Path, model: Path, number: int, limit: int) -> tuple[Round, Path | None]:
    """Return one turn, and the model that it leaves; None where the loop ends."""
    log = folder / "testlog.yaml"
    step = steps.diagnose(model, log, limit=limit)
    turn = Round(step.document, step.seconds, step.failure)
    turn.error_before = _error(model, log)
    if turn.verdict != "effect found":
        return turn, None
    joined = [
        effect for effect in turn.effects if effect.get("between")
    ]  # no fault of a channel
    for i, effect in enumerate(joined):
        new = folder / f"model_{number}{'abc'[i]}.yaml"
        added = steps.add(effect, model, log, new)
        if added.failure:
            turn.failure = added.failure
            return turn, None
        model = new
    _worth(turn, folder, model)
    return turn, model


def _error(model: Path, log: Path) -> float | None:
    document = steps.compare(model, log).document
    held_out = document.get("error_held_out")
    return document.get("error") if held_out is None else held_out


def lines_of(name: str, found: list[Round]) -> list[str]:
    """Return what is printed of a set, a line for each turn of the loop."""
    return [_line(name if i == 0 else "  then", turn) for i, turn in enumerate(found)]


def _line(name: str, turn: Round) -> str:
    parts = [f"{name:16s} {turn.verdict:17s} {_confidence(turn):5s}"]
    parts += [_effect(effect) for effect in turn.effects]
    errors = turn.diagnosis.get("errors", {}).get("held_out", {})
    parts.append(f"held out {_number(errors.get('before'))} -> {_number(errors.get('after'))}")
    parts.append(f"compare {_number(turn.error_before)} -> {_number(turn.error_after)}")
    if turn.published:
        scores = (f"{test} {error:.4g}" for test, error in turn.published.items())
        parts.append("published " + ", ".join(scores))
    parts.append(f"{turn.seconds:.0f} s")
    if turn.failure:
        parts.append(turn.failure)
    return "; ".join(parts)


def _confidence(turn: Round) -> str:
    value = turn.diagnosis.get("confidence")
    return "" if value is None else f"{value:.2f}"


def _effect(effect: dict[str, Any]) -> str:
    numbers = ", ".join(
        f"{name} {_number(one['value'])} ({_number(one['low'])} to {_number(one['high'])})"
        for name, one in effect.get("parameters", {}).items()
    )
    joint = "-".join(effect["between"]) if effect.get("between") else effect.get("channel", "")
    return f"{effect['kind']} {joint}: {numbers}"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def as_json(found: dict[str, list[Round]]) -> dict[str, Any]:
    """Return every turn of every set."""
    return {
        "schema": "shakerproc-real/1",
        "sets": {name: [asdict(turn) for turn in turns] for name, turns in found.items()},
    }
