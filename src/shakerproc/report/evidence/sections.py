"""The evidence of a comparison and a diagnosis as sections of the report."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.comparison import Comparison, JointMotion, NotTold, sentence
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.headline import probability_text
from shakerproc.diagnosis.result import Diagnosis, Tried
from shakerproc.models import EFFECTS
from shakerproc.models.motion import shown_in
from shakerproc.numerals import numeral
from shakerproc.report.evidence import motion, spectra
from shakerproc.report.evidence.comparison import Models, level_of, loudest
from shakerproc.report.evidence.motion import free_law, laws
from shakerproc.report.evidence.numbers import (
    CandidateError,
    candidate_name,
    interval,
    ladder,
    parameter_tables,
    shown_value,
)
from shakerproc.report.page.sections import PageFigure, ReportSection, ReportTable
from shakerproc.runs.summary import by_tests

ONE_METHOD: Final = (
    "All errors in this report are of a model that runs free under the measured input. Where "
    "a motion cannot be predicted for a whole test, a diagnosis predicts windows of one length "
    "and fits their starts. Its errors then differ a little from those above."
)


def model_section(models: Models) -> ReportSection:
    """Return where a model fails, and where its successor still does."""
    columns = ("test", "level", "held out", models.old, models.new, "noise", "note")
    rows = []
    after = models.after
    for i, test in enumerate(models.before.tests):
        level = level_of(test)
        held = "yes" if test.measured.test.hold_out else ""
        new = f"{after.tests[i].error:.2%}" if after else ""
        horizon = test.prediction.horizon_s
        note = "" if horizon is None else f"scored in windows of {numeral(horizon)} s"
        rows.append((
            test.measured.name, level, held, f"{test.error:.1%}", new,
            _share(models.noise[i]), note,
        ))  # fmt: skip
    kept = [i for i in range(len(columns)) if i < 3 or any(row[i] for row in rows)]
    table = ReportTable(
        "Share of the measured response that the model, run free, does not explain",
        [columns[i] for i in kept],
        [[row[i] for i in kept] for row in rows],
    )
    paragraphs = [_opened(models.old, sentence(models.before))]
    if after is not None:
        paragraphs.append(_opened(models.new, sentence(after)))
    told = by_tests((t.measured.name, t.measured.remarks) for t in models.before.tests)
    paragraphs += [f"{line[0].upper()}{line[1:].removesuffix('.')}." for line in told]
    paragraphs += _limits(models.before)
    forces = motion.restoring_force(models)
    drift = motion.error_in_time(models)
    parts = [
        ReportSection(
            "Response functions",
            "responses",
            [
                "Broad grey: measured. Where the lines depart from it the model fails; check "
                "whether they depart more at a higher level. A coherence that is low in the "
                "measurement and not in the model is a nonlinearity that the model lacks."
            ],
            figures=spectra.responses(models),
        ),
        ReportSection(
            "Error by band, level and motion",
            "errors",
            figures=[
                *motion.error_maps(models),
                *spectra.error_by_band(models),
                motion.error_by_level(models),
                *motion.error_by_motion(models),
                *drift,
                *spectra.harmonics(models),
            ],
        ),
    ]
    joints = joint_table(models.before)
    if joints is not None:
        parts.append(
            ReportSection("Restoring force", "forces", tables=[joints], figures=forces)
        )
    return ReportSection(
        "Where the model fails", "model", paragraphs, [table, *_refit(models)], parts=parts
    )


def _limits(comparison: Comparison) -> list[str]:
    """Return which tests took no part, which look faulty, and which were used in part."""
    each = comparison.tests
    notes = [note for test in each for note in (*test.measured.notes, *test.notes)]
    return [*comparison.left_out, *comparison.warnings, *notes]


def _opened(name: str, text: str) -> str:
    """Return a sentence about a model after its name."""
    return f"{name[0].upper()}{name[1:]}: {text}".replace("^2", "²")


def _share(value: float) -> str:
    return f"{value:.2%}" if math.isfinite(value) else "unknown"


def _refit(models: Models) -> list[ReportTable]:
    """Return the numbers that were fitted before the comparison, if any were."""
    fitted = models.before.refit or (models.after.refit if models.after else None)
    if fitted is None:
        return []
    rows = []
    for p in fitted.parameters:
        estimate = Estimate(p.value, p.low, p.high, p.unit)
        note = "ran against its bound" if p.at_bound else ""
        before = shown_value(Estimate(p.before, None, None, p.unit))
        rows.append((p.kind, " - ".join(p.between), p.name, before, *interval(estimate), note))
    title = f"Numbers of the model fitted to test {', '.join(fitted.tests)}, 95 % intervals"
    columns = (
        "element",
        "between",
        "number",
        "before",
        "fitted",
        "low",
        "high",
        "±",
        "unit",
        "",
    )
    return [ReportTable(title, columns, rows)]


def diagnosis_section(diagnosis: Diagnosis, models: Models | None = None) -> ReportSection:
    """Return which effect is missing: verdict, ladder, numbers, open questions.

    Parameters
    ----------
    diagnosis : Diagnosis
        The verdict and all that stands behind it.
    models : Models, optional
        The comparison that stands in the same report.
    """
    sentences = [] if models is None else _limits(models.before)
    paragraphs = [
        f"Verdict: {diagnosis.verdict}. {diagnosis.sentence}",
        *_signatures(diagnosis),
        *(note for note in diagnosis.notes if note not in sentences),
        *_confidence(diagnosis),
    ]
    if models is not None:
        paragraphs.append(ONE_METHOD)
    drawn = [] if diagnosis.outside is None else [free_law(diagnosis.outside)]
    predicted = [] if models is None else motion.hidden(diagnosis, models.before.model.motion)
    parts = [
        ReportSection(
            "Errors of the models that were tried",
            "ladder",
            _unfinished(diagnosis),
            figures=[error_ladder(diagnosis)],
        ),
        ReportSection("Missing force", "free_law", figures=drawn),
        ReportSection("Joints without a measured force", "hidden", figures=predicted),
        ReportSection("Numbers", "numbers", tables=parameter_tables(diagnosis)),
        _open_questions(diagnosis, models),
    ]
    kept = [part for part in parts if part.paragraphs or part.tables or part.figures]
    return ReportSection("What is missing", "diagnosis", paragraphs, parts=kept)


def _confidence(diagnosis: Diagnosis) -> list[str]:
    """Return how probable the verdict is, or why that is not known."""
    text = probability_text(diagnosis)
    return [f"Verdict, effects and joints: {text}."] if text else []


def _horizon(diagnosis: Diagnosis) -> str:
    """Return how far ahead the models of a diagnosis predict, as a sentence."""
    ahead_s = diagnosis.errors.among.ahead_s
    if not ahead_s:
        return "Free-run simulation of whole tests."
    return (
        f"Free-run simulation of windows of {' and '.join(f'{numeral(s)} s' for s in ahead_s)}."
    )


def _signatures(diagnosis: Diagnosis) -> list[str]:
    """Return the signature of each effect found, to be compared with the figures."""
    return [
        f"What a {effect.kind.replace('_', ' ')} looks like: {EFFECTS[effect.kind].signature}"
        for effect in diagnosis.effects
        if effect.kind in EFFECTS
    ]


def error_ladder(diagnosis: Diagnosis) -> PageFigure:
    """Return the errors of the old model, every candidate and the new model."""
    errors = diagnosis.errors.among
    rungs = [
        CandidateError(
            "model as it was", errors.fitted.before, errors.held_out.before, strong=True
        )
    ]
    best_last = sorted(
        diagnosis.candidates,
        key=lambda c: np.inf if c.held_out_error is None else -c.held_out_error,
    )
    fitted = [c for c in best_last if c.held_out_error is not None]
    many = len({c.between for c in diagnosis.candidates}) > 1
    rungs += [
        CandidateError(_named(c, place=many), c.fitted_error, c.held_out_error) for c in fitted
    ]
    if diagnosis.verdict == "outside library" and diagnosis.further:
        new = f"with {candidate_name(diagnosis.further[0], {})}"
    else:
        new = "with the effect" if diagnosis.effects else "without an effect"
    rungs.append(
        CandidateError(
            new,
            errors.fitted.after,
            errors.held_out.after,
            strong=True,
        )
    )
    return PageFigure(
        "Error of every model that was tried.",
        f"{_horizon(diagnosis)} Held-out tests took no part in the fit. The effect is real "
        "where their error falls as far as that of the fitted ones. The rest should be near "
        "the noise.",
        ladder(rungs, errors.noise_floor, title="Errors of all models that were tried"),
        broad=True,
    )


def _named(candidate: Tried, *, place: bool) -> str:
    """Return a candidate's name, and where it acts if that is told."""
    name = candidate_name(candidate.kind, candidate.parameters)
    return f"{name}, {' - '.join(candidate.between)}" if place else name


