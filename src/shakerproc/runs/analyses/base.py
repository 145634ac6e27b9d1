"""Interface of every kind of further analysis."""

from abc import ABC, abstractmethod
from typing import ClassVar, Final

from shakerproc.data import Recording
from shakerproc.runs.analysis import Analysis
from shakerproc.runs.result import RunResult

RINGS: Final = ("free decay", "shock")
"""Kinds of excitation after which a structure is left to itself."""


class AbstractAnalysis(ABC):
    """A kind of analysis that a log may ask for."""

    kind: ClassVar[str]

    @abstractmethod
    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the analysis of a run; None where the log does not ask for it.

        Raises
        ------
        SpectrumError
            If the recording does not allow what the log asks for.
        """
