"""Play, spring, slider and damper in series, with one state."""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.table import NONE, STATE, VELOCITY, Machine


@inlined
def elements_in_series(
    machine: Machine, row: int, order: int, lines: FloatArray
) -> tuple[float, float]:
    """Return the force, and the rate of the extension of spring and play together."""
    mode, v = machine.mode[row, 0], lines[row, VELOCITY, order]
    if mode == 0:
        return 0.0, v
    if mode == 2 or mode == -2:
        return (0.5 * mode * machine.values[row, 3] if order == 0 else 0.0), 0.0
    beyond = lines[row, STATE, order]
    if order == 0:
        beyond -= machine.values[row, 1] if mode == 1 else -machine.values[row, 2]
    force = machine.values[row, 0] * beyond
    return force, v - machine.values[row, 4] * force


@inlined
def event_in_series(machine: Machine, row: int, which: int) -> tuple[int, float, float]:
    """Return an event as `event` does; branches: open 0, closed +-1, slipping +-2."""
    mode = machine.mode[row, 0]
    if mode == 0:
        return STATE, 1.0 - 2.0 * which, machine.values[row, 1 + which]
    side = 1.0 if mode > 0 else -1.0
    if mode == 2 or mode == -2:
        return (VELOCITY if which == 0 else NONE), -side, -series_slip(machine, row)
    if which == 0:
        return STATE, side, series_limit(machine, row, side)
    return STATE, -side, -(machine.values[row, 1] if mode > 0 else machine.values[row, 2])


@inlined
def start_in_series(machine: Machine, row: int, state: float) -> int:
    """Return the branch that the extension of spring and play tells: open, or closed."""
    if state > machine.values[row, 1]:
        return 1
    return -1 if -state > machine.values[row, 2] else 0


@inlined
def after_in_series(machine: Machine, row: int, which: int) -> int:
    """Return the branch after the event `which`."""
    mode = machine.mode[row, 0]
    if mode == 0:
        return 1 - 2 * which
    if mode == 2 or mode == -2:
        return mode // 2
    if which == 0:
        return 2 * mode
    return 0 if machine.values[row, 1] + machine.values[row, 2] > 0.0 else -mode


@inlined
def series_limit(machine: Machine, row: int, side: float) -> float:
    """Return the extension of play and spring at which the slider of a series slips [m]."""
    play = machine.values[row, 1] if side > 0.0 else machine.values[row, 2]
    return play + machine.values[row, 3] / machine.values[row, 0]


@inlined
def series_slip(machine: Machine, row: int) -> float:
    """Return the velocity below which the slider of a series, at its force, stands [m/s]."""
    return machine.values[row, 3] * machine.values[row, 4]