def _unfinished(diagnosis: Diagnosis) -> list[str]:
    """Return which candidates were not fitted to the end."""
    out = [c for c in diagnosis.candidates if c.held_out_error is None]
    many = len({c.between for c in diagnosis.candidates}) > 1
    names = "; ".join(_named(c, place=many) for c in out)
    return (
        [f"Screened, but not fitted to the end, as others explain more: {names}."]
        if out
        else []
    )


def _open_questions(diagnosis: Diagnosis, models: Models | None) -> ReportSection:
    """Return the indistinguishable alternatives, and the test that would decide."""
    paragraphs = []
    same = [name.replace("_", " ") for name in diagnosis.indistinguishable]
    kinds = [e.kind.replace("_", " ") for e in diagnosis.effects if e.kind in EFFECTS]
    if same:
        paragraphs.append(
            f"Cannot be told apart on these tests: {', '.join([*kinds, *same])}. Where the "
            "alternatives have numbers of their own, see above whether they differ."
        )
    elif kinds:
        paragraphs.append("No other candidate does as well on these tests.")
    rows = [
        (
            test.excitation,
            test.level.replace("^2", "²"),
            f"{numeral(test.band_hz[0], 4)} to {numeral(test.band_hz[1], 4)} Hz",
            test.like,
            ", ".join(kind.replace("_", " ") for kind in test.separates),
            test.reason,
        )
        for test in diagnosis.next_test
    ]
    columns = ("excitation", "level", "band", "else as", "tells apart", "why")
    drawn = None if models is None else laws(models, diagnosis)
    return ReportSection(
        "What is open, and the test that would settle it",
        "open",
        paragraphs,
        [ReportTable("Next test", columns, rows)] if rows else [],
        [] if drawn is None else [drawn],
    )


