"""Whether 95 % intervals hold the truth, for every parameter of what was rightly named.

The truth's parameters have the names of the program's. Differences of convention are settled
here: a force law of a power is given at its own reference displacement, a drift at its own
reference time, and an effect named from the second end to the first has its odd parts turned.
A word has no interval; one with a missing bound (not exercised) is counted apart. Where the
gains of the channels are not off, the bounds are those of the tests alone: what calibration
leaves open is not drawn there, and would hide bounds that are too narrow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind import classes
from blind.judging import exact, family
from blind.score.bounds import clopper_pearson
from blind.trial import Trial

LOW_GOAL, HIGH_GOAL = 0.93, 0.97
ROUNDING = 1e-9
"""What units and files may round off, as a share of the truth [-]."""


@dataclass(frozen=True)
class Interval:
    """A parameter with its truth."""

    kind: str
    name: str
    truth: float
    value: float | None
    low: float | None
    high: float | None

    @property
    def exercised(self) -> bool:
        """Whether there is an interval."""
        return self.low is not None and self.high is not None

    @property
    def holds(self) -> bool:
        """Whether the bounds that there are hold the truth."""
        rounding = ROUNDING * abs(self.truth)
        above = self.low is None or self.low - rounding <= self.truth
        return above and (self.high is None or self.truth <= self.high + rounding)

    @property
    def error(self) -> float | None:
        """Relative error of the estimate [-]."""
        if self.value is None or self.truth == 0.0:
            return None
        return abs(self.value / self.truth - 1.0)


def intervals(trial: Trial) -> list[Interval]:
    """Return the intervals of a trial that is exactly right; none of any other."""
    perfect = "gain_error" not in classes.parse(trial.kind).nuisances
    if not exact(trial) or family(trial.kind) not in {"effect", "pair", "fault"}:
        return []
    out = []
    for effect in trial.truth["effects"]:
        said = [e for e in trial.document["effects"] if _kind_of(e, effect)]
        if said:
            one = by_tests_alone(said[0]) if perfect else said[0]
            out += _compared(effect["kind"], _truth_as_said(effect, one), one)
    if trial.truth["fault"]:
        fault = trial.truth["fault"]
        numbers = {k: v for k, v in fault.items() if k not in {"kind", "channel"}}
        said = [e for e in trial.document["effects"] if e["kind"] == fault["kind"]]
        out += _compared(fault["kind"], numbers, said[0])
    return out


def by_tests_alone(said: dict[str, Any]) -> dict[str, Any]:
    """Return an effect of a document whose bounds hold what the tests leave open alone."""
    return said | {"parameters": {k: _narrowed(v) for k, v in said["parameters"].items()}}


def _narrowed(number: dict[str, Any]) -> dict[str, Any]:
    share, value = number.get("by_tests"), number.get("value")
    if share is None or number["low"] is None or number["high"] is None:
        return number
    if value > 0.0:
        return number | {"low": value * np.exp(-share), "high": value * np.exp(share)}
    return number | {"low": value * (1.0 + share), "high": value * (1.0 - share)}


def _kind_of(said: dict[str, Any], effect: dict[str, Any]) -> bool:
    return bool(said["kind"] == effect["kind"])


def _compared(kind: str, truth: dict[str, float], said: dict[str, Any]) -> list[Interval]:
    out = []
    for name, value in truth.items():
        found = _estimate(said["parameters"], name)
        if found is None or isinstance(found.get("value"), str) or isinstance(value, str):
            continue
        out.append(Interval(kind, name, float(value), found.get("value"), found.get("low"),
                            found.get("high")))  # fmt: skip
    return out


def _estimate(parameters: dict[str, Any], name: str) -> dict[str, Any] | None:
    """Return an estimate by its name, or by the end of it (elements in series)."""
    if name in parameters:
        found: dict[str, Any] = parameters[name]
        return found
    ends = [p for key, p in parameters.items() if key.endswith((f".{name}", f" {name}"))]
    return ends[0] if len(ends) == 1 else None


def _truth_as_said(effect: dict[str, Any], said: dict[str, Any]) -> dict[str, float]:
    """Return the truth in the conventions of the document."""
    numbers, place = dict(effect["parameters"]), said["parameters"]
    if effect["kind"] == "power_law" and "reference_displacement" in place:
        reference = place["reference_displacement"]["value"]
        share = reference / numbers.pop("reference_displacement")
        numbers["force"] *= share ** numbers["exponent"]
    if effect["kind"] == "stiffness_drift":
        at = place.get("reference", {}).get("value") or 0.0
        rate, zero = numbers["rate"], numbers.pop("reference")
        numbers["rate"] = rate / (1.0 + rate * (at - zero))
    if list(said["between"]) == list(effect["between"])[::-1]:
        numbers = _turned(effect["kind"], numbers)
    return numbers


def _turned(kind: str, numbers: dict[str, float]) -> dict[str, float]:
    """Return the numbers of an effect seen from its other end."""
    odd = {"quadratic_stiffness": "coefficient", "constant_force": "force"}
    if kind in odd:
        return numbers | {odd[kind]: -numbers[odd[kind]]}
    if kind == "offset_gap":
        up, down = numbers["clearance_positive"], numbers["clearance_negative"]
        return numbers | {"clearance_positive": down, "clearance_negative": up}
    return numbers


def figures(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return coverage without and with nuisances, and by parameter without."""
    parts = {"without_nuisances": [], "with_nuisances": []}  # type: dict[str, list[Interval]]
    for trial in trials:
        nuisances = classes.parse(trial.kind).nuisances
        parts["with_nuisances" if nuisances else "without_nuisances"] += intervals(trial)
    out: dict[str, Any] = {name: _counted(part) for name, part in parts.items() if part}
    by_name: dict[str, list[Interval]] = {}
    for interval in parts["without_nuisances"]:
        by_name.setdefault(f"{interval.kind}.{interval.name}", []).append(interval)
    out["parameters"] = {name: _counted(part) for name, part in sorted(by_name.items())}
    return out


