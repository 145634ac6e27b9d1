"""One blind trial: a campaign is drawn, written, diagnosed; trials on disk, one a line."""

import json
import resource
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from blind import folder
from blind.campaign import Campaign
from blind.campaigns import draw

CANDIDATES_KEPT = 6
"""How many of the candidates that a diagnosis lists are kept in a record."""

Diagnose = Callable[[Path, Path, int], dict[str, Any]]
"""A function of the paths of log and model and of a seed, that returns a document."""


@dataclass(frozen=True)
class Trial:
    """What came out of one campaign; `problem` is why there is no document.

    `retest` is what was said before a proposed test was added, and whether that settled it.
    """

    seed: int
    kind: str
    snr_db: float
    noise_floor: float
    truth: dict[str, Any]
    document: dict[str, Any]
    seconds: float
    cpu_seconds: float
    problem: str = ""
    retest: dict[str, Any] | None = None

    def as_json(self) -> dict[str, Any]:
        """Return all of it, without most of the candidates."""
        out = asdict(self)
        tried = self.document.get("candidates")
        if tried:
            out["document"] = self.document | {"candidates": tried[:CANDIDATES_KEPT]}
        return out


def from_json(words: dict[str, Any]) -> Trial:
    """Return the trial of a record."""
    known = {field.name for field in fields(Trial)}
    return Trial(**{name: value for name, value in words.items() if name in known})


def diagnose(log: Path, model: Path, seed: int) -> dict[str, Any]:
    """Return the document of a diagnosis."""
    from shakerproc.diagnosis import diagnose as run
    from shakerproc.diagnosis.progress import TIME_LIMIT_S, Progress
    from shakerproc.model_files import read_model
    from shakerproc.testlog import read_testlog

    limited = Progress(limit_s=TIME_LIMIT_S)
    found: dict[str, Any] = run(
        read_model(model), read_testlog(log), seed=seed, progress=limited
    ).as_json()
    return found


def processor_seconds() -> float:
    """Return what this process and its children have computed for [s]."""
    own, children = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def attempt(seed: int, kind: str, judge: Diagnose = diagnose, *, limit: float = 0.0) -> Trial:
    """Return the trial of one seed and class; a failed diagnosis is a miss with its reason."""
    return diagnosed(draw(seed, kind), judge, limit=limit)


def diagnosed(campaign: Campaign, judge: Diagnose, *, limit: float = 0.0) -> Trial:
    """Return the trial of a campaign; the system ends a process whose diagnosis takes longer.

    `limit` is in seconds of processor time, 0 for none.
    """
    document: dict[str, Any] = {}
    problem = ""
    with tempfile.TemporaryDirectory(prefix="blind-") as place:
        log, model = folder.write(campaign, Path(place))
        start, before = time.perf_counter(), processor_seconds()
        try:
            signal.setitimer(signal.ITIMER_PROF, limit)
            document = judge(log, model, campaign.seed)
        except Exception as error:  # noqa: BLE001 - any failure is a miss, and is printed
            problem = f"{type(error).__name__}: {error}"
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        seconds, worked = time.perf_counter() - start, processor_seconds() - before
    return Trial(
        campaign.seed, campaign.kind, campaign.details["snr_db"], campaign.noise_floor,
        campaign.truth, document, seconds, worked, problem,
    )  # fmt: skip


def without_answer(seed: int, kind: str, problem: str, seconds: float) -> Trial:
    """Return the trial of a diagnosis that was stopped or that died."""
    campaign = draw(seed, kind)
    return Trial(
        seed, kind, campaign.details["snr_db"], campaign.noise_floor, campaign.truth, {},
        seconds, seconds, problem,
    )  # fmt: skip


def read_trials(path: Path) -> list[Trial]:
    """Return the trials of a file; a last line that was cut off is left out."""
    if not path.exists():
        return []
    trials = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            trials.append(from_json(json.loads(line)))
        except json.JSONDecodeError:
            continue
    return trials


def append_trial(path: Path, trial: Trial) -> None:
    """Write one more line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = not path.exists() or path.read_bytes()[-1:] in {b"\n", b""}
    with path.open("a", encoding="utf-8") as stream:
        line = json.dumps(trial.as_json(), default=_plain)
        stream.write(("" if whole else "\n") + line + "\n")


def remaining_tasks(
    tasks: Sequence[tuple[int, str]], done: Sequence[Trial]
) -> list[tuple[int, str]]:
    """Return the tasks that no trial answers yet."""
    known = {(trial.seed, trial.kind) for trial in done}
    return [task for task in tasks if task not in known]


def _plain(value: Any) -> Any:
    """Return a number of numpy as one of Python.

    Raises
    ------
    TypeError
        If the value is none.
    """
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a record")
