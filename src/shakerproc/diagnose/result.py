"""What a diagnosis says, as far as it differs from that of the new room."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

from shakerproc.diagnosis.result import (
    SCHEMA,
    Estimate,
    Finding,
    NextTest,
    Pair,
    Tried,
    Verdict,
    Where,
)


@final
@dataclass(frozen=True, slots=True)
class Errors:
    """What the model does not explain, on fitted and on held-out tests [-]."""

    fitted: Pair
    held_out: Pair
    noise_floor: float

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "fitted": self.fitted.as_json(),
            "held_out": self.held_out.as_json(),
            "noise_floor": self.noise_floor,
        }


@final
@dataclass(frozen=True, slots=True)
class Diagnosis:
    """The verdict and all that stands behind it.

    Attributes
    ----------
    verdict : str
        One of the five verdicts.
    sentence : str
        The verdict in one sentence.
    effects : tuple of Finding
        Effects and faults found, the most certain first.
    indistinguishable : tuple of str
        Kinds that explain these data as well.
    errors : Errors
        Before and after.
    candidates : tuple of Tried
        Everything that was tried, best first.
    where : Where
        Where the model failed.
    next_test : tuple of NextTest
        What would settle it.
    linear : mapping of str to Estimate
        Stiffness and damping of the linear joints, fitted with the effects.
    notes : tuple of str
        What the reader must know besides, a sentence each.
    seed : int
        Seed of everything that was drawn.
    """

    verdict: Verdict
    sentence: str
    effects: tuple[Finding, ...]
    indistinguishable: tuple[str, ...]
    errors: Errors
    candidates: tuple[Tried, ...]
    where: Where
    next_test: tuple[NextTest, ...]
    linear: Mapping[str, Estimate] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    seed: int = 0

    def as_json(self) -> dict[str, Any]:
        """Return the document that DESIGN.md fixes."""
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "sentence": self.sentence,
            "effects": [effect.as_json() for effect in self.effects],
            "indistinguishable": list(self.indistinguishable),
            "errors": self.errors.as_json(),
            "candidates": [candidate.as_json() for candidate in self.candidates],
            "where": self.where.as_json(),
            "next_test": [test.as_json() for test in self.next_test],
            "linear": {name: p.as_json() for name, p in self.linear.items()},
            "notes": list(self.notes),
            "seed": self.seed,
        }