def _counted(found: Sequence[Interval]) -> dict[str, Any]:
    whole = [i for i in found if i.exercised]
    holding = sum(i.holds for i in whole)
    low, high = clopper_pearson(holding, len(whole)) if whole else (0.0, 1.0)
    errors = [i.error for i in whole if i.error is not None]
    return {
        "intervals": len(whole),
        "holding": holding,
        "coverage": holding / len(whole) if whole else float("nan"),
        "low": low,
        "high": high,
        "met": low <= HIGH_GOAL and high >= LOW_GOAL,
        "not_exercised": len(found) - len(whole),
        "bounds_that_hold": sum(i.holds for i in found if not i.exercised),
        "error_median": float(np.median(errors)) if errors else float("nan"),
    }


def text(trials: Sequence[Trial]) -> str:
    """Return coverage as text; parameters that miss more than 1 of 20 by name."""
    found = figures(trials)
    lines = []
    for key in ("without_nuisances", "with_nuisances"):
        if part := found.get(key):
            lines.append(
                f"95 % intervals {key.replace('_', ' ')}: {part['holding']}/{part['intervals']}"
                f" = {part['coverage']:.1%} ({part['low']:.1%}-{part['high']:.1%}), goal"
                f" {LOW_GOAL:.0%}-{HIGH_GOAL:.0%}; median error {part['error_median']:.2%};"
                f" not exercised {part['not_exercised']}, whose bounds hold"
                f" {part['bounds_that_hold']}"
            )
    for name, part in found["parameters"].items():
        if part["intervals"] and part["coverage"] < LOW_GOAL:
            lines.append(f"  {name}: {part['holding']}/{part['intervals']}")
    return "\n".join(lines)
