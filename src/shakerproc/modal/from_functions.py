"""Modes of measured response functions, as an analyser exports them."""

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import Channel
from shakerproc.errors import SpectrumError
from shakerproc.modal.analysis import Functions, ModalAnalysis, TestModes
from shakerproc.modal.gathering import DEFAULT_BAND, remarks_of
from shakerproc.modal.identification import identify_functions
from shakerproc.modal.modal_model import ModeSet, Settings, response_functions
from shakerproc.modal.reciprocity import reciprocals_of
from shakerproc.modal.tracking import tracks_of
from shakerproc.recordings.response_functions import SAME_LINE, ResponseFunctions
from shakerproc.testlog import Modal, Test


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
    told = tuple(pair.problem for pair in pairs if pair.problem)
    return ModalAnalysis(measured.name, (one,), tracks, (), told, pairs)


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
