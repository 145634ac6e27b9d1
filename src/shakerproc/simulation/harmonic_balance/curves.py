"""Curves that are followed: their equations, a first solution, and where they end."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.continuation import (
    StepSizes,
    Trace,
    correct,
    follow,
)
from shakerproc.simulation.harmonic_balance.laws import PiecewiseLinearLaw

LEFT: Final = "left the band"

LOST: Final = "contact lost"

CLOSED: Final = "closed on itself"


@final
@dataclass(frozen=True, eq=False)
class ForcedCurve:
    """Forced motion against frequency; the last unknown is the base rate [rad/s].

    Attributes
    ----------
    balance : HarmonicBalance
        The equations.
    """

    balance: HarmonicBalance

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual and derivative, both over the size of the load.

        `point` holds coefficients [m] and a rate [rad/s].
        """
        residual = self.balance.residual(point[:-1], point[-1])
        scale = np.linalg.norm(self.balance.load)
        derivative = np.column_stack([residual.jacobian, residual.by_omega])
        return residual.force / scale, derivative / scale

    def weights(self, point: FloatArray) -> FloatArray:
        """Return one over the size of the velocity, and one over the rate.

        `point` holds coefficients [m] and a rate [rad/s].
        """
        return motion_weights(self.balance, point, np.array([1.0 / point[-1]]))


