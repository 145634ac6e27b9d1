"""Single solutions: the way to a first one, and whether it touches anything."""

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.continuation import StepSizes, follow
from shakerproc.simulation.harmonic_balance.curves import WayFromLinear
from shakerproc.simulation.harmonic_balance.laws import PiecewiseLinearLaw


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
        found = balance.residual(unknowns, omega)
        try:
            step = np.linalg.solve(found.jacobian, -found.force)
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
