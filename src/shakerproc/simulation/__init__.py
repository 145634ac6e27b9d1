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
from shakerproc.simulation.response import simulate
from shakerproc.simulation.simulation import CHAOTIC_GROWTH, SENSITIVE_GROWTH, SimulatedResponse
from shakerproc.simulation.window_sensing import has_jumps, is_smooth

__all__ = [
    "CHAOTIC_GROWTH",
    "SENSITIVE_GROWTH",
    "TOLD_APART",
    "FreeRuns",
    "Held",
    "Input",
    "InterpolationError",
    "Runs",
    "SimulatedResponse",
    "free_runs",
    "has_jumps",
    "is_smooth",
    "largest_states",
    "motions_of",
    "prepare",
    "prepare_displacement",
    "simulate",
]
