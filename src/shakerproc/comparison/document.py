"""A comparison as the JSON document and as rows of a table."""

from typing import Any, Final

import numpy as np

from shakerproc.comparison.comparison import Comparison, TestComparison
from shakerproc.comparison.joints import JointMotion, NotTold, by_range
from shakerproc.comparison.modes import ComparedModes, Shapes
from shakerproc.comparison.refit import Refit
from shakerproc.comparison.verdict import sentence
from shakerproc.data import FloatArray

SCHEMA: Final = "shakerproc-compare/1"

COLUMNS: Final = (
    "test", "excitation", "level", "held_out", "sensor", "error", "noise", "error_time",
    "error_psd", "psd_db", "error_h1", "frac", "coherence_measured_below_model",
    "peak_hz", "peak_model_hz", "gain", "gain_model",
)  # fmt: skip
"""Columns of the table of errors; errors are shares of the measured response."""


def rows_of(comparison: Comparison) -> list[list[object]]:
    """Return the table of errors, one row for each sensor of each test."""
    rows: list[list[object]] = []
    for test in comparison.tests:
        log = test.measured.test
        for i, (name, e) in enumerate(zip(test.measured.sensors, test.errors, strict=True)):
            noise = float(test.floor.share[i])
            rows.append([
                test.measured.name, log.excitation, log.level_text, log.hold_out, name,
                e.error, noise if np.isfinite(noise) else None, e.error, e.psd, e.psd_db, e.h1,
                e.frac, e.coherence, e.peak_hz, e.peak_model_hz, e.peak_gain, e.peak_model_gain,
            ])  # fmt: skip
    return rows


def document_of(comparison: Comparison) -> dict[str, Any]:
    """Return the document: the sentence, the errors of every test, and where they lie."""
    bands = comparison.bands
    return {
        "schema": SCHEMA,
        "model": comparison.model.title,
        "sentence": sentence(comparison),
        "error": comparison.error,
        "error_held_out": comparison.held_out,
        "errors": _summary(comparison),
        "left_out": list(comparison.left_out),
        "warnings": list(comparison.warnings),
        "refit": _refit(comparison.refit),
        "bands_hz": [
            [float(a), float(b)] for a, b in zip(bands.edges, bands.edges[1:], strict=False)
        ],
        "tests": [_test(comparison, i) for i in range(len(comparison.tests))],
    }


MODE_COLUMNS: Final = (
    "measured_hz", "model_hz", "difference_percent", "damping_measured", "damping_model", "mac",
    "expansion_missed", "expansion_left_out",
)  # fmt: skip
"""Columns of the table of modes."""


def mode_rows(modes: ComparedModes) -> list[tuple[float | None, ...]]:
    """Return the table of modes, one row for each pair or mode without partner."""
    return [
        (
            pair.measured_hz, pair.model_hz,
            None if pair.difference is None else 100.0 * pair.difference,
            pair.measured_damping, pair.model_damping, pair.mac, pair.missed, pair.left_out,
        )
        for pair in modes.pairs
    ]  # fmt: skip


def modes_document(modes: ComparedModes) -> dict[str, Any]:
    """Return modes of test and model as the document has them."""
    return {
        "test": modes.test,
        "sensors": list(modes.sensors),
        "sentence": modes.sentence,
        "pairs": [dict(zip(MODE_COLUMNS, row, strict=True)) for row in mode_rows(modes)],
        "mac": modes.macs.tolist(),
        "expansion": None if modes.shapes is None else modes.shapes.sentence,
    }


def mode_tables(modes: ComparedModes | None) -> dict[str, dict[str, list[Any]]]:
    """Return the tables of modes and of shapes as columns, by the name of their file."""
    if modes is None:
        return {}
    rows = mode_rows(modes)
    pairs = {name: [row[i] for row in rows] for i, name in enumerate(MODE_COLUMNS)}
    if modes.shapes is None:
        return {"modes.csv": pairs}
    return {"modes.csv": pairs, "mode_shapes.csv": _shape_columns(modes, modes.shapes)}


def _shape_columns(modes: ComparedModes, shapes: Shapes) -> dict[str, list[Any]]:
    """Return the table of shapes: a row for each pair, or mode without partner, and point."""
    names = ("measured_hz", "model_hz", "point", "test", "test_imaginary", "model",
             "model_imaginary")  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for pair in modes.pairs:
        both = shapes.of_pair(pair)
        for i, point in enumerate(shapes.points):
            parts = [(None, None) if s is None else (s[i].real, s[i].imag) for s in both]
            rows.append((pair.measured_hz, pair.model_hz, point, *parts[0], *parts[1]))
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def _summary(comparison: Comparison) -> dict[str, Any]:
    """Return the free-run errors, their floors and the horizon of every test."""
    return {
        "all": {"error": comparison.error, "noise_floor": _number(comparison.noise)},
        "held_out": {
            "error": comparison.held_out,
            "noise_floor": _number_or_none(comparison.held_out_noise),
        },
        "horizon_s": {
            test.measured.name: test.prediction.horizon_s for test in comparison.tests
        },
    }


