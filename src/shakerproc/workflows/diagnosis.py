"""Which effect a model lacks: what `shakerproc diagnose` does."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

from shakerproc.diagnosis import diagnose_tests
from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS
from shakerproc.diagnosis.headline import probability_text
from shakerproc.diagnosis.result import Diagnosis as Found
from shakerproc.testlog import TestLog
from shakerproc.workflows.arguments import log_of, whole_of
from shakerproc.workflows.given_models import model_of
from shakerproc.workflows.shown import Shown, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Diagnosis(Shown):
    """Which effect a model lacks, how surely, and which test would settle it.

    Attributes
    ----------
    found : shakerproc.diagnosis.Diagnosis
        The whole of it, typed.
    """

    found: Found

    @property
    def verdict(self) -> str:
        """Verdict, such as ``effect found`` or ``nothing missing``."""
        return self.found.verdict

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return self.found.sentence

    @property
    def confidence(self) -> float | None:
        """The probability that verdict, kinds and joints are exactly right [-]."""
        return self.found.confidence

    @property
    def effects(self) -> "DataFrame":
        """The effects that were found: their numbers in SI units, with 95 % intervals."""
        rows = [
            (effect.kind, " - ".join(effect.between), name, *p.row)
            for effect in self.found.effects
            for name, p in effect.parameters.items()
        ]
        names = ("effect", "between", "parameter", *ESTIMATE_COLUMNS)
        return frame_of_rows(names, rows)

    @property
    def errors(self) -> "DataFrame":
        """The free-run errors before and after, and the noise floor [-]."""
        errors = self.found.errors
        rows = [
            ("before", errors.fitted.before, errors.held_out.before),
            ("after", errors.fitted.after, errors.held_out.after),
            ("noise floor", None, errors.noise_floor),
        ]
        return frame_of_rows(("error", "fitted", "held_out"), rows)

    def to_pandas(self) -> "DataFrame":
        """Return every hypothesis that was tried, best first, with its errors [-]."""
        rows = [
            (one.kind, " - ".join(one.between), one.fitted_error, one.held_out_error)
            for one in self.found.candidates
        ]
        return frame_of_rows(("candidate", "between", "fitted_error", "held_out_error"), rows)

    def as_json(self) -> dict[str, Any]:
        """Return the diagnosis as diagnosis.json holds it."""
        return self.found.as_json()

    def plot(self) -> "Figure":
        """Return the errors of all hypotheses beside the model as it was and the noise."""
        from shakerproc.report.evidence.errors import candidate_errors

        return candidate_errors(self.found)

    def _repr_html_(self) -> str:
        told = [self.sentence, *filter(None, [probability_text(self.found)]), *self.found.notes]
        return html(self.verdict, told, self.errors, self.effects, self.to_pandas())


def diagnose(model: Any, log: TestLog, *, seed: int = 0) -> Diagnosis:
    """Return which effect a model lacks, how surely, and which test would settle it.

    Parameters
    ----------
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    log : TestLog
        What `read_log` returned; tests with ``hold_out: true`` are only scored.
    seed : int
        Of the tests that are proposed.

    Raises
    ------
    ArgumentError
        If an argument is of another kind.
    DiagnosisError
        If the tests and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    known, tests = model_of(model).model, log_of(log)
    number = whole_of("seed", seed, 0)
    return Diagnosis(diagnose_tests(known, tests, tests_of(tests, known), seed=number))
