"""Force laws in harmonic coefficients, one in each file."""

from shakerproc.simulation.harmonic_balance.laws.base import (
    AbstractLaw,
    HarmonicMotion,
    LawBalance,
)
from shakerproc.simulation.harmonic_balance.laws.contact_damping import ContactDampingLaw
from shakerproc.simulation.harmonic_balance.laws.hysteretic import HystereticLaw
from shakerproc.simulation.harmonic_balance.laws.piecewise_linear import PiecewiseLinearLaw
from shakerproc.simulation.harmonic_balance.laws.smooth import SmoothLaw

__all__ = [
    "AbstractLaw",
    "ContactDampingLaw",
    "HarmonicMotion",
    "HystereticLaw",
    "LawBalance",
    "PiecewiseLinearLaw",
    "SmoothLaw",
]
