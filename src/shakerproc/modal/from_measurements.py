"""The tests of a log, and the response functions of an analyser's files, modally analysed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc import spectra
from shakerproc.data import Channel, FloatArray
from shakerproc.errors import ShakerprocError, SpectrumError
from shakerproc.modal.analysis import (
    Functions,
    ModalAnalysis,
    TestModes,
    common,
    reciprocals_of,
    tracks_of,
)
from shakerproc.modal.gathering import (
    DEFAULT_BAND,
    Gathered,
    check_joint_fit,
    gather,
    remarks_of,
    shared_inputs,
)
from shakerproc.modal.identification import identify_functions, identify_records
from shakerproc.modal.modal_model import ModalFit, ModeSet, Settings, response_functions
from shakerproc.modal.output_only import identify_output_only
from shakerproc.modal.struck import identify_blows
from shakerproc.recordings.response_functions import SAME_LINE, ResponseFunctions
from shakerproc.testlog import Modal, Test, TestLog

SHOWN_SEGMENTS: Final = 8
"""Segments without overlap of which measured response functions are averages."""

MOST_SEGMENT: Final = 2**15
"""Samples of such a segment at most."""

Records: TypeAlias = Sequence[tuple[FloatArray, FloatArray]]
"""Inputs and responses of each record, (n_channels, n_samples) arrays."""


def cross_of(records: Records, sample_rate: float) -> spectra.CrossSpectra:
    """Return the spectra of inputs, then responses, of which functions are drawn.

    Parameters
    ----------
    records : sequence of (array, array)
        Inputs and responses of each record [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    """
    shortest = min(inputs.shape[1] for inputs, _ in records)
    return _pooled(records, sample_rate, _segment(shortest))


def _pooled(records: Records, sample_rate: float, segment: int) -> spectra.CrossSpectra:
    """Return spectra over the segments of all records."""
    averaged = [
        spectra.cross_spectra(
            np.concatenate(record),
            sample_rate,
            segment=segment,
            window="periodic hann",
            detrend="mean",
            inputs=range(len(record[0])),
        )
        for record in records
    ]
    counts = [one.n_segments for one in averaged]
    matrix = np.average([one.matrix for one in averaged], axis=0, weights=counts)
    density = np.average([one.density for one in averaged], axis=0, weights=counts)
    return replace(
        averaged[0],
        matrix=np.asarray(matrix, dtype=np.complex128),
        density=np.asarray(density, dtype=np.float64),
        n_segments=sum(counts),
    )


def _segment(n_samples: int) -> int:
    most = min(n_samples // SHOWN_SEGMENTS, MOST_SEGMENT)
    return max(8, 1 << max(most.bit_length() - 1, 3))


def functions_of(
    cross: spectra.CrossSpectra, records: Records, band: tuple[float, float], modes: ModeSet
) -> Functions | None:
    """Return response functions, measured and synthesised through the same window.

    Parameters
    ----------
    cross : CrossSpectra
        Of inputs, then responses, from `cross_of`.
    records : sequence of (array, array)
        Inputs and responses of each record [unit of the channel].
    band : (float, float)
        Limits [Hz].
    modes : ModeSet
        With their model; None is returned where there is none.
    """
    if modes.model is None:
        return None
    n_inputs = records[0][0].shape[0]
    rows = range(n_inputs, cross.n_channels)
    answers = [
        (inputs, _answer(inputs, cross.sample_rate, band, modes.model)) for inputs, _ in records
    ]
    model = _pooled(answers, cross.sample_rate, cross.segment)
    edge = 2.0 * cross.bin_width  # where the window mixes in what lies outside the band
    shown = (cross.frequency >= band[0] + edge) & (cross.frequency <= band[1] - edge)
    driven = range(n_inputs)
    return Functions(
        cross.frequency[shown],
        spectra.h1_of_inputs(cross, driven, rows)[..., shown],
        spectra.h1_of_inputs(model, driven, rows)[..., shown],
        spectra.multiple_coherence(cross, driven, rows)[..., shown],
    )


def _answer(
    inputs: FloatArray, sample_rate: float, band: tuple[float, float], model: ModalFit
) -> FloatArray:
    """Return the response of the model to the inputs within the band."""
    frequency = scipy.fft.rfftfreq(inputs.shape[1], 1.0 / sample_rate)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    n_responses = model.residues.shape[1]
    synthesis = np.zeros((n_responses, frequency.size), dtype=np.complex128)
    synthesis[:, inside] = np.einsum(
        "oif,if->of",
        response_functions(model, frequency[inside]),
        scipy.fft.rfft(inputs)[:, inside],
    )
    return np.asarray(scipy.fft.irfft(synthesis, inputs.shape[1]))


def density_of(
    cross: spectra.CrossSpectra, n_inputs: int, band: tuple[float, float]
) -> FloatArray:
    """Return frequencies [Hz], then densities of the responses [unit²/Hz], as rows."""
    shown = (cross.frequency >= band[0]) & (cross.frequency <= band[1])
    return np.concatenate([
        cross.frequency[np.newaxis, shown],
        spectra.psd(cross)[n_inputs:, shown],
    ])


def analyse_log(
    log: TestLog,
    tests: Sequence[Test],
    wish: Modal,
    *,
    against: tuple[TestLog, Sequence[Test]] | None = None,
    progress: Callable[[str], None] = lambda _name: None,
) -> ModalAnalysis:
    """Return the modes of tests, followed from test to test.

    Parameters
    ----------
    log : TestLog
        The log.
    tests : sequence of Test
        Those of its tests to analyse.
    wish : Modal
        How; by default ``log.modal``.
    against : (TestLog, sequence of Test), optional
        A second log to compare with, analysed in its own way.
    progress : callable
        Is told the name of each test when it is done.

    Returns
    -------
    ModalAnalysis
        Tests that fail are listed with the reason, and cost none of the others.
    """
    jobs = _jobs(log, tests, wish, "")
    if against is not None:
        other, more = against
        jobs += _jobs(other, more, other.modal, f"{other.path.stem}:")
    modes: list[TestModes] = []
    failed: list[tuple[str, str]] = []
    for owner, group, wanted, name in jobs:
        try:
            modes.append(replace(analyse_joint(owner, group, wanted), name=name))
        except ShakerprocError as error:
            failed.append((name, str(error)))
        for test in group:
            progress(str(test.id))
    tracks = tracks_of([one.modes for one in modes], [one.sensor_names for one in modes])
    pairs = reciprocals_of(modes)
    notes = (*_unequal(modes), *(pair.problem for pair in pairs if pair.problem))
    return ModalAnalysis(log.title, tuple(modes), tracks, tuple(failed), notes, pairs)


def _jobs(
    log: TestLog, tests: Sequence[Test], wish: Modal, prefix: str
) -> list[tuple[TestLog, Sequence[Test], Modal, str]]:
    """Return which tests go into which fit, and its name."""
    groups = [tests] if wish.together and len(tests) > 1 else [[test] for test in tests]
    return [
        (log, group, wish, prefix + " + ".join(str(test.id) for test in group))
        for group in groups
    ]


def _unequal(tests: Sequence[TestModes]) -> tuple[str, ...]:
    """Return a sentence where tests have not the same sensors."""
    notes = []
    for one in tests[1:]:
        first = tests[0]
        mine, _ = common(first.sensor_names, one.sensor_names)
        if len(mine) < max(len(first.sensors), len(one.sensors)):
            shared = ", ".join(first.sensors[i].name for i in mine) or "none"
            notes.append(
                f"tests {first.name} and {one.name} have not the same sensors: shapes are "
                f"compared over those in common ({shared}); give channels the same name to "
                "compare more"
            )
    return tuple(notes)


def analyse_test(log: TestLog, test: Test, wish: Modal) -> TestModes:
    """Return the modes of one test.

    Parameters
    ----------
    log : TestLog
        The log.
    test : Test
        One of its tests.
    wish : Modal
        How modes are looked for.

    Raises
    ------
    SpectrumError
        If the recording does not allow it.
    """
    return analyse_joint(log, [test], wish)


def analyse_joint(log: TestLog, tests: Sequence[Test], wish: Modal) -> TestModes:
    """Return the modes that tests share, in one fit.

    Parameters
    ----------
    log : TestLog
        The log.
    tests : sequence of Test
        With the same sensors; forces may act elsewhere in each.
    wish : Modal
        How modes are looked for.

    Raises
    ------
    SpectrumError
        If a recording does not allow it, or no one fit can hold the tests.
    """
    taken = [gather(log, test, wish) for test in tests]
    check_joint_fit(taken)
    names, units, places, inputs = shared_inputs(taken)
    band = (max(one.band[0] for one in taken), min(one.band[1] for one in taken))
    settings = Settings(band, wish.modes, wish.order, wish.keep)
    try:
        modes, cross, functions = _identified(taken, inputs, settings)
    except ValueError as error:
        raise SpectrumError(f"{', '.join(one.run for one in taken)}: {error}") from error
    first = taken[0]
    remarks = remarks_of(
        first.sensors,
        first.positions,
        modes,
        incomplete=any(one.incomplete for one in taken),
        wireframe=first.test.geometry,
    )
    return TestModes(
        name=" + ".join(str(test.id) for test in tests),
        test=first.test,
        sensors=first.sensors,
        positions=first.positions,
        directions=first.directions,
        inputs=names,
        input_units=units,
        input_places=places,
        band=band,
        modes=modes,
        functions=functions,
        density=density_of(cross, cross.n_channels - len(first.sensors), band),
        unexplained=modes.unexplained(len(first.sensors)),
        notes=(*(note for one in taken for note in one.remarks), *modes.notes, *remarks),
        recordings=tuple(
            (str(one.test.id), one.test.require_recording().name, one.sha256) for one in taken
        ),
        wireframe=first.test.geometry,
    )


def _identified(
    taken: Sequence[Gathered], inputs: Sequence[FloatArray], settings: Settings
) -> tuple[ModeSet, spectra.CrossSpectra, Functions | None]:
    """Return the modes, spectra of inputs, then responses, and response functions."""
    blows = [one.struck for one in taken if one.struck is not None]
    if blows:
        found, functions = identify_blows(blows, taken[0].sample_rate, settings)
        return found, blows[0].cross, functions
    rate = taken[0].sample_rate
    records = [(rows, one.responses) for rows, one in zip(inputs, taken, strict=True)]
    cross = cross_of(records, rate)
    if inputs[0].shape[0]:
        modes = identify_records(records, rate, settings)
    else:
        modes = identify_output_only(taken[0].responses, rate, settings)
    return modes, cross, functions_of(cross, records, settings.band, modes)


def analyse_functions(measured: ResponseFunctions, wish: Modal) -> ModalAnalysis:
    """Return the modes of measured response functions, as those of one test.

    Parameters
    ----------
    measured : ResponseFunctions
        Of one structure; functions of one response to several inputs are taken the other way
        round, by reciprocity.
    wish : Modal
        How modes are looked for.

    Raises
    ------
    SpectrumError
        If the lines are not even, or do not hold the band.
    """
    notes = list(measured.notes)
    if len(measured.responses) == 1 and len(measured.inputs) > 1:
        measured = measured.turned
        notes.append(
            f"{measured.inputs[0]} answers to {len(measured.responses)} inputs: by reciprocity "
            "the shapes are those of the places of the inputs"
        )
    one = _analysed(measured, wish, notes)
    tracks = tracks_of([one.modes], [one.sensor_names])
    pairs = reciprocals_of([one])
    problems = tuple(pair.problem for pair in pairs if pair.problem)
    return ModalAnalysis(measured.name, (one,), tracks, (), problems, pairs)


def _analysed(measured: ResponseFunctions, wish: Modal, notes: list[str]) -> TestModes:
    band = _band(measured, wish)
    settings = Settings(band, wish.modes, wish.order, wish.keep)
    try:
        modes = identify_functions(measured.frequency, measured.values, settings)
    except ValueError as error:
        raise SpectrumError(f"{measured.name}: {error}") from error
    units = zip(measured.responses, measured.response_units, strict=True)
    sensors = tuple(Channel(name, unit, name, unit, role="response") for name, unit in units)
    inside = (measured.frequency >= band[0]) & (measured.frequency <= band[1])
    lines = measured.frequency[inside]
    remarks = remarks_of(
        sensors, measured.positions, modes, incomplete=False,
        places="export the nodes (data set 15 or 2411) with the functions",
        wireframe=measured.wireframe,
    )  # fmt: skip
    if measured.coherence is None:
        notes.append("the file holds no coherence: noise is told by the fit alone")
    return TestModes(
        name=measured.name,
        test=Test(id=measured.name),
        sensors=sensors,
        positions=measured.positions,
        directions=measured.directions,
        inputs=measured.inputs,
        input_units=measured.input_units,
        input_places=measured.input_places,
        band=band,
        modes=modes,
        functions=_shown(measured, modes, inside),
        density=np.vstack([lines, np.full((len(sensors), lines.size), np.nan)]),
        unexplained=modes.unexplained(len(sensors)),
        notes=(*notes, *modes.notes, *remarks),
        recordings=((measured.name, measured.name, measured.sha256),),
        wireframe=measured.wireframe,
    )


def _band(measured: ResponseFunctions, wish: Modal) -> tuple[float, float]:
    """Return where modes are looked for [Hz]: all lines but the lowest, where nobody says it.

    Raises
    ------
    SpectrumError
        If the lines are not even, or do not reach there.
    """
    lines = measured.frequency
    step = float(lines[-1] - lines[0]) / (lines.size - 1)
    even = lines[0] + step * np.arange(lines.size)
    if np.max(np.abs(lines - even)) > SAME_LINE * step:
        raise SpectrumError(
            f"{measured.name}: its lines are not evenly spaced, as a modal fit needs them. "
            "Export the functions of an FFT, not of a stepped sine or octaves."
        )
    lowest, highest = max(float(lines[0]), DEFAULT_BAND[0] * step), float(lines[-1])
    low, high = wish.band or (lowest, highest)
    if not float(lines[0]) - step <= low < high <= highest + step:
        raise SpectrumError(
            f"{measured.name}: the band from {low:g} to {high:g} Hz lies outside its lines, "
            f"{lines[0]:g} to {highest:g} Hz. Correct --from-hz and --to-hz."
        )
    return low, high


def _shown(
    measured: ResponseFunctions, modes: ModeSet, inside: NDArray[np.bool_]
) -> Functions | None:
    """Return the functions, measured and of the modal model, within the band."""
    if modes.model is None:
        return None
    lines, values = measured.frequency[inside], measured.values[..., inside]
    coherence = np.full((values.shape[0], lines.size), np.nan)
    if measured.coherence is not None:
        coherence = np.min(measured.coherence[..., inside], axis=1)
    model = response_functions(modes.model, lines)[:, 0].reshape(values.shape)
    return Functions(lines, values, model, coherence)
