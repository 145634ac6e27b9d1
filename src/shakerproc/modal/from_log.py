"""The tests of a log, modally analysed: which channels, which band, what is in the way."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import spectra
from shakerproc.data import ChannelUse, FloatArray, Recording
from shakerproc.errors import ShakerprocError, SpectrumError
from shakerproc.modal.analysis import Functions, ModalAnalysis, Place, TestModes
from shakerproc.modal.choosing import (
    SINGLE_FREQUENCIES,
    band_of,
    inputs_of,
    remarks_of,
    responses_of,
)
from shakerproc.modal.identification import identify_samples
from shakerproc.modal.modal_model import response_functions
from shakerproc.modal.mode_set import ModeSet, Settings
from shakerproc.modal.output_only import identify_output_only
from shakerproc.modal.reciprocity import reciprocals_of
from shakerproc.modal.struck import identify_blows
from shakerproc.modal.tracking import common, tracks_of
from shakerproc.runs import find_crop, open_test
from shakerproc.runs.roles import uses_of
from shakerproc.testlog import Modal, Test, TestLog

SHOWN_SEGMENTS: Final = 8
"""Segments without overlap of which measured response functions are averages."""

MOST_SEGMENT: Final = 2**15
"""Samples of such a segment at most."""


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
    jobs = [(log, test, wish, str(test.id)) for test in tests]
    if against is not None:
        other, more = against
        jobs += [(other, test, other.modal, f"{other.path.stem}:{test.id}") for test in more]
    found: list[TestModes] = []
    failed: list[tuple[str, str]] = []
    for owner, test, wanted, name in jobs:
        try:
            found.append(replace(analyse_test(owner, test, wanted), name=name))
        except ShakerprocError as error:
            failed.append((name, str(error)))
        progress(name)
    tracks = tracks_of([one.modes for one in found], [one.sensor_names for one in found])
    pairs = reciprocals_of(found)
    notes = (*_unequal(found), *(pair.problem for pair in pairs if pair.problem))
    return ModalAnalysis(log.title, tuple(found), tracks, tuple(failed), notes, pairs)


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
    with open_test(log, test) as recording:
        try:
            return _analysed(recording, test, wish)
        except ValueError as error:
            raise SpectrumError(f"{recording.run}: {error}") from error


def _analysed(recording: Recording, test: Test, wish: Modal) -> TestModes:
    if test.excitation in SINGLE_FREQUENCIES:
        raise SpectrumError(
            f"{recording.run}: excitation: {test.excitation} reaches single frequencies, which "
            "tell no modes; use random, a sweep or a shock"
        )
    band = band_of(recording, test, wish)
    crop = find_crop(recording, test)
    samples = recording.source.read(recording.rows, crop.start, crop.stop)
    groups = inputs_of(recording, wish)
    taken = {row for _, rows in groups for row in rows}
    rows = responses_of(recording, taken)
    settings = Settings(band, wish.modes, wish.order, wish.keep)
    sensors = tuple(recording.channels[row] for row in rows)
    functions: Functions | None
    if groups and test.struck:
        modes, cross, functions = identify_blows(recording, test, rows, settings)
    else:
        inputs, responses = _inputs(samples, groups), samples[rows]
        rate = recording.sample_rate
        modes = _identified(inputs, responses, rate, settings)
        cross = _cross(inputs, responses, rate)
        functions = _functions(cross, inputs, rate, band, modes)
    uses = uses_of(recording, test)
    return TestModes(
        name=str(test.id),
        test=test,
        sensors=sensors,
        positions=tuple(uses[row].position if uses else None for row in rows),
        directions=tuple(uses[row].direction if uses else None for row in rows),
        inputs=tuple(name for name, _ in groups),
        input_places=tuple(_place(recording, members, uses) for _, members in groups),
        band=band,
        modes=modes,
        functions=functions,
        density=_density(cross, len(groups), band),
        unexplained=_unexplained(modes, len(rows)),
        notes=(*modes.notes, *remarks_of(recording, sensors, uses, rows, modes)),
        sha256=recording.file.sha256() if recording.file is not None else "",
    )


def _place(
    recording: Recording, members: tuple[int, ...], uses: Sequence[ChannelUse]
) -> tuple[Place | None, Place | None]:
    """Return position and direction of a force; the mean of controls acts in no one place."""
    if not uses or recording.channels[members[0]].role != "force":
        return None, None
    return uses[members[0]].position, uses[members[0]].direction


def _inputs(samples: FloatArray, groups: Sequence[tuple[str, tuple[int, ...]]]) -> FloatArray:
    """Return the mean of the channels of each input, (n_inputs, n_samples) array."""
    if not groups:
        return np.zeros((0, samples.shape[1]))
    return np.stack([samples[list(members)].mean(axis=0) for _, members in groups])


def _identified(
    inputs: FloatArray, responses: FloatArray, sample_rate: float, settings: Settings
) -> ModeSet:
    if not inputs.shape[0]:
        return identify_output_only(responses, sample_rate, settings)
    return identify_samples(inputs, responses, sample_rate, settings)


def _cross(
    inputs: FloatArray, responses: FloatArray, sample_rate: float
) -> spectra.CrossSpectra:
    """Return the spectra of inputs, then responses, of which functions are drawn."""
    return spectra.cross_spectra(
        np.concatenate([inputs, responses]),
        sample_rate,
        segment=_segment(inputs.shape[1]),
        window="periodic hann",
        detrend="mean",
    )


def _segment(n_samples: int) -> int:
    most = min(n_samples // SHOWN_SEGMENTS, MOST_SEGMENT)
    return max(8, 1 << max(most.bit_length() - 1, 3))


def _functions(
    cross: spectra.CrossSpectra,
    inputs: FloatArray,
    sample_rate: float,
    band: tuple[float, float],
    modes: ModeSet,
) -> Functions | None:
    """Return response functions, measured and synthesised through the same window."""
    if modes.model is None:
        return None
    n_inputs = inputs.shape[0]
    rows = range(n_inputs, cross.n_channels)
    frequency = scipy.fft.rfftfreq(inputs.shape[1], 1.0 / sample_rate)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    synthesis = np.zeros((len(rows), frequency.size), dtype=np.complex128)
    synthesis[:, inside] = np.einsum(
        "oif,if->of",
        response_functions(modes.model, frequency[inside]),
        scipy.fft.rfft(inputs)[:, inside],
    )
    answer = scipy.fft.irfft(synthesis, inputs.shape[1])
    model = spectra.cross_spectra(
        np.concatenate([inputs, answer]),
        sample_rate,
        segment=cross.segment,
        window="periodic hann",
        detrend="mean",
    )
    edge = 2.0 * cross.bin_width  # where the window mixes in what lies outside the band
    shown = (cross.frequency >= band[0] + edge) & (cross.frequency <= band[1] - edge)
    driven = range(n_inputs)
    return Functions(
        cross.frequency[shown],
        spectra.h1_of_inputs(cross, driven, rows)[..., shown],
        spectra.h1_of_inputs(model, driven, rows)[..., shown],
        spectra.multiple_coherence(cross, driven, rows)[..., shown],
    )


def _density(
    cross: spectra.CrossSpectra, n_inputs: int, band: tuple[float, float]
) -> FloatArray:
    shown = (cross.frequency >= band[0]) & (cross.frequency <= band[1])
    return np.concatenate([
        cross.frequency[np.newaxis, shown],
        spectra.psd(cross)[n_inputs:, shown],
    ])


def _unexplained(modes: ModeSet, n_responses: int) -> FloatArray:
    if modes.model is None:
        return np.full(n_responses, np.nan)
    return modes.model.unexplained
