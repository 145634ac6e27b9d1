"""The nudge of a motion towards a measured one, at a sample, and what it does to the laws."""

from typing import NamedTuple

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.modes import follow, series_slip, start
from shakerproc.simulation.kernels.motion import (
    accelerate,
    between,
    mobility,
    push,
    settle,
    sticks,
)
from shakerproc.simulation.kernels.table import (
    FRICTION,
    HOLDING,
    IWAN,
    JENKINS,
    LAW,
    MEMORY,
    SERIES,
    Machine,
    Series,
)


class Nudges(NamedTuple):
    """How the motion of a test is nudged, after every sample.

    Attributes
    ----------
    measured : (n_samples, m) array
        What the motion is held to: m combinations of displacements [m] and velocities [m/s]. No
        column, and the run is free.
    sees : (m, 2 n) array
        The same combinations of the model's displacements and velocities.
    gain : (2 n, m) array
        How far a difference moves each displacement and velocity.
    lead : int
        Samples of a window after which it is let go.
    apart : (m,) array
        Room for the differences.
    """

    measured: FloatArray
    sees: FloatArray
    gain: FloatArray
    lead: int
    apart: FloatArray


@inlined
def held_until(nudges: Nudges, first: int) -> int:
    """Return the last sample at which a window that begins at `first` is nudged."""
    return first + nudges.lead if nudges.measured.shape[1] > 0 else first


@inner
def nudge(
    machine: Machine, nudges: Nudges, sample: int, time: float, period: float, series: Series
) -> None:
    """Move the motion in order 0 towards what was measured at a sample.

    The input at this instant stands in order 0 of `w`; `period` is that of the samples [s].
    """
    n, n_lines = machine.mass.size, machine.lines.shape[0]
    held = False
    for row in range(n_lines):
        held = held or sticks(machine, row)
    if held:  # what the joints that stick carry before
        accelerate(machine, time, 0.0, 0, series)
    for i in range(nudges.apart.size):
        total = nudges.measured[sample, i]
        for k in range(2 * n):
            total -= nudges.sees[i, k] * series.y[k, 0]
        nudges.apart[i] = total
    for k in range(2 * n):
        for i in range(nudges.apart.size):
            series.y[k, 0] += nudges.gain[k, i] * nudges.apart[i]
    for row in range(n_lines):
        _go_on(machine, row, period, series)
    if held:
        settle(machine, time, series)


@inlined
def _go_on(machine: Machine, row: int, period: float, series: Series) -> None:
    """Set the branch of a line whose motion was changed, its memory being what it was."""
    n, law, mode = machine.mass.size, machine.lines[row, LAW], machine.mode[row, 0]
    displacement = between(machine, row, series.y, 0, 0)
    velocity = between(machine, row, series.y, n, 0)
    direction = 1 if velocity >= 0.0 else -1
    if law == FRICTION:
        if mode != 0 or not _resists(machine, row, velocity, period, series):
            machine.mode[row, 0] = direction
    elif law == JENKINS:
        if mode * direction < 0:
            machine.mode[row, 0] = 0
    elif law == IWAN:
        if mode * direction < 0:
            follow(machine, row, 0, displacement)
    elif law == SERIES and (mode == 2 or mode == -2):
        slips = 0.5 * mode * velocity >= series_slip(machine, row)
        machine.mode[row, 0] = mode if slips else mode // 2
    else:
        memory = machine.lines[row, MEMORY]
        state = series.y[2 * n + memory, 0] if memory >= 0 else 0.0
        start(machine, row, displacement, velocity, state)


@inlined
def _resists(
    machine: Machine, row: int, velocity: float, period: float, series: Series
) -> bool:
    """Return whether a joint that sticks takes a nudge up, and if so take it away.

    It acts like a force over the sample that follows, on top of what the joint carries.
    """
    easy = mobility(machine, row, row)
    if velocity == 0.0 or easy == 0.0:
        return velocity == 0.0
    impulse = velocity / easy
    if abs(series.lines[row, HOLDING, 0] + impulse / period) > machine.values[row, 1]:
        return False
    push(machine, row, impulse, series.y, machine.mass.size, 0)
    return True