def sections(models: Models | None, diagnosis: Diagnosis | None) -> Sequence[ReportSection]:
    """Return the sections there is evidence for."""
    out = []
    if models is not None:
        out.append(model_section(models))
    if diagnosis is not None:
        out.append(diagnosis_section(diagnosis, models))
    return out


def joint_table(comparison: Comparison) -> ReportTable | None:
    """Return a row for each joint in the loudest test; None of a model without joints."""
    test = comparison.tests[loudest(comparison)]
    sentences = [float(np.sqrt(np.mean(joint.displacement**2))) for joint in test.joints]
    open_ = [one.displacement_rms or 0.0 for one in test.not_told]
    unit, factor = shown_in("m", comparison.model.motion, max(sentences + open_, default=None))
    rows = [_joint_row(joint, factor) for joint in test.joints]
    rows += [_open(one, factor) for one in test.not_told]
    if not rows:
        return None
    return ReportTable(
        f"Joints in test {test.measured.name}, from the recordings and the masses alone",
        (
            "between",
            f"force rms [{comparison.model.unit_of('N')}]",
            f"displacement rms [{unit}]",
            f"± [{unit}]",
            "from [Hz]",
            "note",
        ),
        rows,
    )


def _joint_row(joint: JointMotion, factor: float) -> tuple[str, ...]:
    force, displacement = (
        float((x**2).mean()) ** 0.5 for x in (joint.force, joint.displacement)
    )
    unsure = numeral(joint.unsure * factor, 2) if math.isfinite(joint.unsure) else "unknown"
    low = numeral(joint.band[0]) if joint.band[0] > 0.0 else ""
    return (
        " - ".join(joint.between),
        numeral(force, 4),
        numeral(displacement * factor),
        unsure,
        low,
        "",
    )


def _open(joint: NotTold, factor: float) -> tuple[str, ...]:
    force, displacement = joint.force_rms, joint.displacement_rms
    return (
        " - ".join(joint.between),
        "" if force is None else numeral(force, 4),
        "" if displacement is None else numeral(displacement * factor),
        "",
        "",
        f"not drawn: {joint.why}",
    )
