"""Mistakes in a model or a log that no effect explains, seen before a long search."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.comparison.comparison import exchanged
from shakerproc.comparison.errors import Pair, pair_of
from shakerproc.comparison.joints import JointMotion, joint_motions
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.prediction import Prediction, predict
from shakerproc.data import ComplexArray
from shakerproc.errors import DiagnosisError, SimulationError
from shakerproc.models import Model
from shakerproc.models.effects.spring import Spring

MOST_TESTS: Final = 4
"""Tests that are looked at: a mistake in model or roles is in each, and seen in half [-]."""

MOST_SAMPLES: Final = 2**14
"""Samples of each that are looked at: sixteen usual segments [-]."""

SLIP: Final = 100.0
"""Measured over modelled force, or its inverse, above which a unit is wrong: the middle of ten,
which a missing contact makes, and a thousand, between units and their multiples [-]."""

TURNED: Final = 0.1
"""Rms of response plus control over the response below which one is the other turned round:
the transverse sensitivity of two accelerometers is less [-]."""


def check_plausible(model: Model, tests: Sequence[Measured]) -> None:
    """Pass a model and tests that a search for an effect can be begun with.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of Measured
        What is to be explained; the beginnings of a few of them are looked at.

    Raises
    ------
    DiagnosisError
        If controls and responses are exchanged, a response is the control turned round, or a
        joint's force is wrong by more than a missing effect makes it.
    """
    if model.excitation.role is None or model.excitation.imposed:
        return
    count = min(len(tests), MOST_TESTS)
    chosen = [_beginning(tests[i * len(tests) // count]) for i in range(count)]
    found = [_doubt(model, test) for test in chosen]
    if 2 * sum(any(doubt) for doubt in found) >= count:
        # exchanged channels look like a wrong unit as well
        kinds = zip(*found, strict=True)
        raise DiagnosisError(next(text for kind in kinds for text in kind if text))


def _beginning(test: Measured) -> Measured:
    """Return the first judged samples of a test."""
    stop = min(test.stop, test.start + MOST_SAMPLES)
    return replace(
        test, controls=test.controls[:, :stop], responses=test.responses[:, :stop], stop=stop
    )


def _doubt(model: Model, test: Measured) -> tuple[str, str]:
    """Return what is wrong with the roles in a test and with the model's units, or nothing."""
    try:
        prediction = predict(model, test)
    except SimulationError:  # the search says so of all tests
        return "", ""
    pair = pair_of(prediction)
    roles = [_turned(model, prediction, pair), *exchanged(model, [(prediction, pair)])]
    units: list[str] = []
    if not _is_rigid(model, pair.h1[:, pair.excited]):  # a joint that holds is a verdict
        units += [_slipped(test, model, joint) for joint in joint_motions(model, test)[0]]
    return next(filter(None, roles), ""), next(filter(None, units), "")


def _is_rigid(model: Model, h1: ComplexArray) -> bool:
    """Return whether a sensor moves with the base: its joint holds."""
    if not model.excitation.moves_base:
        return False
    return bool(np.any(np.median(np.abs(h1 - 1.0), axis=1) < TURNED))


def _slipped(test: Measured, model: Model, joint: JointMotion) -> str:
    """Return that a joint's force is out of all proportion, if it is.

    Both the force and what of it goes with the displacement: a damper hides a soft spring.
    """
    columns = np.array([joint.displacement, joint.velocity]).T
    scale = np.sqrt(np.sum(columns**2, axis=0))
    forces = np.array([joint.force, joint.force_model]).T
    if not (np.all(scale > 0.0) and np.all(forces.any(axis=0))):
        return ""
    stiff = np.linalg.lstsq(columns / scale, forces, rcond=None)[0][0]
    ratios = [float(np.sqrt(np.sum(joint.force**2) / np.sum(joint.force_model**2)))]
    springs = [e for e in model.elements if isinstance(e.effect, Spring)]
    if any(set(e.between) == set(joint.between) for e in springs) and np.all(stiff > 0.0):
        ratios.append(float(stiff[0] / stiff[1]))
    wrong = [ratio for ratio in ratios if not 1.0 / SLIP <= ratio <= SLIP]
    if not wrong:
        return ""
    return (
        f"{test.run}: the measured force between {' and '.join(joint.between)} is "
        f"{wrong[0]:.2g} times that of {model.title} over the same motion. Correct the unit of "
        "mass or stiffness in the model, or sensitivities and roles in the log."
    )


def _turned(model: Model, prediction: Prediction, pair: Pair) -> str:
    """Return that a response is the control with the other sign, if it is."""
    if not model.excitation.moves_base:
        return ""
    for i, name in enumerate(prediction.measured.sensors):
        if model.sensors[name].measures != "acceleration":
            continue
        response = prediction.response[i]
        left = np.sqrt(np.mean((response + prediction.input) ** 2) / np.mean(response**2))
        rigid = _is_rigid(model, pair.h1_model[i : i + 1, pair.excited])
        if left < TURNED and not rigid:
            return (
                f"{prediction.measured.run}: {name} is the control turned round, to "
                f"{left:.0%} of its rms, which no structure does. Check cables and roles."
            )
    return ""
