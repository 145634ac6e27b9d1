"""Response functions between any two channels of a run, and their resolved peaks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.averaging import FinerSpectra
from shakerproc.runs.result import (
    BoolArray,
    ResonancePeak,
    Responses,
    RunResult,
    forces_of,
    shown_ratio,
)
from shakerproc.runs.roles import row_asked_for
from shakerproc.runs.tables import spelled_ratio
from shakerproc.spectra import CrossSpectra, Damping, Peak, SpectralLine
from shakerproc.spectra.responses import NOTCH_BINS, audible, driven, excited
from shakerproc.testlog import ResponseFunction, Test

SINGLE_FREQUENCY: Final = ("sine",)
"""Kinds of excitation that reach one frequency only."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Where peaks are looked for; `finer` gives spectra of longer segments, if any."""

    spectra: CrossSpectra
    test: Test
    band: tuple[float, float]
    finer: FinerSpectra | None
    lines: tuple[SpectralLine, ...]  # tones of the control, which are no resonances

    @property
    def one_frequency(self) -> bool:
        """Whether the table moves at one frequency at a time, and bands mean nothing."""
        return self.test.excitation in SINGLE_FREQUENCY

    def valid(self, control: FloatArray) -> BoolArray:
        """Return which frequencies are excited, given the density of the mean control.

        `control` is a density [unit²/Hz].
        """
        frequency = self.spectra.frequency
        there = driven(frequency, control, self.judged)
        return there if there.any() else excited(frequency, self.judged)

    @property
    def judged(self) -> tuple[float, float]:
        """Where controls and responses can be compared [Hz]: the band, or near the tone."""
        if self.one_frequency and self.test.frequency_hz is not None:
            reach = NOTCH_BINS * self.spectra.bin_width
            return max(0.0, self.test.frequency_hz - reach), self.test.frequency_hz + reach
        return self.band

    def peaks(self, values: FloatArray, errors: FloatArray | None) -> tuple[Peak, ...]:
        """Return the peaks of a spectrum that chance does not make, tallest first.

        `values` are in any unit, `errors` shares of them [-].
        """
        wanted = self.test.processing.peaks
        return spectra.find_peaks(
            self.spectra.frequency,
            values,
            self.band,
            distance=wanted.distance,
            count=wanted.count if errors is not None else 1,
            errors=errors,
        )


def against_controls(
    search: Search, controls: Sequence[int], responses: Sequence[int]
) -> Responses | None:
    """Return the response functions against the controls; None where one side is missing."""
    if not controls or not responses:
        return None
    cross = search.spectra
    density = spectra.psd(cross)[list(controls)].mean(axis=0)
    there = audible(cross.frequency, density, search.judged)
    return Responses(
        h1=np.where(there, spectra.h1(cross, controls, responses), np.nan),
        h2=np.where(there, spectra.h2(cross, controls, responses), np.nan),
        hv=np.where(there, spectra.hv(cross, controls, responses), np.nan),
        psd_ratio=np.where(there, spectra.psd_ratio(cross, controls, responses), np.nan),
        coherence=averaged_share(cross, spectra.coherence(cross, controls, responses)),
        multiple_coherence=averaged_share(
            cross, spectra.multiple_coherence(cross, controls, responses)
        ),
        valid=search.valid(density),
    )


def averaged_share(cross: CrossSpectra, coherence: FloatArray) -> FloatArray:
    """Return a coherence [-]; of one average, whose quotient is always 1, not a number."""
    return coherence if cross.effective_averages > 1.0 else np.full_like(coherence, np.nan)