def _number_or_none(value: float | None) -> float | None:
    return None if value is None else _number(value)


def _test(comparison: Comparison, index: int) -> dict[str, Any]:
    test, bands = comparison.tests[index], comparison.bands
    log = test.measured.test
    return {
        "test": test.measured.name,
        "excitation": log.excitation,
        "level": log.level_text,
        "held_out": log.hold_out,
        "error": test.error,
        "noise_floor": _number(test.noise),
        "noise_from": test.floor.source,
        "noise_of_input_from": test.measured.noise.input_source,
        "noise_refuted": test.floor.refuted.names,
        "error_band_hz": list(test.measured.error_band),
        "horizon_s": test.prediction.horizon_s,
        "predictable": test.prediction.predictable,
        "own": {
            "constant": test.prediction.own.constant,
            "starts_in_motion": test.prediction.own.start is not None,
            "accelerations_are_values": test.prediction.own.values,
        },
        "growth_of_a_disturbance": test.prediction.simulation.growth,
        "notes": [*test.measured.notes, *test.notes, *test.measured.read],
        "unused": list(test.measured.unused),
        "sensors": [
            {
                "sensor": name,
                **_errors(test, i),
                "by_band": {
                    "error": _list(bands.error[index, i]),
                    "noise": _list(bands.floor[index, i]),
                    "share_of_error": _list(bands.share[index, i]),
                },
                "by_harmonic": _harmonics(test, i),
                "by_time": _time(test, i),
            }
            for i, name in enumerate(test.measured.sensors)
        ],
        "joints": [_joint(motion) for motion in test.joints],
        "joints_not_told": [_not_told(joint) for joint in test.not_told],
    }


def _errors(test: TestComparison, i: int) -> dict[str, Any]:
    e = test.errors[i]
    return {
        "error": e.error,
        "noise_floor": _number(float(test.floor.share[i])),
        "error_time": e.error,
        "error_psd": e.psd,
        "psd_db": e.psd_db,
        "error_h1": e.h1,
        "frac": e.frac,
        "coherence_measured_below_model": e.coherence,
        "peak_hz": e.peak_hz,
        "peak_model_hz": e.peak_model_hz,
        "peak_gain": e.peak_gain,
        "peak_model_gain": e.peak_model_gain,
        "rms": e.rms,
        "rms_model": e.rms_model,
    }


def _harmonics(test: TestComparison, i: int) -> dict[str, Any] | None:
    if test.harmonics is None:
        return None
    h = test.harmonics[i]
    return {
        "order": list(range(1, h.error.size + 1)),
        "measured": _list(h.measured),
        "predicted": _list(h.predicted),
        "error": _list(h.error),
    }


def _time(test: TestComparison, i: int) -> dict[str, Any]:
    return {
        "time_s": _list(test.time.time),
        "error": _list(test.time.error[i]),
        "growth_over_test": float(test.time.slope[i]),
    }


def _joint(motion: JointMotion) -> dict[str, Any]:
    lack = motion.force - motion.force_model
    whole = float(np.sqrt(np.mean(motion.force**2)))
    out: dict[str, Any] = {
        "between": list(motion.between),
        "error": float(np.sqrt(np.mean(lack**2))) / whole if whole > 0.0 else 0.0,
        "force_rms_n": whole,
        "displacement_rms_m": float(np.sqrt(np.mean(motion.displacement**2))),
        "displacement_unsure_m": _number(motion.unsure),
        "band_hz": list(motion.band),
    }
    for name, along, unit in (
        ("by_displacement", motion.displacement, "m"),
        ("by_velocity", motion.velocity, "m_per_s"),
    ):
        found = by_range(motion, along)
        out[name] = {
            f"middle_{unit}": _list(found.centre),
            "missing_force_n": _list(found.mean),
            "error": _list(found.error),
        }
    return out


def _not_told(joint: NotTold) -> dict[str, Any]:
    return {
        "between": list(joint.between),
        "why": joint.why,
        "force_rms_n": joint.force_rms,
        "displacement_rms_m": joint.displacement_rms,
    }


def _refit(fitted: Refit | None) -> dict[str, Any] | None:
    if fitted is None:
        return None
    return {
        "tests": list(fitted.tests),
        "converged": fitted.converged,
        "error_before": fitted.error_before,
        "error_after": fitted.error_after,
        "parameters": [
            {
                "kind": p.kind, "between": list(p.between), "name": p.name, "before": p.before,
                "value": p.value, "low": p.low, "high": p.high, "unit": p.unit,
                "at_bound": p.at_bound,
            }
            for p in fitted.parameters
        ],
    }  # fmt: skip


def _list(values: FloatArray) -> list[float | None]:
    return [_number(float(value)) for value in values]


def _number(value: float) -> float | None:
    """Return a number that JSON has, or nothing."""
    return value if np.isfinite(value) else None
