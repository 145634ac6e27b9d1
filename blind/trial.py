"""One blind trial: a campaign is drawn, written, diagnosed, then compared with the truth."""

import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from blind import folder, ranges
from blind.campaigns import draw

Diagnose = Any
"""A function of the paths of log and model and of a seed, that returns a diagnosis document."""


@dataclass(frozen=True)
class Trial:
    """What came out of one campaign."""

    seed: int
    kind: str
    snr_db: float
    noise_floor: float
    truth: dict[str, Any]
    document: dict[str, Any]
    seconds: float
    cpu_seconds: float
    problem: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return all of it but the candidates that were tried."""
        out = asdict(self)
        out["document"] = {k: v for k, v in self.document.items() if k != "candidates"}
        return out


def diagnose(log: Path, model: Path, seed: int) -> dict[str, Any]:
    """Return the document of shakerproc's diagnosis."""
    from shakerproc.diagnose import diagnose as run
    from shakerproc.model_files import read_model
    from shakerproc.testlog import read_testlog

    found: dict[str, Any] = run(read_model(model), read_testlog(log), seed=seed).as_json()
    return found


def attempt(seed: int, kind: str, judge: Diagnose = diagnose) -> Trial:
    """Return the trial of one seed and class; a failed diagnosis is a miss with its reason."""
    campaign = draw(seed, kind)
    document: dict[str, Any] = {}
    problem = ""
    with tempfile.TemporaryDirectory(prefix="blind-") as place:
        log, model = folder.write(campaign, Path(place))
        start, cpu = time.perf_counter(), time.process_time()
        try:
            document = judge(log, model, seed)
        except Exception as error:  # noqa: BLE001 - any failure is a miss, and is printed
            problem = f"{type(error).__name__}: {error}"
        seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    return Trial(
        seed, kind, campaign.details["snr_db"], campaign.noise_floor, campaign.truth, document,
        seconds, cpu, problem,
    )  # fmt: skip


def family(kind: str) -> str:
    """Return what a class asks for: effect, none, unexercised, fault, outside or pair."""
    name = kind.partition(":")[2] if kind.startswith(("chain", "force")) else kind
    name = name.partition(":")[0]
    if name in ranges.EFFECTS:
        return "effect"
    return "fault" if name in ranges.FAULTS else name


def named(document: dict[str, Any]) -> list[tuple[str, tuple[str, ...]]]:
    """Return the effects and faults that a document names: kind and place."""
    return [(e["kind"], tuple(e["between"])) for e in document.get("effects", [])]


def hidden(trial: Trial) -> list[tuple[str, tuple[str, ...]]]:
    """Return the effects and faults that were hidden: kind and place."""
    effects = [(e["kind"], tuple(e["between"])) for e in trial.truth["effects"]]
    fault = trial.truth["fault"]
    return effects + ([(fault["kind"], (fault["channel"],))] if fault else [])


def same(found: tuple[str, tuple[str, ...]], wanted: tuple[str, tuple[str, ...]]) -> bool:
    """Whether the same kind was named at the same place (an attached mode has only one end)."""
    if found[0] != wanted[0]:
        return False
    if wanted[0] in ranges.FAULTS or wanted[0] == "attached_mode":
        return wanted[1][-1] in found[1] or not found[1]
    return set(found[1]) == set(wanted[1])


def first_named(trial: Trial) -> str:
    """Return what stands first in the verdict: an effect, a fault, or the verdict itself."""
    if trial.problem:
        return "failed"
    found = named(trial.document)
    return found[0][0] if found else trial.document["verdict"]


def hit(trial: Trial) -> bool:
    """Whether the trial got what its class asks for."""
    if trial.problem:
        return False
    found, wanted, kind = named(trial.document), hidden(trial), family(trial.kind)
    if kind == "none":
        return not found and trial.document["verdict"] in {"nothing missing", "cannot tell"}
    if kind == "unexercised":
        return not found and trial.document["verdict"] != "outside library"
    if kind == "outside":
        return trial.document["verdict"] == "outside library"
    if kind == "pair":
        return all(any(same(f, w) for f in found) for w in wanted)
    return bool(found) and same(found[0], wanted[0])


def tied(trial: Trial) -> bool:
    """Whether the trial is a hit, or names the truth among what it cannot tell apart."""
    if hit(trial) or trial.problem or family(trial.kind) not in {"effect", "fault"}:
        return hit(trial)
    wanted = hidden(trial)[0]
    found = named(trial.document)
    return bool(found) and wanted[0] in trial.document["indistinguishable"]