def density_peaks(
    search: Search, density: FloatArray, against: Responses | None, responses: Sequence[int]
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of the density of every channel; damping only without an input.

    `density` is in the units of the channels, squared, over [Hz].
    """
    row_of = {channel: row for row, channel in enumerate(responses)} if against else {}
    resonance_peaks = []
    for i, values in enumerate(density):
        coherence = against.coherence[row_of[i]] if against and i in row_of else None
        elsewhere = against is not None or search.one_frequency
        read = None if elsewhere else _reader_of_density(search, i)
        averages = search.spectra.effective_averages
        chance = np.full(values.shape, averages**-0.5) if averages > 1.0 else None
        if search.lines and i in responses:
            clear = spectra.clear_of_lines(search.spectra, search.lines, i)
            peaks = search.peaks(spectra.masked(values, clear), chance)
        else:
            peaks = search.peaks(values, chance) or search.peaks(values, None)
        resonance_peaks.append(_read(search, values, peaks, coherence, read))
    return tuple(resonance_peaks)


def response_peaks(
    search: Search,
    against: Responses | None,
    controls: Sequence[int],
    responses: Sequence[int],
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of |H1| of every response, none for the controls."""
    rows: list[tuple[ResonancePeak, ...]] = [()] * (len(controls) + len(responses))
    if against is not None and not search.one_frequency:
        for row, channel in enumerate(responses):
            clear = spectra.clear_of_lines(search.spectra, search.lines, channel)
            gain = spectra.masked(np.abs(against.h1[row]), against.valid & clear)
            chance = spectra.gain_random_error(
                np.clip(against.coherence[row], 0.0, 1.0), search.spectra.effective_averages
            )
            known = chance if np.isfinite(chance).any() else None
            read = None if known is None else _reader_of_response(search, controls, channel)
            peaks = search.peaks(gain, known)
            rows[channel] = _read(search, gain**2, peaks, against.coherence[row], read)
    return tuple(rows)


Reader: TypeAlias = Callable[[float], Damping]


def _reader_of_density(search: Search, channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_density(
            cross, channel, frequency, search.band
        ),
    )


def _reader_of_response(search: Search, controls: Sequence[int], channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_response(
            cross, controls, channel, frequency, search.band
        ),
    )


def _resolved(search: Search, read: Callable[[CrossSpectra, float], Damping]) -> Reader:
    """Return a reader of damping that looks again with longer segments where they may help."""

    def reader(frequency: float) -> Damping:
        first, finer = read(search.spectra, frequency), search.finer
        if finer is None or not spectra.longer_may_resolve(
            search.spectra, first, finer.bin_width
        ):
            return first
        second = read(finer.make(), frequency)
        return first if second.ratio is None else second

    return reader


def _read(
    search: Search,
    power: FloatArray,
    peaks: Sequence[Peak],
    coherence: FloatArray | None,
    read: Reader | None,
) -> tuple[ResonancePeak, ...]:
    """Return peaks with the coherence there and their damping."""
    return tuple(
        ResonancePeak(
            peak,
            None if read is None else read(peak.frequency),
            None if coherence is None else float(coherence[peak.index]),
            spectra.is_resolved(search.spectra, power, peak.index),
        )
        for peak in peaks
    )


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
    asked, missing = [], []
    for one in result.test.processing.response_functions:
        try:
            asked.append(_pair(result, result.spectra, *_of_names(result, one)))
        except SpectrumError as error:
            if "response_functions" not in result.test.processing.inherited:
                raise
            missing.append(f"Left out: {one.output} / {one.input}: {error}")
    return asked, missing


def force_remarks(result: RunResult) -> tuple[str, ...]:
    """Return a sentence for each of several forces that cannot be told from the others."""
    asked, missing = _asked_of(result)
    if asked and not missing:
        return ()
    names = [channel.name for channel in result.channels]
    return tuple(
        f"No response function over {names[force]}: {why}."
        for force in _driving(result)
        if (why := _dependence(result, force))
    )


def missing_functions(result: RunResult) -> list[str]:
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
    """Return every response over a force, without the parts of the other forces."""
    if _dependence(result, force):
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


def _dependence(result: RunResult, force: int) -> str:
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
    if (_driven(result, (force,)) & _independent_power(result, cross, (force,))).any():
        return ""
    names = ", ".join(result.channels[i].name for i in driving if i != force)
    return (
        f"it moves as one with {names}, so that what each causes cannot be told apart. Drive "
        "the forces with independent signals, or one at a time"
    )


def _independent_power(
    result: RunResult, cross: spectra.CrossSpectra, inputs: Sequence[int]
) -> BoolArray:
    """Return where the inputs have power of their own."""
    rows = list(inputs)
    power = spectra.psd(cross)[rows].sum(axis=0)
    return np.asarray(power >= OWN * result.averages.psd[rows].sum(axis=0))


def _decays_once(result: RunResult) -> bool:
    """Return whether its spectra are averages over one decay, of which no function is had."""
    return result.test.rings and result.over_time.blows is None


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
    density = result.averages.psd[list(inputs)].mean(axis=0)
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
        excited=_excited(result, inputs, wanted.input)
        & _independent_power(result, cross, inputs),
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
    mask = _driven(result, inputs)
    if not mask.any():
        low, high = result.band
        raise SpectrumError(
            f"response_functions: {name} does not move within {low:g} to {high:g} Hz; choose "
            "another input"
        )
    return mask


def _driven(result: RunResult, inputs: Sequence[int]) -> BoolArray:
    density = result.averages.psd[list(inputs)].mean(axis=0)
    return spectra.driven(result.spectra.frequency, density, result.band)
