"""Every number that the evidence shows, as tables for other programs."""

from typing import Any, Final

import numpy as np

from shakerproc.comparison import by_range
from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.report.evidence.models import Models, loudest, same_joint, spread_out
from shakerproc.report.evidence.motion import cloud
from shakerproc.report.evidence.spectra import picked

Columns = dict[str, list[Any]]

_OF_MOTION: Final = ("test", "between", "model", "quantity", "unit")
_MOTIONS: Final = (("displacement", "m"), ("velocity", "m/s"))


def tables(models: Models | None, diagnosis: Diagnosis | None) -> dict[str, Columns]:
    """Return columns by the name of their file."""
    out: dict[str, Columns] = {}
    if models is not None:
        out["response_functions.csv"] = response_functions(models)
        out["errors_by_test.csv"] = errors_by_test(models)
        out["errors_by_band.csv"] = errors_by_band(models)
        out["errors_by_motion.csv"] = errors_by_motion(models)
        out["restoring_force.csv"] = restoring_forces(models)
    if diagnosis is not None:
        out["ladder.csv"] = ladder(diagnosis)
        out["parameters.csv"] = parameters(diagnosis)
    return {name: columns for name, columns in out.items() if next(iter(columns.values()))}


def _columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> Columns:
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def response_functions(models: Models) -> Columns:
    """Return response function and coherence of the drawn tests, measured and of each model."""
    rows: list[tuple[Any, ...]] = []
    for index in spread_out(models.before):
        test = models.before.tests[index]
        _, pick = picked(test.pair.frequency, test.pair.excited)
        for sensor, name in enumerate(test.measured.sensors):
            pair = test.pair
            whose = [("measured", pair.h1[sensor], pair.coherence[sensor])] + [
                (text, c.tests[index].pair.h1_model[sensor],
                 c.tests[index].pair.coherence_model[sensor])
                for text, _, c in models.each
            ]  # fmt: skip
            for text, h1, coherence in whose:
                rows += [
                    (test.measured.name, name, text, float(f), float(abs(h)),
                     float(np.degrees(np.angle(h))), float(g))
                    for f, h, g in zip(
                        pair.frequency[pick], h1[pick], coherence[pick], strict=True
                    )
                ]  # fmt: skip
    names = ("test", "sensor", "whose", "frequency_hz", "magnitude", "phase_deg", "coherence")
    return _columns(names, rows)


def errors_by_test(models: Models) -> Columns:
    """Return the error of each model in every test, and the noise."""
    rows = [
        (test.measured.name, test.measured.test.level_text, test.measured.test.hold_out, text,
         float(np.sqrt(np.mean(test.prediction.input**2))), test.error, test.noise,
         test.floor.source)
        for text, _, comparison in models.each
        for test in comparison.tests
    ]  # fmt: skip
    names = (
        "test",
        "level",
        "held_out",
        "model",
        "input_rms_si",
        "error",
        "noise",
        "noise_from",
    )
    return _columns(names, rows)


def errors_by_band(models: Models) -> Columns:
    """Return the error of each model in every third octave."""
    rows = []
    for text, _, comparison in models.each:
        bands = comparison.bands
        for i, test in enumerate(comparison.tests):
            for j, sensor in enumerate(test.measured.sensors):
                for k in range(bands.edges.size - 1):
                    rows.append((
                        test.measured.name, sensor, text, float(bands.edges[k]),
                        float(bands.edges[k + 1]), float(bands.error[i, j, k]),
                        float(bands.floor[i, j, k]), float(bands.share[i, j, k]),
                    ))  # fmt: skip
    names = ("test", "sensor", "model", "from_hz", "to_hz", "error", "noise", "share_of_error")
    return _columns(names, rows)


def errors_by_motion(models: Models) -> Columns:
    """Return the force that each model lacks by range of displacement and velocity."""
    rows = []
    for text, _, comparison in models.each:
        for test in comparison.tests:
            for joint in test.joints:
                for quantity, si in _MOTIONS:
                    found = by_range(joint, getattr(joint, quantity))
                    rows += [
                        (test.measured.name, " - ".join(joint.between), text, quantity,
                         models.before.model.unit_of(si), float(a), float(b), float(c))
                        for a, b, c in zip(found.centre, found.mean, found.error, strict=True)
                    ]  # fmt: skip
    return _columns((*_OF_MOTION, "middle", "missing_force_n", "error"), rows)


def restoring_forces(models: Models) -> Columns:
    """Return the samples of the restoring force that are drawn."""
    index = loudest(models.before)
    test = models.before.tests[index]
    rows = []
    for joint in test.joints:
        for text, _, comparison in models.each:
            motion = same_joint(comparison.tests[index], joint.between)
            if motion is None:
                continue
            for quantity, si in _MOTIONS:
                unit = models.before.model.unit_of(si)
                along, force, law = cloud(motion, by_velocity=quantity == "velocity")
                rows += [
                    (test.measured.name, " - ".join(joint.between), text, quantity, unit, *row)
                    for row in zip(along.tolist(), force.tolist(), law.tolist(), strict=True)
                ]
    return _columns((*_OF_MOTION, "motion", "force_n", "force_model_n"), rows)


def ladder(diagnosis: Diagnosis) -> Columns:
    """Return the error of every model that was tried."""
    errors = diagnosis.errors.among
    rows: list[tuple[Any, ...]] = [
        ("model as it was", "", errors.fitted.before, errors.held_out.before)
    ]
    rows += [
        (c.kind, " - ".join(c.between), c.fitted_error, c.held_out_error)
        for c in diagnosis.candidates
    ]
    rows.append(("new model", "", errors.fitted.after, errors.held_out.after))
    rows.append(("noise floor", "", None, errors.noise_floor))
    return _columns(("model", "between", "fitted_error", "held_out_error"), rows)


def parameters(diagnosis: Diagnosis) -> Columns:
    """Return the numbers of what was found, of the linear joints and of every candidate."""
    rows: list[tuple[Any, ...]] = [
        ("found", e.kind, " - ".join(e.between), name, *p.row)
        for e in diagnosis.effects
        for name, p in e.parameters.items()
    ]
    rows += [
        ("linear", "joint", place, number, *p.row)
        for name, p in diagnosis.linear.items()
        for number, place in [name.split(" ", 1)]
    ]  # fmt: skip
    rows += [
        ("candidate", c.kind, " - ".join(c.between), name, *p.row)
        for c in diagnosis.candidates
        if c.held_out_error is not None
        for name, p in c.parameters.items()
    ]
    return _columns(("of", "kind", "between", "number", *ESTIMATE_COLUMNS), rows)
