"""From a model and its tests to a diagnosis."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from shakerproc.comparison.measured import Measured, Usable
from shakerproc.comparison.noise import Refuted
from shakerproc.diagnosis import component_tests
from shakerproc.diagnosis.beside import with_all
from shakerproc.diagnosis.campaign import as_it_is, campaign_of
from shakerproc.diagnosis.data import PreparedTest, TestArrays, check, prepared, with_noise_of
from shakerproc.diagnosis.data.from_files import arrays, tests_of
from shakerproc.diagnosis.estimation.linear import as_given
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along
from shakerproc.diagnosis.nudged.race import MOST, chosen
from shakerproc.diagnosis.outcome import at_the_horizon, told
from shakerproc.diagnosis.plausibility import check_plausible
from shakerproc.diagnosis.progress import Progress, progress_of
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.diagnosis.search import search
from shakerproc.diagnosis.selection.refuted import refuted_notes, with_more_refuted
from shakerproc.diagnosis.selection.verdict import judged
from shakerproc.diagnosis.updated import Comparisons
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model
from shakerproc.testlog import Shaker, TestLog

UNLIMITED: Final = Shaker()
"""A shaker of which no limit is known."""


def diagnose(
    model: Model,
    log: TestLog,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from the tests of a log.

    Parameters
    ----------
    model : Model
        The model as it is.
    log : TestLog
        The tests; those with ``hold_out: true`` are only scored.
    seed : int
        Of the tests that are proposed.
    progress : callable or Progress, optional
        Called with what is being done; a `Progress` limits how long that takes.

    Raises
    ------
    DiagnosisError
        If the tests and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    return diagnose_tests(model, log, tests_of(log, model), seed=seed, progress=progress)


def diagnose_tests(
    model: Model,
    log: TestLog,
    usable: Usable,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
    comparisons: Comparisons | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from tests that were read from a log.

    Its errors are those of `compare`; `comparisons` keeps what that takes.

    Raises
    ------
    DiagnosisError
        If the tests and the model do not fit together.
    """
    measured: Sequence[Measured] = usable.tests
    check_plausible(model, measured)  # before the long work
    clearances = [float(m.test.actual_clearance or m.test.clearance or 0.0) for m in measured]
    found = diagnose_arrays(
        model,
        [arrays(m) for m in measured],
        sensors=measured[0].sensors,
        clearances=[c for c in clearances if c > 0.0],
        shaker=log.shaker,
        seed=seed,
        progress=progress,
        comparisons=comparisons or Comparisons(measured, progress or (lambda _text: None)),
    )
    return replace(found, notes=(*usable.left_out, *usable.notes, *found.notes))


def diagnose_arrays(
    model: Model,
    tests: Sequence[TestArrays],
    *,
    sensors: Sequence[str] | None = None,
    clearances: Sequence[float] = (),
    shaker: Shaker = UNLIMITED,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
    comparisons: Comparisons | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from samples in memory.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of TestArrays
        Tests whose responses stand in the order of `sensors`.
    sensors : sequence of str, optional
        Names of the responses; by default all sensors of the model.
    clearances : sequence of float, optional
        Free play that the log says the specimens have [m].
    shaker : Shaker, optional
        Limits that a proposed test keeps to.
    seed : int
        Of the tests that are proposed.
    progress : callable or Progress, optional
        Called with what is being done; a `Progress` limits how long that takes.
    comparisons : Comparisons, optional
        What tells the errors as `compare` does; by default they are those of candidates.

    Raises
    ------
    DiagnosisError
        If the tests do not fit the model, or are too short.
    """
    names = tuple(model.sensors if sensors is None else sensors)
    if not tests:
        raise DiagnosisError(
            f"{model.title}: no test to judge by; the log has none that was run."
        )
    for test in tests:
        check(test, len(names))
    say = progress_of(progress)
    known = replace(model, sensors={name: model.sensors[name] for name in names})
    imposed = known.excitation.imposed
    seek = search_component_tests if imposed else search
    refuted: dict[str, Refuted] = {}

    def estimated(less: Mapping[str, Refuted]) -> Sequence[PreparedTest]:
        return prepared(tests, imposed=imposed, refuted=less)

    found = seek(known, estimated(refuted), say)
    while (more := with_more_refuted(found, refuted, estimated)) != refuted:
        say("again, with the next estimate of the noise")
        refuted = more
        less = estimated(refuted)
        again = None if imposed else judged_again(known, found, less, say)
        found = again or seek(known, less, say)
    say("the verdict")
    verdict = judged(
        found, clearances=clearances, shaker=shaker, seed=seed, comparisons=comparisons
    )
    return replace(verdict, notes=(*verdict.notes, *refuted_notes(refuted), *say.notes))


def search_component_tests(model: Model, tests: Sequence[PreparedTest], say: Progress) -> Found:
    """Return which single effect explains the force over an imposed motion, and how well.

    Raises
    ------
    DiagnosisError
        If the force cannot be simulated.
    """
    campaign = campaign_of(model, tests)
    form = component_tests.form_of(campaign.data)
    if not len(form.held_out):
        raise DiagnosisError(
            f"{model.title}: nothing can be held out, since the drive of each test repeats "
            "itself. Add a test with another amplitude or frequency, marked hold_out: true."
        )
    data = campaign.data
    say("the model's own numbers")
    linear = component_tests.linear_fit(data, form)
    if linear is None:
        raise DiagnosisError(f"{model.title}: its force cannot be simulated in these tests.")
    one = component_tests.raced(campaign, form, linear, say)
    bare = along(campaign, [linear], [form])
    if not bare:
        raise DiagnosisError(
            f"{model.title}: its force cannot be simulated in what is held out."
        )
    found = Found(
        data=data,
        linear_model=as_given(model, tests),
        form=form,
        before=as_it_is(model, linear),
        linear=bare[0],
        effects=(),
        free=None,
        behind=one.left,
        failed=one.failed,
    ).with_effects(along(campaign, chosen(one.left, MOST), [form]))  # held-out tests judge
    return with_all(found, campaign, [form], say)


def judged_again(
    model: Model, before: Found, tests: Sequence[PreparedTest], say: Progress
) -> Found | None:
    """Return the hypotheses, fitted and judged at the horizon by another noise.

    None where they leave more than noise then: others may be better. Of structures all raced,
    whatever the noise.

    Parameters
    ----------
    model, tests, say
        As for `search`; the tests differ from those before by their noise alone.
    before : Found
        What was found before.
    """
    added = [one for score in before.effects for one in score.fit.hypothesis.added]
    scaled_by = added[0].identification.scaled_by if added else None
    less = with_noise_of(before.data.tests, tests)
    campaign = campaign_of(before.data.model, less, scaled_by)
    if before.data.points:
        campaign = replace(campaign, data=campaign.data.as_values())
    if before.data.differing:
        campaign = replace(campaign, data=campaign.data.as_differing())
    fits = [score.fit for score in before.effects]
    outcome = at_the_horizon(campaign, before.linear.fit, fits, say)
    found = replace(
        told(model, before.linear_model, outcome, before.failed, before.behind),
        corrected=before.corrected,
        rigid=before.rigid,
        signs=before.signs,
        late=before.late,
        hums=before.hums,
        recorded=tuple(tests) if before.recorded else (),
    )
    return found if found.rigid or found.is_enough or model.structures else None
