"""A model and an excitation in, the response out: exact, Taylor, DOP853, harmonic balance."""

from shakerproc.simulation.free_runs import (
    TOLD_APART,
    FreeRuns,
    Held,
    Runs,
    free_runs,
    largest_states,
    motions_of,
)
from shakerproc.simulation.inputs import Input, prepare, prepare_displacement
from shakerproc.simulation.pieces import InterpolationError
from shakerproc.simulation.response import SENSITIVE_GROWTH, SimulatedResponse, simulate
from shakerproc.simulation.window_sensing import has_jumps, is_smooth
