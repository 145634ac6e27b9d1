"""Response functions as they were measured, between any two channels of a run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.resonances import averaged_share
from shakerproc.runs.result import BoolArray, RunResult, forces_of, shown_ratio
from shakerproc.runs.roles import row_asked_for
from shakerproc.runs.tables import spelled_ratio
from shakerproc.spectra.responses.estimators import audible
from shakerproc.testlog import ResponseFunction

OWN: Final = 0.01
"""Share of a force's power that the others do not explain, below which it is not told apart."""

CONTROLS: Final = "controls"
"""Name that means the mean of the controls."""

NAMES: Final[Mapping[tuple[str, str], str]] = {
    ("m/s^2", "N"): "accelerance",
    ("m/s", "N"): "mobility",
    ("m", "N"): "receptance",
    ("N", "m/s^2"): "apparent mass",
    ("N", "m/s"): "impedance",
    ("N", "m"): "dynamic stiffness",
    ("rad/s^2", "N m"): "rotational accelerance",
    ("rad/s", "N m"): "rotational mobility",
    ("rad", "N m"): "rotational receptance",
    ("N m", "rad"): "rotational dynamic stiffness",
}
"""What a function of these units, output and input, is called (ISO 7626-1)."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ChannelPair:
    """A response function as it was measured, in shown units; `row` is that of the output.

    `cross` has the spectra that it is read from: without what other forces cause.
    """

    label: str
    name: str
    unit: str  # 1 where output and input have the same
    ending: str
    h1: ComplexArray
    h2: ComplexArray
    hv: ComplexArray
    low: FloatArray
    high: FloatArray
    coherence: FloatArray
    excited: BoolArray
    inputs: tuple[int, ...]
    row: int
    output: str
    cross: spectra.CrossSpectra


def functions_of(result: RunResult) -> list[ChannelPair]:
    """Return the response functions that the log asks for, else those over each force.

    Those that the log asks of every test and this run does not have are left out; those over
    each force stand for them.

    Raises
    ------
    SpectrumError
        If it does not have one that is asked of this test itself.
    """
    asked, missing = _asked_of(result)
    if asked and not missing:
        return asked
    return [*asked, *(pair for f in _driving(result) for pair in _against(result, f))]


def _asked_of(result: RunResult) -> tuple[list[ChannelPair], list[str]]:
    """Return the functions that the log asks for and the run has, and why it has not others.

    Raises
    ------
    SpectrumError
        If it does not have one that is asked of this test itself.
    """
    found, missing = [], []
    for one in result.test.processing.response_functions:
        try:
            found.append(_pair(result, result.spectra, *_of_names(result, one)))
        except SpectrumError as error:
            if "response_functions" not in result.test.processing.inherited:
                raise
            missing.append(f"Left out: {one.output} / {one.input}: {error}")
    return found, missing


def told_of_forces(result: RunResult) -> tuple[str, ...]:
    """Return a sentence for each of several forces that cannot be told from the others."""
    asked, missing = _asked_of(result)
    if asked and not missing:
        return ()
    names = [channel.name for channel in result.channels]
    return tuple(
        f"No response function over {names[force]}: {why}."
        for force in _driving(result)
        if (why := _not_apart(result, force))
    )


def functions_left_out(result: RunResult) -> list[str]:
    """Return a sentence for each function that the log asks for and the run does not have."""
    return _asked_of(result)[1]


def _rows(result: RunResult, name: str) -> tuple[int, ...]:
    """Return the rows that a name of the log means.

    Raises
    ------
    SpectrumError
        If there is no such channel, or there are no controls.
    """
    if name == CONTROLS and result.controls:
        return result.controls
    besides = [CONTROLS] * bool(result.controls)
    return (row_asked_for(result.channels, name, "response_functions", besides=besides),)


_Wanted: TypeAlias = tuple[ResponseFunction, tuple[int, ...], int]
"""What a function is called, the rows of its input, and that of its output."""


def _of_names(result: RunResult, wanted: ResponseFunction) -> _Wanted:
    return wanted, _rows(result, wanted.input), _rows(result, wanted.output)[0]


def _driving(result: RunResult) -> tuple[int, ...]:
    """Return the forces that drive the run, none where a control does.

    Controls come first: a force beside them is a response.
    """
    if _decays_once(result):
        return ()
    return tuple(i for i in forces_of(result.channels) if _driven(result, (i,)).any())


def _against(result: RunResult, force: int) -> list[ChannelPair]:
    """Return every response over a force, without what the other forces cause."""
    if _not_apart(result, force):
        return []
    forces, name = forces_of(result.channels), result.channels[force].name
    cross = _without_others(result, force)
    return [
        _pair(result, cross, ResponseFunction(name, channel.name), (force,), i)
        for i, channel in enumerate(result.channels)
        if i not in forces
    ]


def _without_others(result: RunResult, force: int) -> spectra.CrossSpectra:
    others = [i for i in _driving(result) if i != force]
    return spectra.conditioned(result.spectra, others) if others else result.spectra


def _not_apart(result: RunResult, force: int) -> str:
    """Return why a force cannot be told from the others, empty where it can."""
    driving = _driving(result)
    averages = result.spectra.effective_averages
    if len(driving) == 1:
        return ""
    if averages <= len(driving):
        return (
            f"{numeral(averages)} averages do not tell {len(driving)} forces apart; shorten "
            "the "
            "segment (welch: {segment: ...}) or record longer"
        )
    cross = _without_others(result, force)
    if (_driven(result, (force,)) & _own(result, cross, (force,))).any():
        return ""
    names = ", ".join(result.channels[i].name for i in driving if i != force)
    return (
        f"it moves as one with {names}, so that what each causes cannot be told apart; drive "
        "the forces with independent signals, or one at a time"
    )


def _own(result: RunResult, cross: spectra.CrossSpectra, inputs: Sequence[int]) -> BoolArray:
    """Return where the inputs have power of their own."""
    rows = list(inputs)
    own = spectra.psd(cross)[rows].sum(axis=0)
    return np.asarray(own >= OWN * result.psd[rows].sum(axis=0))


def _decays_once(result: RunResult) -> bool:
    """Return whether its spectra are averages over one decay, of which no function is had."""
    return result.test.rings and result.blows is None


def _pair(
    result: RunResult,
    cross: spectra.CrossSpectra,
    wanted: ResponseFunction,
    inputs: tuple[int, ...],
    output: int,
) -> ChannelPair:
    """Return one response function.

    Raises
    ------
    SpectrumError
        If the input does not move within the excited band.
    """
    rows = (inputs, [output])
    of, over = result.channels[output].unit, result.channels[inputs[0]].unit
    unit, factor = shown_ratio(of, over)
    limits, _ = spectra.response_bounds(cross, *rows)
    density = result.psd[list(inputs)].mean(axis=0)
    there = audible(result.spectra.frequency, density, result.band)
    scale = np.where(there, factor, np.nan)
    return ChannelPair(
        label=f"{wanted.output} / {wanted.input}",
        name=NAMES.get((of, over), "response function") if unit else "transmissibility",
        unit=unit or "1",
        ending=spelled_ratio(of, over),
        h1=spectra.h1(cross, *rows)[0] * scale,
        h2=spectra.h2(cross, *rows)[0] * scale,
        hv=spectra.hv(cross, *rows)[0] * scale,
        low=limits.low[0] * scale,
        high=limits.high[0] * scale,
        coherence=averaged_share(cross, spectra.coherence(cross, *rows)[0]),
        excited=_excited(result, inputs, wanted.input) & _own(result, cross, inputs),
        inputs=inputs,
        row=output,
        output=result.channels[output].name,
        cross=cross,
    )


def _excited(result: RunResult, inputs: Sequence[int], name: str) -> BoolArray:
    """Return where the input moves enough within the excited band.

    Raises
    ------
    SpectrumError
        If it does not move at all.
    """
    found = _driven(result, inputs)
    if not found.any():
        low, high = result.band
        raise SpectrumError(
            f"response_functions: {name} does not move within {low:g} to {high:g} Hz; choose "
            "another input"
        )
    return found


def _driven(result: RunResult, inputs: Sequence[int]) -> BoolArray:
    density = result.psd[list(inputs)].mean(axis=0)
    return spectra.driven(result.spectra.frequency, density, result.band)
