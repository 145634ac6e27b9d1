"""Regression on the measured motion: where to start, and what need not be tried."""

from shakerproc.diagnosis.screening.outside import FreeLaw, free_laws
from shakerproc.diagnosis.screening.pairs import screen_pairs
from shakerproc.diagnosis.screening.start import (
    Start,
    in_likely_joints,
    known_of,
    widening,
    with_limits,
)
from shakerproc.diagnosis.screening.starts import screen

__all__ = [
    "FreeLaw",
    "Start",
    "free_laws",
    "in_likely_joints",
    "known_of",
    "screen",
    "screen_pairs",
    "widening",
    "with_limits",
]