@final
@dataclass(frozen=True, eq=False)
class WayFromLinear:
    """From a linear system to the one wanted; the last unknown goes from 0 to 1.

    Attributes
    ----------
    balance : HarmonicBalance
        The equations.
    omega : float
        Base rate [rad/s].
    """

    balance: HarmonicBalance
    omega: float

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual and derivative, both over the size of the load.

        `point` holds coefficients [m] and a share [-].
        """
        balance, share = self.balance, point[-1]
        residual = balance.residual(point[:-1], self.omega)
        reference = balance.reference_matrix(self.omega)
        linear = reference @ point[:-1] - balance.load
        jacobian = share * residual.jacobian + (1.0 - share) * reference
        scale = np.linalg.norm(balance.load)
        derivative = np.column_stack([jacobian, residual.force - linear])
        return (share * residual.force + (1.0 - share) * linear) / scale, derivative / scale

    def weights(self, point: FloatArray) -> FloatArray:
        """Return one over the size of the velocity, and 1 for the share.

        `point` holds coefficients [m] and a share [-].
        """
        return motion_weights(self.balance, point, np.array([1.0]))


def motion_weights(
    balance: HarmonicBalance, point: FloatArray, others: FloatArray
) -> FloatArray:
    """Return weights in which the velocity amplitude is 1, followed by those of the others.

    `point` holds coefficients [m] and what follows them, `others` one over the unit of that.
    """
    numbers = np.maximum(balance.numbers, 1.0)
    size = np.linalg.norm(numbers * point[: numbers.size])
    return np.concatenate([numbers / max(float(size), 1e-300), others])


def solve_at(balance: HarmonicBalance, frequency: float) -> FloatArray | None:
    """Return a solution at one frequency [Hz], by way of the linear system; None if none.

    Returns
    -------
    (n_unknowns,) array or None
        Coefficients [m].
    """
    omega = 2.0 * np.pi * frequency / balance.order
    way = WayFromLinear(balance, omega)
    reference = balance.reference_matrix(omega)
    linear = np.linalg.lstsq(reference, balance.load)[0]
    towards = np.zeros(linear.size + 1)
    towards[-1] = 1.0
    trace = follow(
        way,
        np.append(linear, 0.0),
        towards,
        lambda _, point: "" if -0.1 < point[-1] < 1.0 else "stopped",
        StepSizes(first=0.1, miss=0.1, turn=0.6, most=300),
    )
    if trace.points[-1, -1] < 1.0:
        return None
    return newton(balance, trace.points[-1, :-1], omega)


def newton(
    balance: HarmonicBalance, guess: FloatArray, omega: float, most: int = 25
) -> FloatArray | None:
    """Return the solution near a guess at a fixed base rate [rad/s]; None if there is none."""
    unknowns = guess
    for _ in range(most):
        residual = balance.residual(unknowns, omega)
        try:
            step = np.linalg.solve(residual.jacobian, -residual.force)
        except np.linalg.LinAlgError:
            return None
        unknowns = unknowns + step
        if np.linalg.norm(step) <= 1e-12 * np.linalg.norm(unknowns):
            return unknowns
    return None


def held(balance: HarmonicBalance) -> bool:
    """Return whether dry friction bears the whole load, so that nothing moves."""
    joints = balance.system.frictions
    if not joints:
        return False
    directions = np.array([joint.direction for joint in joints])
    asked = np.linalg.pinv(directions.T) @ balance.system.load
    rest = balance.system.load - directions.T @ asked
    borne = [
        abs(force) <= joint.law.breakaway_force
        for force, joint in zip(asked, joints, strict=True)
    ]
    return all(borne) and bool(
        np.linalg.norm(rest) <= 1e-12 * np.linalg.norm(balance.system.load)
    )


def floats(balance: HarmonicBalance, unknowns: FloatArray, omega: float) -> bool:
    """Return whether a motion touches nothing that holds it.

    `unknowns` are in [m], `omega` in [rad/s].
    """
    stiffness = balance.system.stiffness.copy()
    touches_nothing = False
    if balance.system.frictions:
        return False
    for coupling, motion in balance.motions(unknowns, omega):
        if coupling.law.varies or coupling.law.switches(motion)[0].size:
            return False
        slope = coupling.law.tangent(motion.samples[0, :1], motion.samples[1, :1])[0][0]
        stiffness += slope * np.outer(coupling.direction, coupling.direction)
        touches_nothing = touches_nothing or slope == 0.0
    if not touches_nothing:
        return False
    values = np.linalg.eigvalsh(stiffness)
    return bool(values[0] <= 1e-12 * max(values[-1], 1e-300))


def hardly_touches(balance: HarmonicBalance, point: FloatArray) -> bool:
    """Return whether a motion that nothing else holds is in contact for hardly any time.

    `point` holds coefficients [m] and a rate [rad/s].
    """
    if np.linalg.eigvalsh(balance.system.stiffness)[0] > 0.0:
        return False
    shares = []
    for coupling, motion in balance.motions(point[:-1], point[-1]):
        if isinstance(coupling.law, PiecewiseLinearLaw):
            displacement, velocity = motion.sampled(4096)
            shares.append(np.mean(coupling.law.tangent(displacement, velocity)[0] != 0.0))
    return bool(shares) and max(shares) < 0.05


def limits(
    curve: ForcedCurve, start: FloatArray, band: tuple[float, float]
) -> Callable[[FloatArray, FloatArray], str]:
    """Return the conditions on which a curve from a start ends.

    Parameters
    ----------
    curve : ForcedCurve
        The equations.
    start : (n_unknowns + 1,) array
        First point [m, and the unit of the last unknown].
    band : tuple of float
        Frequencies of the excitation [Hz].
    """
    balance = curve.balance
    low, high = (2.0 * np.pi / balance.order * frequency for frequency in band)
    weights = curve.weights(start)
    towards: list[FloatArray] = []

    def stop(before: FloatArray, point: FloatArray) -> str:
        if not low <= point[-1] <= high:
            return LEFT
        if floats(balance, point[:-1], point[-1]):
            return LOST
        if not towards:
            towards.append((point - start) * weights)
            return ""
        ahead, behind = ((at - start) * weights for at in (point, before))
        near = np.linalg.norm(ahead) < 0.5
        return CLOSED if near and towards[0] @ behind < 0.0 <= towards[0] @ ahead else ""

    return stop


def end_of_trace(
    curve: ForcedCurve, trace: Trace, band: tuple[float, float]
) -> tuple[Trace, str]:
    """Return the trace up to its very end, and why it ends there, for people.

    Parameters
    ----------
    curve : ForcedCurve
        The equations.
    trace : Trace
        What was followed.
    band : tuple of float
        Frequencies of the excitation [Hz].
    """
    balance = curve.balance
    in_hz = balance.order / (2.0 * np.pi)
    if trace.ended == LEFT:
        trace = _cut(curve, trace, (band[0] / in_hz, band[1] / in_hz))
        return trace, f"reached {trace.points[-1, -1] * in_hz:.6g} Hz, an end of the band"
    if trace.ended == LOST or hardly_touches(balance, trace.points[-1]):
        trace = _cut_at_contact(balance, curve, trace)
        return trace, (
            f"{LOST} at {trace.points[-1, -1] * in_hz:.6g} Hz: beyond it the motion "
            f"stays inside the clearance and nothing holds the mass"
        )
    return trace, f"{trace.ended} at {trace.points[-1, -1] * in_hz:.6g} Hz"


def _cut(curve: ForcedCurve, trace: Trace, band: tuple[float, float]) -> Trace:
    """Return the trace with its last point moved to the end of the band."""
    before, after = trace.points[-2], trace.points[-1]
    limit = band[1] if after[-1] > band[1] else band[0]
    point = before + (after - before) * (limit - before[-1]) / (after[-1] - before[-1])
    along = np.zeros(point.size)
    along[-1] = 1.0
    corrected = correct(curve, point, along, curve.weights(before), 1e-9)
    if corrected is None:
        return trace
    return Trace(np.vstack([trace.points[:-1], corrected[0]]), trace.tangents, trace.ended)


def _cut_at_contact(balance: HarmonicBalance, curve: ForcedCurve, trace: Trace) -> Trace:
    """Return the trace with its last point moved to where the contact is lost."""
    if not floats(balance, trace.points[-1, :-1], trace.points[-1, -1]):
        return trace
    before, after = trace.points[-2], trace.points[-1]
    weights = curve.weights(before)
    chord = (after - before) * weights
    touching, floating = before, after
    for _ in range(40):
        corrected = correct(
            curve, 0.5 * (touching + floating), chord / np.linalg.norm(chord), weights, 1e-10
        )
        if corrected is None:
            break
        if floats(balance, corrected[0][:-1], corrected[0][-1]):
            floating = corrected[0]
        else:
            touching = corrected[0]
    return Trace(np.vstack([trace.points[:-1], touching]), trace.tangents, trace.ended)
