"""Further analyses of a run that the log asks for: one file a kind, one mapping."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from shakerproc.data import Recording
from shakerproc.runs.analyses.base import AbstractAnalysis
from shakerproc.runs.analyses.blows import BlowAnalysis
from shakerproc.runs.analyses.decays import DecayAnalysis
from shakerproc.runs.analyses.distribution import DistributionAnalysis
from shakerproc.runs.analyses.driving_point import DrivingPointAnalysis
from shakerproc.runs.analyses.fatigue import FatigueAnalysis
from shakerproc.runs.analyses.integration import IntegrationAnalysis
from shakerproc.runs.analyses.multisine import MultisineAnalysis
from shakerproc.runs.analyses.octaves import OctaveAnalysis
from shakerproc.runs.analyses.orders import OrderAnalysis
from shakerproc.runs.analyses.profile import ProfileJudgement
from shakerproc.runs.analyses.resonances import ResonanceAnalysis
from shakerproc.runs.analyses.response_functions import ResponseFunctionAnalysis
from shakerproc.runs.analyses.shock import ShockAnalysis
from shakerproc.runs.analyses.splitting import SplittingAnalysis
from shakerproc.runs.analyses.waterfall import WaterfallAnalysis
from shakerproc.runs.analysis import Analysis
from shakerproc.runs.result import RunResult

__all__ = ["ANALYSES", "analyses_of"]

_KINDS: Final = (
    ProfileJudgement(),
    BlowAnalysis(),
    ResponseFunctionAnalysis(),
    ResonanceAnalysis(),
    DrivingPointAnalysis(),
    DecayAnalysis(),
    MultisineAnalysis(),
    IntegrationAnalysis(),
    OctaveAnalysis(),
    DistributionAnalysis(),
    OrderAnalysis(),
    WaterfallAnalysis(),
    SplittingAnalysis(),
    ShockAnalysis(),
    FatigueAnalysis(),
)

ANALYSES: Final[Mapping[str, AbstractAnalysis]] = MappingProxyType({
    analysis.kind: analysis for analysis in _KINDS
})
"""Every kind by its key in the log, in the order of the report."""


def analyses_of(recording: Recording, result: RunResult) -> tuple[Analysis, ...]:
    """Return the analyses that the log asks for.

    Raises
    ------
    SpectrumError
        If the recording does not allow one.
    """
    found = (analysis.of(recording, result) for analysis in ANALYSES.values())
    return tuple(one for one in found if one is not None)
