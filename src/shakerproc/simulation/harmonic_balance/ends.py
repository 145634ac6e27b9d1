"""Where a followed curve ends, to the point, and why, for people."""

from collections.abc import Callable
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.continuation import Trace, correct
from shakerproc.simulation.harmonic_balance.curves import ForcedCurve
from shakerproc.simulation.harmonic_balance.solve import floats, hardly_touches

LEFT: Final = "left the band"
LOST: Final = "contact lost"
CLOSED: Final = "closed on itself"


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
    found = correct(curve, point, along, curve.weights(before), 1e-9)
    if found is None:
        return trace
    return Trace(np.vstack([trace.points[:-1], found[0]]), trace.tangents, trace.ended)


def _cut_at_contact(balance: HarmonicBalance, curve: ForcedCurve, trace: Trace) -> Trace:
    """Return the trace with its last point moved to where the contact is lost."""
    if not floats(balance, trace.points[-1, :-1], trace.points[-1, -1]):
        return trace
    before, after = trace.points[-2], trace.points[-1]
    weights = curve.weights(before)
    chord = (after - before) * weights
    touching, floating = before, after
    for _ in range(40):
        found = correct(
            curve, 0.5 * (touching + floating), chord / np.linalg.norm(chord), weights, 1e-10
        )
        if found is None:
            break
        if floats(balance, found[0][:-1], found[0][-1]):
            floating = found[0]
        else:
            touching = found[0]
    return Trace(np.vstack([trace.points[:-1], touching]), trace.tangents, trace.ended)
