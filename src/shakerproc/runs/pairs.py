"""Response functions as they were measured, between any two channels of a run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.runs.result import BoolArray, RunResult, lone_force, shown_ratio
from shakerproc.runs.roles import row_named
from shakerproc.runs.tables import spelled_ratio
from shakerproc.testlog import ResponseFunction

CONTROLS: Final = "controls"
"""Name that means the mean of the controls."""

NAMES: Final[Mapping[tuple[str, str], str]] = {
    ("m/s^2", "N"): "accelerance",
    ("m/s", "N"): "mobility",
    ("m", "N"): "receptance",
    ("N", "m/s^2"): "apparent mass",
    ("N", "m/s"): "impedance",
    ("N", "m"): "dynamic stiffness",
}
"""What a function of these units, output and input, is called (ISO 7626-1)."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """A response function as it was measured, in shown units; `row` is that of the output."""

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


def functions_of(result: RunResult) -> list[Pair]:
    """Return the response functions that the log asks for, else those over the lone force.

    Raises
    ------
    SpectrumError
        If the log asks for one that the run does not have.
    """
    asked = result.test.processing.response_functions
    wanted = [_of_names(result, one) for one in asked] or _against_force(result)
    return [_pair(result, *one) for one in wanted]


def _rows(result: RunResult, name: str) -> tuple[int, ...]:
    """Return the rows that a name of the log means.

    Raises
    ------
    SpectrumError
        If there is no such channel, or there are no controls.
    """
    if name == CONTROLS and result.controls:
        return result.controls
    row = row_named(result.channels, name)
    if row is not None:
        return (row,)
    there = ", ".join([c.name for c in result.channels] + [CONTROLS] * bool(result.controls))
    raise SpectrumError(
        f"response_functions: no channel {name!r}; the run has {there}. Name one of them"
    )


_Wanted: TypeAlias = tuple[ResponseFunction, tuple[int, ...], int]
"""What a function is called, the rows of its input, and that of its output."""


def _of_names(result: RunResult, wanted: ResponseFunction) -> _Wanted:
    return wanted, _rows(result, wanted.input), _rows(result, wanted.output)[0]


def _against_force(result: RunResult) -> list[_Wanted]:
    """Return every response over the force that drives the run, empty where none does.

    Controls come first: a force beside them is a response. Several forces are no input of
    functions between two channels, for they may depend on each other.
    """
    force = lone_force(result.channels)
    if force is None or _decays_once(result) or not _driven(result, (force,)).any():
        return []
    name = result.channels[force].name
    return [
        (ResponseFunction(name, channel.name), (force,), i)
        for i, channel in enumerate(result.channels)
        if i != force
    ]


def _decays_once(result: RunResult) -> bool:
    """Return whether its spectra are averages over one decay, of which no function is had."""
    return result.test.rings and result.blows is None


def _pair(
    result: RunResult, wanted: ResponseFunction, inputs: tuple[int, ...], output: int
) -> Pair:
    """Return one response function.

    Raises
    ------
    SpectrumError
        If the input does not move within the excited band.
    """
    cross, rows = result.spectra, (inputs, [output])
    of, over = result.channels[output].unit, result.channels[inputs[0]].unit
    unit, factor = shown_ratio(of, over)
    low, high = _limits(cross, *rows)
    return Pair(
        label=f"{wanted.output} / {wanted.input}",
        name=NAMES.get((of, over), "response function") if unit else "transmissibility",
        unit=unit or "1",
        ending=spelled_ratio(of, over),
        h1=spectra.h1(cross, *rows)[0] * factor,
        h2=spectra.h2(cross, *rows)[0] * factor,
        hv=spectra.hv(cross, *rows)[0] * factor,
        low=low * factor,
        high=high * factor,
        coherence=spectra.coherence(cross, *rows)[0],
        excited=_excited(result, inputs, wanted.input),
        inputs=inputs,
        row=output,
        output=result.channels[output].name,
    )


def _limits(
    cross: spectra.CrossSpectra, inputs: Sequence[int], outputs: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """Return the 95 % limits of a gain; of one average there are none."""
    if cross.effective_averages <= 1.0:
        unknown = np.full(cross.frequency.shape, np.nan)
        return unknown, unknown
    bounds, _ = spectra.response_bounds(cross, inputs, outputs)
    return bounds.low[0], bounds.high[0]


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
