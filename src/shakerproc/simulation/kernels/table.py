"""Tables of the compiled steppers: the linear part, the laws, their branches.

Everything is kept in a few plain arrays that are indexed and never sliced: numba compiles
that several times faster than it does array expressions, and it runs faster too.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.laws import Law

DRIFT: Final = int(Law.DRIFT)
STOP: Final = int(Law.STOP)
JUMP: Final = int(Law.JUMP)
CONTACT_DAMPING: Final = int(Law.CONTACT_DAMPING)
ODD_POWER: Final = int(Law.ODD_POWER)
EVEN_POWER: Final = int(Law.EVEN_POWER)
POWER_DAMPING: Final = int(Law.POWER_DAMPING)
QUADRATIC_DAMPING: Final = int(Law.QUADRATIC_DAMPING)
FRICTION: Final = int(Law.FRICTION)
LUGRE: Final = int(Law.LUGRE)
JENKINS: Final = int(Law.JENKINS)
IWAN: Final = int(Law.IWAN)
BOUC_WEN: Final = int(Law.BOUC_WEN)
CONSTANT: Final = int(Law.CONSTANT)
SERIES: Final = int(Law.SERIES)
TABLE: Final = int(Law.TABLE)
HERTZ: Final = int(Law.HERTZ)

LAW: Final = 0  # columns of `lines`
MEMORY: Final = 1

NOBODY: Final = -2
NONE: Final = -1  # a quantity that no event watches

NO_CURVE: Final = -1.0
"""Where the numbers of a curve start, for a line that has none."""

STACK: Final = 512
"""Turning points that an Iwan line remembers before it forgets the smallest loop."""


class Machine(NamedTuple):
    """A model, and the branch that each of its laws is on.

    Attributes
    ----------
    mass : (n,) array
        Mass of each coordinate [kg]; 1 for a mode whose shape is mass-normalised.
    matrix : (n, 2 n + 1) array
        Accelerations for unit displacements, velocities and input, linear part alone.
    lines : (r, 2) array of int
        Law of each line, and the index of its state among all states, or -1.
    joints : (r, n) array
        Relative displacement of each line by unit displacements: what its second place has
        more than its first.
    pushes : (r, n) array
        Accelerations that a unit force of each line takes away, 0 where the motion is
        imposed [1/kg].
    values : (r, 6) array
        Numbers of each law.
    mode : (r, 2) array of int
        Branch of each line: 0 open or sticking, 1 closed, 2 parting without force, a
        direction, or the region of a table (see `laws.table`); and how many turning points an
        Iwan line remembers. Written to.
    anchor : (r, 4) array
        Where the branch of an Iwan line starts (displacement, force), where it ends, and its
        scale. Written to.
    stack : (r, 2, STACK) array
        Displacement and force of its turning points. Written to.
    tables : (any,) array
        Numbers of all tabulated laws and curves, one after the other (see `tabulated` and
        `laws.curve_back`).
    reads : int
        Mass whose motion is imposed, the force for which is read; or NOBODY.
    reading : (1, 2 n + 1) array
        That force by unit displacements, velocities and input, linear part alone; without
        rows where nothing is read.
    """

    mass: FloatArray
    matrix: FloatArray
    lines: NDArray[np.int64]
    joints: FloatArray
    pushes: FloatArray
    values: FloatArray
    mode: NDArray[np.int64]
    anchor: FloatArray
    stack: FloatArray
    tables: FloatArray
    reads: int
    reading: FloatArray


class Store(NamedTuple):
    """Propagators and events of every combination of branches of a piecewise-linear model.

    Here y is the (n_y,) motion, w the input, and c its (degree + 1,) coefficients over a part
    of a sample.

    Attributes
    ----------
    slot_of : (3^r,) array of int
        Where a combination stands, by its code (a base-3 number of the branches plus 1).
    parts, part : (s,) array of int, and of float
        Into how many parts a sample is cut, and their length [s].
    n_events : (s,) array of int
        How many events can end the combination.
    which : (s, 2 r, 2) array of int
        Line and number of each event.
    system : (s, n_y + 1, n_y + 2) array
        Rates of y, by (y, w, 1); in the last row the force that is read.
    events : (s, 2 r, n_y + 2 + m) array
        Events, by (y, w, 1, carried forces): above 0 once they have happened.
    slopes : (s, 2 r, n_y + 2 + m) array
        How much events rise in a part at this rate, by the same; the rise of the input and of
        the forces themselves is left out.
    step : (s, n_y, n_y + degree + 2 + 6 m) array
        What a part adds to y, by (y, c, 1) and the six coefficients of each carried force.
    force_of : (r,) array of int
        Number of each line among the m whose law is not linear on its branches: its force is
        given to the propagators as a quintic over a part. -1 for all others.
    owner : (n_states,) array of int
        Number of the carried force whose state each is, or -1.
    push : (s, n + 1, m) array
        Accelerations by unit carried forces; in the last row the force that is read.
    """

    slot_of: NDArray[np.int64]
    parts: NDArray[np.int64]
    part: FloatArray
    n_events: NDArray[np.int64]
    which: NDArray[np.int64]
    system: FloatArray
    events: FloatArray
    slopes: FloatArray
    step: FloatArray
    force_of: NDArray[np.int64]
    owner: NDArray[np.int64]
    push: FloatArray


FORCE_TERMS: Final = 6
"""Coefficients of a carried force over a part of a sample: it is a quintic."""


HIGHEST: Final = 24
"""Highest order of a Taylor series."""

DISPLACEMENT: Final = 0  # planes of `lines` in MotionSeries, and quantities that events watch
VELOCITY: Final = 1
HOLDING: Final = 2  # the force that keeps a sticking line at rest
STATE: Final = 3
BASE: Final = 4  # the first of the planes that a law may use as it likes
PLANES: Final = 20


class MotionSeries(NamedTuple):
    """Taylor coefficients over a step, in powers of the share of it that has passed.

    Attributes
    ----------
    y : (2 n + n_states, orders) array
        Displacements, velocities and states.
    a : (n or n + 1, orders) array
        Accelerations, and the force that is read.
    w : (orders,) array
        Input.
    lines : (r, PLANES, orders) array
        Displacement, velocity, holding force and state of each line, and room for its law.
    system, stuck : (r, r + 1) array and (r,) array of int
        Room for the joints that stick.
    """

    y: FloatArray
    a: FloatArray
    w: FloatArray
    lines: FloatArray
    system: FloatArray
    stuck: NDArray[np.int64]


def room_for_series(machine: Machine, n_states: int) -> MotionSeries:
    """Return empty series."""
    n, n_lines = machine.mass.size, len(machine.lines)
    orders = HIGHEST + 2
    return MotionSeries(
        np.zeros((2 * n + n_states, orders)),
        np.zeros((n + len(machine.reading), orders)),
        np.zeros(orders),
        np.zeros((n_lines, PLANES, orders)),
        np.zeros((n_lines, n_lines + 1)),
        np.zeros(n_lines, np.int64),
    )
