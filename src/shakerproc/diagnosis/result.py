"""Result of a diagnosis: typed, and as the JSON document that other programs read."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias, final

from shakerproc.comparison.hidden_joints import HiddenJoint
from shakerproc.diagnosis.estimate import Estimate, Known
from shakerproc.diagnosis.joint_outcomes import FurtherMode, Locked, Outside
from shakerproc.models import Scale

SCHEMA: Final = "shakerproc-diagnosis/1"

Verdict: TypeAlias = Literal[
    "effect found", "nothing missing", "measurement fault", "outside library", "cannot tell"
]


@final
@dataclass(frozen=True, slots=True)
class Finding:
    """An effect or a fault that was found.

    Attributes
    ----------
    kind : str
        Key of `EFFECTS` or `FAULTS`.
    between : tuple of str
        The two places of an effect; the channel of a fault.
    parameters : mapping of str to Estimate
        Fitted numbers.
    scaled_by : Scale, optional
        Condition that the force is proportional to, and at which the numbers hold.
    """

    kind: str
    between: tuple[str, ...]
    parameters: Mapping[str, Estimate]
    scaled_by: Scale | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        scale = self.scaled_by
        scaled = {} if scale is None else {"scaled_by": {scale.condition: scale.at}}
        return {
            "kind": self.kind,
            "between": list(self.between),
            "parameters": {name: p.as_json() for name, p in self.parameters.items()},
            **scaled,
        }


@final
@dataclass(frozen=True, slots=True)
class BeforeAfter:
    """An error before and after, as a share of the response [-]."""

    before: float
    after: float

    def as_json(self) -> dict[str, float]:
        """Return the part of the document."""
        return {"before": self.before, "after": self.after}


@final
@dataclass(frozen=True, slots=True)
class Errors:
    """The free-run error, on fitted and on held-out tests [-].

    Attributes
    ----------
    fitted, held_out : BeforeAfter
        Before and after.
    noise_floor : float
        What even the true model would leave [-].
    horizon_s : mapping of str to float or None
        For each test the length of the windows in which its motion was predicted; None where
        it was predicted as a whole [s].
    without : float, optional
        What the model leaves of what was held out with its own numbers fitted, but no effect.
    of_candidates : Errors, optional
        The same as candidates are compared: over as long as motions can be predicted, with
        gains and delays of sensors, further modes and what each test has of its own fitted.
        None where that is the same.
    """

    fitted: BeforeAfter
    held_out: BeforeAfter
    noise_floor: float
    horizon_s: Mapping[str, float | None] = field(default_factory=dict)
    without: float | None = None
    of_candidates: "Errors | None" = None

    @property
    def ahead_s(self) -> tuple[float, ...]:
        """How far ahead motions are predicted, the shortest first; empty of whole tests [s]."""
        return tuple(sorted({s for s in self.horizon_s.values() if s is not None}))

    @property
    def among(self) -> "Errors":
        """The errors as candidates are compared."""
        return self.of_candidates or self

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "fitted": self.fitted.as_json(),
            "held_out": self.held_out.as_json(),
            "noise_floor": self.noise_floor if math.isfinite(self.noise_floor) else None,
            "horizon_s": dict(self.horizon_s),
            "without_effect": self.without,
            "of_candidates": None
            if self.of_candidates is None
            else self.of_candidates.as_json(),
        }


@final
@dataclass(frozen=True, slots=True)
class Tried:
    """A hypothesis; where it fell behind with `screened`, its rms over the noise then [-]."""

    kind: str
    between: tuple[str, ...]
    fitted_error: float | None
    held_out_error: float | None
    parameters: Mapping[str, Estimate]
    screened: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "kind": self.kind,
            "between": list(self.between),
            "screened": self.screened,
            "fitted_error": self.fitted_error,
            "held_out_error": self.held_out_error,
            "parameters": {name: p.as_json() for name, p in self.parameters.items()},
        }


@final
@dataclass(frozen=True, slots=True)
class Where:
    """Where the model as it was fails most."""

    bands_hz: tuple[tuple[float, float], ...] = ()
    displacement_m: tuple[float, float] | tuple[()] = ()
    velocity_m_per_s: tuple[float, float] | tuple[()] = ()
    tests: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "bands_hz": [list(band) for band in self.bands_hz],
            "displacement_m": list(self.displacement_m),
            "velocity_m_per_s": list(self.velocity_m_per_s),
            "tests": list(self.tests),
        }


@final
@dataclass(frozen=True, slots=True)
class NextTest:
    """A test that would settle what is open.

    Attributes
    ----------
    excitation, level : str
        As a test log says them.
    separates : tuple of str
        Kinds that it tells apart.
    reason : str
        Why this one.
    band_hz : (float, float)
        What it excites [Hz].
    like : str
        The test of the log that lends the rest; empty where it is like none.
    """

    excitation: str
    level: str
    separates: tuple[str, ...]
    reason: str
    band_hz: tuple[float, float] = (5.0, 1000.0)
    like: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        return {
            "excitation": self.excitation,
            "level": self.level,
            "separates": list(self.separates),
            "reason": self.reason,
            "band_hz": list(self.band_hz),
            "like": self.like,
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
    complete : bool
        Whether the model with what was found leaves no more than noise.
    left : Where
        Where it does else.
    next_test : tuple of NextTest
        What would settle it.
    confidence : float, optional
        Calibrated probability that verdict, kinds and joints are exactly right [-]; None where
        more than noise is left, for it is that of laws which explain everything.
    scores : mapping of str to float
        What the probability is made of.
    locked : tuple of Locked
        Joints that never slipped.
    outside : Outside, optional
        The missing force, where the verdict is "outside library".
    linear : mapping of str to Estimate
        The model's own numbers, such as the stiffness of its joints, fitted with the effects.
    known_together : tuple of Known
        What the tests tell of numbers that they do not tell one by one.
    modes : tuple of FurtherMode
        Linear modes that the model has not, fitted before any effect, or beside the best.
    further : tuple of str
        Kinds of effects that would lower the error somewhat, but not by most of what is left.
    notes : tuple of str
        What the reader must know besides, a sentence each.
    hidden : tuple of HiddenJoint
        Motion and force of joints that recordings do not tell, of the model that was found.
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
    complete: bool = True
    left: Where = Where()
    confidence: float | None = None
    scores: Mapping[str, float] = field(default_factory=dict)
    locked: tuple[Locked, ...] = ()
    outside: Outside | None = None
    linear: Mapping[str, Estimate] = field(default_factory=dict)
    known_together: tuple[Known, ...] = ()
    modes: tuple[FurtherMode, ...] = ()
    further: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    hidden: tuple[HiddenJoint, ...] = ()
    seed: int = 0

    def as_json(self) -> dict[str, Any]:
        """Return the document that DESIGN.md fixes."""
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "sentence": self.sentence,
            "complete": self.complete,
            "confidence": self.confidence,
            "effects": [effect.as_json() for effect in self.effects],
            "indistinguishable": list(self.indistinguishable),
            "errors": self.errors.as_json(),
            "candidates": [candidate.as_json() for candidate in self.candidates],
            "where": self.where.as_json(),
            "left": self.left.as_json(),
            "next_test": [test.as_json() for test in self.next_test],
            "locked": [joint.as_json() for joint in self.locked],
            "outside": self.outside.as_json() if self.outside else None,
            "scores": dict(self.scores),
            "linear": {name: p.as_json() for name, p in self.linear.items()},
            "known_together": [one.as_json() for one in self.known_together],
            "modes": [mode.as_json() for mode in self.modes],
            "further": list(self.further),
            "notes": list(self.notes),
            "seed": self.seed,
        }
