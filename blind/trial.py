"""One blind trial: a campaign is drawn, written, diagnosed; what came out, with the truth."""

import resource
import signal
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from blind import folder
from blind.campaign import Campaign
from blind.campaigns import draw

CANDIDATES_KEPT = 6
"""How many of the candidates that a diagnosis lists are kept in a record."""


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
    from shakerproc.model_files import read_model
    from shakerproc.testlog import read_testlog

    found: dict[str, Any] = run(read_model(model), read_testlog(log), seed=seed).as_json()
    return found


Diagnose = Callable[[Path, Path, int], dict[str, Any]]
"""A function of the paths of log and model and of a seed, that returns a document."""


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
