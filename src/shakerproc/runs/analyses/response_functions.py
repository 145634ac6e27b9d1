"""Response functions between any two channels, with their unit and what they are called."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import ComplexArray, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.runs.analyses.base import AbstractAnalysis
from shakerproc.runs.analysis import Analysis, Cell, Line, Panel, Scale
from shakerproc.runs.result import BoolArray, RunResult, lone_force, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.testlog import ResponseFunction

CONTROLS: Final = "controls"
"""Name that means the mean of the controls."""

AUDIBLE: Final = 1e-4
"""Share of the largest density of the input in the band below which nothing is read [-]."""

DRAWN: Final = 8
"""Response functions that are drawn without being asked for: two rows of a page [-]."""

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


@final
class ResponseFunctionAnalysis(AbstractAnalysis):
    """Response functions between the channels that the log names, or against the force."""

    kind: ClassVar[str] = "response_functions"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the response functions of a run."""
        del recording  # its spectra are those of the result
        pairs, asked = functions_of(result), result.test.processing.response_functions
        if not pairs:
            return None
        frequency = result.spectra.frequency
        drawn = pairs if asked else pairs[:DRAWN]
        rest = "" if len(drawn) == len(pairs) else (
            f" (the first {DRAWN} of {len(pairs)} are drawn, all are in the table; "
            "response_functions in the log names others)"
        )  # fmt: skip
        return Analysis(
            kind=self.kind,
            title=f"Response functions{rest}",
            columns=_columns(frequency, pairs),
            summary=tuple(_row(frequency, pair) for pair in pairs),
            panels=(
                *(
                    panel
                    for i, pair in enumerate(drawn, 1)
                    for panel in _panels(frequency, pair, f"response_functions_{i}")
                ),
                _coherence(frequency, drawn),
            ),
        )


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
    for i, channel in enumerate(result.channels):
        if name in {channel.name, channel.source_name}:
            return (i,)
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
    if force is None or not _moves(result, (force,)):
        return []
    name = result.channels[force].name
    return [
        (ResponseFunction(name, channel.name), (force,), i)
        for i, channel in enumerate(result.channels)
        if i != force
    ]


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
    (out_unit, out_factor), (in_unit, in_factor) = shown_unit(of), shown_unit(over)
    factor = out_factor / in_factor
    low, high = _limits(cross, *rows)
    same = of == over
    return Pair(
        label=f"{wanted.output} / {wanted.input}",
        name="transmissibility" if same else NAMES.get((of, over), "response function"),
        unit="1" if same else f"{out_unit}/{in_unit}",
        ending="" if same else f"{spelled(out_unit)}_per{spelled(in_unit)}",
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
    if not _moves(result, inputs):
        low, high = result.band
        raise SpectrumError(
            f"response_functions: {name} does not move within {low:g} to {high:g} Hz; choose "
            "another input"
        )
    inside, density = _in_band(result), result.psd[list(inputs)].mean(axis=0)
    return np.array(inside & (density > AUDIBLE * density[inside].max()))


def _moves(result: RunResult, inputs: Sequence[int]) -> bool:
    return bool((result.psd[list(inputs)].mean(axis=0)[_in_band(result)] > 0.0).any())


def _in_band(result: RunResult) -> BoolArray:
    frequency, (low, high) = result.spectra.frequency, result.band
    return np.array((frequency >= low) & (frequency <= high))


def _columns(frequency: FloatArray, pairs: Sequence[Pair]) -> dict[str, FloatArray | BoolArray]:
    columns: dict[str, FloatArray | BoolArray] = {"frequency_hz": frequency}
    for pair in pairs:
        name = pair.label.replace(" / ", "_over_")
        columns[f"h1_{name}_magnitude{pair.ending}"] = np.abs(pair.h1)
        columns[f"h1_{name}_low{pair.ending}"] = pair.low
        columns[f"h1_{name}_high{pair.ending}"] = pair.high
        columns[f"h1_{name}_phase_deg"] = np.degrees(np.angle(pair.h1))
        columns[f"h2_{name}_magnitude{pair.ending}"] = np.abs(pair.h2)
        columns[f"h2_{name}_phase_deg"] = np.degrees(np.angle(pair.h2))
        columns[f"hv_{name}_magnitude{pair.ending}"] = np.abs(pair.hv)
        columns[f"hv_{name}_phase_deg"] = np.degrees(np.angle(pair.hv))
        columns[f"coherence_{name}"] = pair.coherence
        columns[f"excited_{name}"] = pair.excited
    return columns


def _row(frequency: FloatArray, pair: Pair) -> dict[str, Cell]:
    gain = np.where(pair.excited, np.abs(pair.h1), -np.inf)
    peak = int(np.argmax(gain))
    known = pair.coherence[pair.excited & np.isfinite(pair.coherence)]
    return {
        "function": pair.label,
        "name": pair.name,
        "unit": pair.unit,
        "largest": float(gain[peak]),
        "at_hz": float(frequency[peak]),
        "coherence_there": float(pair.coherence[peak]),
        "mean_coherence": float(known.mean()) if known.size else None,
    }


def _panels(frequency: FloatArray, pair: Pair, name: str) -> list[Panel]:
    """Return gain, phase and locus."""
    shown = np.flatnonzero(pair.excited)
    part = slice(int(shown[0]), int(shown[-1]) + 1)
    h1 = np.where(pair.excited, pair.h1, np.nan + 0j)[part]
    x, title = frequency[part], f"{pair.label}, {pair.name}"
    limits = [
        Line(label, x, np.where(pair.excited, values, np.nan)[part], look="paper")
        for label, values in (("", pair.low), ("", pair.high))
    ]
    by_frequency, unit = Scale("frequency [Hz]"), "-" if pair.unit == "1" else pair.unit
    phase = np.degrees(np.angle(h1))
    phase = np.where(np.abs(np.diff(phase, prepend=phase[:1])) > 180.0, np.nan, phase)
    return [
        Panel(
            f"{name}_gain", f"|H1| of {title}", "Grey: its 95 % limits.", by_frequency,
            Scale(f"|H1| [{unit}]"),
            (*limits, Line(pair.label, x, np.abs(h1), channel=pair.output)),
        ),
        Panel(
            f"{name}_phase", f"Phase of {title}", "Of H1; output after input.", by_frequency,
            Scale("phase [°]", logarithmic=False),
            (Line(pair.label, x, phase, channel=pair.output),),
        ),
        Panel(
            f"{name}_nyquist", f"Nyquist plot of {title}", "A resonance is a circle.",
            Scale(f"real part [{unit}]", logarithmic=False),
            Scale(f"imaginary part [{unit}]", logarithmic=False),
            (Line(pair.label, h1.real, h1.imag, channel=pair.output),), equal=True,
        ),
    ]  # fmt: skip


def _coherence(frequency: FloatArray, pairs: Sequence[Pair]) -> Panel:
    shown = np.flatnonzero(np.any([pair.excited for pair in pairs], axis=0))
    part = slice(int(shown[0]), int(shown[-1]) + 1)
    return Panel(
        "response_functions_coherence", "Coherence of the response functions",
        "1: all of the output is a linear answer to the input, without noise.",
        Scale("frequency [Hz]"), Scale("coherence [-]", logarithmic=False, ends=(0.0, 1.02)),
        tuple(
            Line(
                pair.label,
                frequency[part],
                np.where(pair.excited, pair.coherence, np.nan)[part],
                channel=pair.output,
            )
            for pair in pairs
        ),
    )  # fmt: skip
