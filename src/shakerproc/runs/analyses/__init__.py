"""Further analyses of a run that the log asks for: one file a kind, one mapping."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.late import loaded
from shakerproc.numerals import numeral
from shakerproc.runs.pairs import missing_functions
from shakerproc.runs.panels import Analysis
from shakerproc.runs.result import RunResult
from shakerproc.spectra.response_spectra import HIGHEST, logarithmic_frequencies

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


@final
@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of analysis, loaded for the runs that may have it: most have none.

    Attributes
    ----------
    name : str
        Class in the module that is called as the kind.
    wanted : callable
        Whether a run may have one.
    of_spectra : bool
        Whether it is made of the spectra, from which tones of a sine on random are taken out.
    """

    name: str
    wanted: Callable[[RunResult], bool]
    of_spectra: bool = False


def _is_wanted(kind: str) -> Callable[[RunResult], bool]:
    return lambda result: getattr(result.test.processing, kind) is not None


def _over_a_force(result: RunResult) -> bool:
    asked = bool(result.test.processing.response_functions)
    return asked or any(channel.role == "force" for channel in result.channels)


ANALYSES: Final[Mapping[str, _Kind]] = MappingProxyType({
    "profile": _Kind(
        "ProfileJudgement", lambda result: result.test.profile is not None, of_spectra=True
    ),
    "tones": _Kind(
        "ToneAnalysis", lambda result: result.over_time.tones is not None, of_spectra=True
    ),
    "blows": _Kind(
        "BlowAnalysis", lambda result: result.over_time.blows is not None, of_spectra=True
    ),
    "response_functions": _Kind("ResponseFunctionAnalysis", _over_a_force, of_spectra=True),
    "resonances": _Kind("ResonanceAnalysis", _over_a_force, of_spectra=True),
    "driving_point": _Kind("DrivingPointAnalysis", _over_a_force),
    "decays": _Kind("DecayAnalysis", lambda result: result.test.excitation in RINGS),
    "multisine": _Kind(
        "MultisineAnalysis", lambda result: result.test.excitation == "multisine"
    ),
    "integration": _Kind("IntegrationAnalysis", _is_wanted("integration")),
    "octaves": _Kind("OctaveAnalysis", _is_wanted("octaves")),
    "distribution": _Kind("DistributionAnalysis", _is_wanted("distribution")),
    "orders": _Kind("OrderAnalysis", lambda result: result.over_time.shaft is not None),
    "dwell": _Kind("DwellAnalysis", _is_wanted("dwell")),
    "waterfall": _Kind("WaterfallAnalysis", _is_wanted("waterfall")),
    "splitting": _Kind("SplittingAnalysis", _is_wanted("splitting")),
    "shock": _Kind("ShockAnalysis", _is_wanted("shock")),
    "fatigue": _Kind("FatigueAnalysis", _is_wanted("fatigue")),
    "uncertainty": _Kind(
        "UncertaintyAnalysis", lambda result: result.test.processing.uncertainty
    ),
})
"""Every kind by its key in the log, in the order of the report; each sees those before it."""


def with_analyses(recording: Recording, result: RunResult) -> RunResult:
    """Return a result with the analyses that the log asks for.

    What the log asks of every test and this recording does not allow is left out, and a note
    says which and why.

    Raises
    ------
    SpectrumError
        If the recording does not allow what is asked of this test itself.
    """
    analyses: list[Analysis] = []
    notes = [*result.notes, *missing_functions(result)]
    for kind, one in ANALYSES.items():
        if not one.wanted(result):
            continue
        try:
            analysis = _analysis(kind).of(recording, replace(result, analyses=tuple(analyses)))
        except SpectrumError as error:
            if kind not in result.test.processing.inherited:
                raise
            notes.append(f"Left out: {error}")
        else:
            analyses += [] if analysis is None else [analysis]
    if result.over_time.tones is not None:
        notes.append(_with_tones(analyses))
    return replace(result, analyses=tuple(analyses), notes=tuple(notes))


def _with_tones(analyses: Sequence[Analysis]) -> str:
    """Return the sentence on numbers that include the tones of a sine on random."""
    whole = [one.title for one in analyses if not ANALYSES[one.kind].of_spectra]
    names = ", ".join(["Rms", "largest value", "crest factor", "kurtosis", *whole])
    return (
        f"{names} and what is drawn over time are of the whole signal, tones and all; rms in "
        "band is without them."
    )


def _analysis(kind: str) -> AbstractAnalysis:
    made = loaded(f"{__name__}.{kind}:{ANALYSES[kind].name}")
    analysis: AbstractAnalysis = made()
    return analysis


def accelerations(result: RunResult, kind: str) -> list[int]:
    """Return the rows that are accelerations.

    Raises
    ------
    SpectrumError
        If there are none.
    """
    rows = [i for i, channel in enumerate(result.channels) if channel.unit == "m/s^2"]
    if not rows:
        raise SpectrumError(
            f"{kind}: no channel measures an acceleration; take {kind}: out of processing, or "
            "correct the units of the channels"
        )
    return rows


def natural_frequencies(
    result: RunResult, ends: tuple[float | None, float | None], per_octave: int, kind: str
) -> FloatArray:
    """Return natural frequencies of oscillators from the log's ends, or the data's.

    `ends` are frequencies [Hz].

    Raises
    ------
    SpectrumError
        If they reach beyond a tenth of the sample rate, or do not rise.
    """
    most = HIGHEST * result.recorded.sample_rate
    longest = result.recorded.sample_rate / result.crop.n_samples
    low = longest if ends[0] is None else ends[0]
    high = most if ends[1] is None else ends[1]
    if high > most * (1.0 + 1e-9):
        raise SpectrumError(
            f"{kind}: to is {high:g} Hz, above a tenth of the sample rate of "
            f"{result.recorded.sample_rate:g} Hz, where the samples do not show the peaks any "
            f"more. Give to: {numeral(0.999 * most, 4)} Hz or less, or record faster"
        )
    if not low < high:
        raise SpectrumError(
            f"{kind}: from {low:g} Hz does not lie below to, {high:g} Hz; correct the log"
        )
    return logarithmic_frequencies(low, high, per_octave)


def offset_free(
    recording: Recording, result: RunResult, rows: Sequence[int]
) -> Iterator[FloatArray]:
    """Return the samples of the run in blocks, without the mean where the log detrends."""
    offset = np.zeros((len(rows), 1))
    if result.test.processing.detrend != "none":
        offset = result.averages.statistics.mean[list(rows), np.newaxis]
    for block in recording.blocks(result.crop.start, result.crop.stop):
        yield block - offset
