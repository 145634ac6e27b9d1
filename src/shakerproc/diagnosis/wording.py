"""The sentences of a diagnosis."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.joint_outcomes import Locked
from shakerproc.diagnosis.result import Errors, Finding, Where
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE
from shakerproc.diagnosis.selection.where import PARTS
from shakerproc.models.motion import Motion, shown_in
from shakerproc.numerals import numeral

CALIBRATED: Final = f"; sensors are calibrated to no better than {NEGLIGIBLE:.0%}"
"""Why what is left beyond noise may be nothing."""


def outside_sentence(
    table: float, least: float, floor: float, meanwhile: Sequence[Finding], errors: Errors
) -> str:
    """Return the verdict that no effect of the library will do.

    Parameters
    ----------
    table, least, floor : float
        What a force without a name leaves, the best of all others, and noise [-].
    meanwhile : sequence of Finding
        Effects that are a gain all the same; their `errors` before and after.
    errors : Errors
        With them.
    """
    said = (
        "Something is missing that is not in the library: a free force over displacement and "
        f"velocity leaves {numeral(table)} of the response, the best law {numeral(least)}, "
        f"noise {_noise(floor)}."
    )
    if not meanwhile:
        return said
    return f"{said} Meanwhile, add {_effects(meanwhile)}: {_fall(errors)}."


def found_sentence(
    effects: Sequence[Finding],
    faults: Sequence[Finding],
    errors: Errors,
    alike: Sequence[str],
) -> str:
    """Return the verdict that effects were found."""
    doubt = f"; {', or '.join(alike)} would predict these tests as well" if alike else ""
    beside = f"; besides, the measurement has a {_faults(faults)}" if faults else ""
    return f"The model lacks {_effects(effects)}: {_fall(errors)}{doubt}{beside}."


def more_sentence(errors: Errors, left: Where, motion: Motion) -> str:
    """Return that more is missing than what was found, and where what is left lies.

    Parameters
    ----------
    errors : Errors
        With what was found.
    left : Where
        Where that fails.
    motion : Motion
        Units of its ranges.
    """
    after, floor = errors.among.held_out.after, errors.among.noise_floor
    noise = f"the noise is {_noise(floor)}"
    where = [f"at {numeral(low)} to {numeral(high)} Hz" for low, high in left.bands_hz]
    where += _range("displacements", left.displacement_m, "m", motion)
    where += _range("velocities", left.velocity_m_per_s, "m/s", motion)
    most = f" Most of it lies {', '.join(where)}." if where else ""
    said = f"More is missing: {numeral(after)} is left, {noise}.{most}"
    if not math.isfinite(floor):
        said = f"It leaves {numeral(after)}; how much of that is noise these tests do not say."
    elif after <= NEGLIGIBLE:
        said = f"It leaves {numeral(after)}, {noise}{CALIBRATED}."
    return _judged(errors, said)


def noise_sentences(errors: Errors) -> list[str]:
    """Return that only noise is left as candidates are judged, where that is another number."""
    own = errors.among
    said = f"{numeral(own.held_out.after)} is left, the noise is {_noise(own.noise_floor)}."
    return [told for told in (_judged(errors, said),) if told != said]


def _range(
    of: str, span: tuple[float, float] | tuple[()], unit: str, motion: Motion
) -> list[str]:
    """Return a range of motion [m or m/s] in words; nothing where it begins at the smallest."""
    if not span or PARTS * span[0] <= span[1]:
        return []
    shown, times = shown_in(unit, motion, span[1])
    return [
        f"at {of} of {numeral(times * span[0], 2)} to {numeral(times * span[1], 2)} {shown}"
    ]


def fault_sentence(faults: Sequence[Finding], errors: Errors, *, alone: bool) -> str:
    """Return the verdict that the measurement is at fault, alone or before all else."""
    physics = "; no physics is missing" if alone else ""
    return f"The measurement has a {_faults(faults)}{physics}: {_fall(errors)}."


def nothing_sentence(errors: Errors, which: str, *, complete: bool) -> str:
    """Return the verdict that nothing is missing, by `which` model; only noise, if complete."""
    own, beyond = errors.among, "" if complete else CALIBRATED
    said = (
        f"Nothing is missing: {which} leaves {numeral(own.held_out.after)} of the response, "
        f"the noise is {_noise(own.noise_floor)}{beyond}."
    )
    if abs(own.held_out.after - errors.held_out.after) <= NEGLIGIBLE:
        return said
    return (
        f"{said} As `compare` runs whole tests, with perfect sensors and no further modes, "
        f"{numeral(errors.held_out.after)} is left."
    )


def unnamed_sentence(errors: Errors, which: str, least: tuple[str, float]) -> str:
    """Return the verdict that something may be missing, but that no effect is sure.

    Parameters
    ----------
    errors : Errors
        Of the model that stands.
    which : str
        What that is.
    least : (str, float)
        Name of what leaves least of all that was tried, and what it leaves [-].
    """
    after, floor = errors.held_out.after, errors.noise_floor
    said = f"Nothing can be named: {which} leaves {numeral(after)} of the response"
    if math.isfinite(floor):
        said += f", though the noise is {numeral(floor)}."
    else:
        said += (
            ". How much of that is noise these tests do not say: record some seconds at rest "
            "before the excitation, or repeat a test."
        )
    name, left = least[0], numeral(least[1])
    if least[1] < after and left != numeral(after):
        said += f" The best that was tried, {name}, leaves {left}: less, but not surely so."
    return said


def locked_sentence(locked: Sequence[Locked]) -> str:
    """Return the verdict that a joint never slipped."""
    joints = " and ".join(
        f"the joint between {' and '.join(joint.between)} never slipped and holds at least "
        f"{numeral(joint.holds)} {joint.unit}"
        for joint in locked
    )
    return f"These tests cannot tell one law of friction from another: {joints}."


def far_sentence(far: Mapping[str, tuple[float, Estimate]]) -> str:
    """Return the verdict that numbers of the model explain the tests which are not its own."""
    numbers = " and ".join(
        f"{name} {numeral(ratio)} times the model's ({numeral(value.value)} {value.unit})"
        for name, (ratio, value) in far.items()
    )
    return (
        f"The model explains these tests only with {numbers}. Check the units in the model "
        "file; a joint that dry friction holds most of the time looks like this, too: then "
        "test at a higher level."
    )


def unexercised_sentence(clearance: float, reach: float, motion: Motion) -> str:
    """Return the verdict that a clearance [m] of the log was never closed: its reach [m]."""
    shown, times = shown_in("m", motion, clearance)
    return (
        f"The joint has a clearance of {numeral(times * clearance)} {shown} but moved "
        f"{numeral(times * reach)} {shown} at most: it never closed. "
        f"{numeral(clearance / reach, 2)} times the level would close it."
    )


def further_note(kinds: Sequence[str], now: float, then: float) -> str:
    """Return that another effect would lower the error [-], and can be added next."""
    name = " and ".join(kind.replace("_", " ") for kind in kinds)
    return (
        f"{name} would lower the held-out free-run error from {numeral(now)} to "
        f"{numeral(then)}. It can be added next."
    )


def whole_note(was: float, now: float, horizon: float) -> str:
    """Return that whole tests are predicted worse [-], though parts [s] of them better."""
    return (
        f"Parts of {numeral(horizon)} s are predicted better; simulated from rest as a whole, "
        f"as `compare` does where it can, the tests leave {numeral(now)} of the response, "
        f"{numeral(was)} before."
    )


def own_note(weights: FloatArray, drift: FloatArray, left: float) -> str:
    """Return the numbers of each test alone, for which the errors allow.

    Parameters
    ----------
    weights : (n,) array
        Of the controls in what drives the model; one where they do not disagree [-].
    drift : (2, n_tests) array
        By how much springs are stiffer in each test and get stiffer while it runs, if any [-].
    left : float
        Error if all tests are taken as alike [-].
    """
    said = []
    if len(weights) > 1:
        shares = " and ".join(numeral(weight, 2) for weight in weights)
        said.append(
            "The controls disagree as on a table that rocks: what drives the model is their "
            f"sum with weights {shares}, in the order of the log."
        )
    if len(drift):
        level, change = drift
        said.append(
            "Springs are not equally stiff in every test: their stiffness is off the fitted "
            f"one by {level.min():+.2%} to {level.max():+.2%} in the middle of a test, and "
            f"changes by up to {np.max(np.abs(change)):.2%} while one runs."
        )
    said.append(
        "The errors allow for that; with all tests alike and the mean of the controls, as "
        f"`compare` has it, {numeral(left)} of the response is left."
    )
    return " ".join(said)


def unnamed_note(left: float, floor: float) -> str:
    """Return that besides a fault more is left [-] than the noise [-], which has no name."""
    return (
        f"Corrected for that, the model still leaves {numeral(left)} of the response where the "
        f"noise is {_noise(floor)}, which no effect of the library explains."
    )


def doubted_note(faults: Sequence[Finding]) -> str:
    """Return which faults a model that lacks a force would have: they may stand for it."""
    return (
        f"The model would ask for a {_faults(faults)}; as it leaves more than noise, that may "
        "stand for what is missing, and is not named as a fault."
    )


def _effects(effects: Sequence[Finding]) -> str:
    return " and ".join(
        f"{e.kind.replace('_', ' ')} between {' and '.join(e.between)}{_scaled(e)}"
        for e in effects
    )


def _scaled(effect: Finding) -> str:
    return "" if effect.scaled_by is None else f", scaled by {effect.scaled_by.condition}"


def _faults(faults: Sequence[Finding]) -> str:
    return " and ".join(f"{f.kind.replace('_', ' ')} of {f.between[0]}" for f in faults)


def _noise(floor: float) -> str:
    return numeral(floor) if math.isfinite(floor) else "unknown"


def _judged(errors: Errors, said: str) -> str:
    """Return a sentence on how candidates are judged, with how where it is another number."""
    own = errors.among
    if abs(own.held_out.after - errors.held_out.after) <= NEGLIGIBLE:
        return said
    fitted = "With gains and delays of sensors, further modes and what each test has fitted"
    how = f"Judged {numeral(own.ahead_s[0], 2)} s ahead" if own.ahead_s else fitted
    return f"{how}: {said[0].lower()}{said[1:]}"


def _fall(errors: Errors) -> str:
    held = errors.held_out
    span = f"from {numeral(held.before)} to {numeral(held.after)}"
    if held.after >= held.before:
        return f"its error falls as candidates are judged, but not in free runs: {span}"
    fall = f"the held-out free-run error falls {span}"
    alone = min(errors.without or held.before, held.before)
    own = numeral(alone) != numeral(held.before)
    return f"{fall} ({numeral(alone)} with no effect)" if own else fall
