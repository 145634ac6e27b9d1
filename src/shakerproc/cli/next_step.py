"""Next step after a command, with the words to type."""

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from shakerproc.cli import output

if TYPE_CHECKING:
    from shakerproc.diagnosis.result import Diagnosis


def say(text: str, json: str | None, *words: object) -> None:
    """Say on stderr what comes next, and the command; nothing where JSON goes to stdout."""
    if json != output.STDOUT:
        typed = shlex.join(["shakerproc", *map(str, words)]) if words else ""
        output.message(f"next: {': '.join(filter(None, (text, typed)))}")


def after_processing(recording: Path, log: Path | None, json: str | None) -> None:
    """Say what comes after one recording: the whole log, or the beginning of one."""
    if log is None:
        folder = recording.parent
        say("begin a log of these recordings", json, "init", "campaign", "--recordings", folder)
    else:
        say("process every test of the log", json, "batch", log)


def after_batch(log: Path, json: str | None) -> None:
    """Say what comes after a batch: comparing the model beside the log, where there is one."""
    model = _model_beside(log)
    if model is None:
        text = "write a model, as `shakerproc init FOLDER` shows, and compare it"
        say(text, json, "compare", "MODEL", log)
    else:
        say("compare the model with the tests", json, "compare", model, log)


def after_comparing(model: Path, log: Path, json: str | None, *, explained: bool) -> None:
    """Say what comes after a comparison: looking for what the model lacks, or nothing."""
    if explained:
        say("nothing to add, the model explains every test", json)
    else:
        say("ask which effect is missing", json, "diagnose", model, log)


def after_diagnosis(found: "Diagnosis", model: Path, log: Path, json: str | None) -> None:
    """Say what comes after a diagnosis: adding what was found, or what stands in the way."""
    if found.verdict == "effect found":
        effect = max(found.effects, key=lambda e: len(e.between))  # faults have one place
        new = model.with_name(f"{model.stem}-with-{effect.kind}.yaml")
        places = ("--between", ",".join(effect.between))
        add = ("add", effect.kind, model, log, *places, "-o", new)
        say("add it to the model", json, *add)
    elif found.verdict == "measurement fault":
        text = "repair the sensor, or declare the fault in the log; then"
        say(text, json, "diagnose", model, log)
    elif found.verdict == "outside library":
        new = model.with_name(f"{model.stem}-with-table.yaml")
        say("write the missing force into a model, without a name", json,
            "add", "table", model, log, "-o", new)  # fmt: skip
    elif found.verdict == "nothing missing":
        say("nothing to add", json)
    else:
        text = "run the next test above and enter it in the log" if found.next_test else (
            "settle what is said above"
        )  # fmt: skip
        say(f"{text}; then", json, "diagnose", model, log)


def _model_beside(log: Path) -> Path | None:
    """Return the model in the folder of a log: model.yaml before others, by name."""
    files: Sequence[Path] = sorted(
        (*log.parent.glob("*.yaml"), *log.parent.glob("*.yml")),
        key=lambda path: (path.stem != "model", path.name),
    )
    return next((path for path in files if _is_model(path)), None)


def _is_model(path: Path) -> bool:
    """Return whether a file begins as a model does: its first key is ``model``."""
    try:
        with path.open("rb") as file:
            beginning = file.read(4096).decode("utf-8", "replace")
    except OSError:
        return False
    return bool(re.match(r"(\s*(#.*)?\n|---\n)*model\s*:", beginning))
