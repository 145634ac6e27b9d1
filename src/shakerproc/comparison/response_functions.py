r"""A model's response functions beside measured ones, line by line.

.. math:: H(\omega) = (i\omega)^q\, s^T (K - \omega^2 M + i\omega C)^{-1} b, \qquad
    e = \sqrt{\frac{\sum \gamma^2 |H - H_\mathrm{meas}|^2}{\sum \gamma^2 |H_\mathrm{meas}|^2}}

with the coherence :math:`\gamma^2` where it was measured, else 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.errors import frac
from shakerproc.comparison.modes import ComparedModes, beside_model
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import DiagnosisError, ShakerprocError
from shakerproc.modal.from_measurements import analyse_functions
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import Coordinates, coordinates_of
from shakerproc.models.laws import Law
from shakerproc.models.model import Sensor
from shakerproc.recordings.response_functions import ResponseFunctions
from shakerproc.testlog import Modal

AT_ONCE: Final = 64
"""Lines whose equations are solved at once: 64 of 200 coordinates take 40 MB."""

_QUANTITIES: Final = {"m/s^2": "acceleration", "m/s": "velocity", "m": "displacement"}
_RATES: Final = {"displacement": 0, "velocity": 1, "acceleration": 2}


@final
@dataclass(frozen=True, slots=True, eq=False)
class ComparedFunction:
    """A measured response function and the model's.

    Attributes
    ----------
    response, input : str
        Names as the file has them.
    units : (str, str)
        SI units of response and input.
    measured, model : (n_lines,) complex array
        In the band [response unit/input unit].
    coherence : (n_lines,) array, optional
        Of the measured one [-].
    """

    response: str
    input: str
    units: tuple[str, str]
    measured: ComplexArray
    model: ComplexArray
    coherence: FloatArray | None

    @property
    def error(self) -> float:
        """Residual rms over measured rms, lines weighted by the coherence [-]."""
        weight = np.ones(self.measured.size) if self.coherence is None else self.coherence
        left = np.sum(weight * np.abs(self.model - self.measured) ** 2)
        return float(np.sqrt(left / np.sum(weight * np.abs(self.measured) ** 2)))

    @property
    def frac(self) -> float:
        """Frequency response assurance criterion [-]."""
        return frac(self.measured, self.model)


@final
@dataclass(frozen=True, slots=True, eq=False)
class FunctionComparison:
    """The response functions of a file beside those of a model.

    Attributes
    ----------
    model : Model
        Its linear part is compared.
    measured : ResponseFunctions
        The file.
    frequency : (n_lines,) array
        Compared lines [Hz].
    functions : tuple of ComparedFunction
        By input, then response.
    modes : ComparedModes, optional
        Modes of the functions beside the model's; None where they could not be found.
    notes : tuple of str
        What was left out, a sentence each.
    """

    model: Model
    measured: ResponseFunctions
    frequency: FloatArray
    functions: tuple[ComparedFunction, ...]
    modes: ComparedModes | None
    notes: tuple[str, ...]

    @property
    def error(self) -> float:
        """Root of the mean of the squared errors of all functions [-]."""
        return float(np.sqrt(np.mean([one.error**2 for one in self.functions])))

    def peak(self, values: ComplexArray) -> float:
        """Return the frequency of the largest magnitude of a function [Hz]."""
        return float(self.frequency[int(np.argmax(np.abs(values)))])

    @property
    def sentence(self) -> str:
        """How far the model is off, and where most."""
        worst = max(self.functions, key=lambda one: one.error)
        return (
            f"The model leaves {self.error:.1%} rms of {len(self.functions)} response "
            f"functions "
            f"from {self.frequency[0]:.4g} to {self.frequency[-1]:.4g} Hz, most "
            f"of {worst.response} to {worst.input}: {worst.error:.1%}, FRAC {worst.frac:.3f}."
        )


def compare_functions(
    model: Model,
    measured: ResponseFunctions,
    places: Mapping[str, str],
    wish: Modal,
) -> FunctionComparison:
    """Return measured response functions beside those of a model.

    Parameters
    ----------
    model : Model
        Joints that are not linear are left out, with a note.
    measured : ResponseFunctions
        Of a file; its names are sensors or places of the model, or are told in `places`.
    places : mapping
        Sensor or place of the model, or ``base``, by the name in the file.
    wish : Modal
        How modes are looked for; its band is what is compared.

    Raises
    ------
    DiagnosisError
        If no function is one of the model's.
    """
    linear = coordinates_of(model)
    responses, told = _responses(model, linear, measured, places)
    loads, more = _loads(model, linear, measured, places)
    notes = [*measured.notes, *told, *more, *_left_out(model)]
    inside = measured.frequency > 0.0
    if wish.band is not None:
        low, high = wish.band
        inside &= (measured.frequency >= low) & (measured.frequency <= high)
    if not inside.any():
        raise DiagnosisError(
            f"{measured.name}: no line lies in the band. Correct --from-hz and --to-hz."
        )
    lines = measured.frequency[inside]
    functions = []
    for column, load in loads.items():
        values = model_functions(linear, list(responses.values()), load, lines)
        for row, one in zip(responses, values, strict=True):
            coherence = None if measured.coherence is None else measured.coherence[row, column]
            functions.append(
                ComparedFunction(
                    measured.responses[row], measured.inputs[column],
                    (measured.response_units[row], measured.input_units[column]),
                    measured.values[row, column, inside], one,
                    None if coherence is None else coherence[inside],
                )
            )  # fmt: skip
    modes = None
    try:
        modes = _modes(model, measured, responses, wish)
    except ShakerprocError as error:
        notes.append(f"Modes are not compared: {error}")
    return FunctionComparison(model, measured, lines, tuple(functions), modes, tuple(notes))


@final
@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """Forces of a unit of an input, and whether it is the motion of the base."""

    forces: FloatArray
    moves_base: bool


def model_functions(
    linear: Coordinates, responses: Sequence[Sensor], load: Load, frequency: FloatArray
) -> ComplexArray:
    """Return the response functions of the linear part of a model to one input.

    Parameters
    ----------
    linear : Coordinates
        The model.
    responses : sequence of Sensor
        What is measured; faults are left out.
    load : Load
        The input.
    frequency : (n_lines,) array
        Above 0 [Hz].

    Returns
    -------
    (n_responses, n_lines) complex array
        [response unit/input unit].
    """
    omega = 2.0 * np.pi * frequency
    rows = np.array([linear.at(sensor.at) for sensor in responses]).reshape(len(responses), -1)
    motion = np.empty((len(responses), frequency.size), dtype=np.complex128)
    for first in range(0, frequency.size, AT_ONCE):
        w = omega[first : first + AT_ONCE, np.newaxis, np.newaxis]
        matrix = linear.stiffness - w**2 * np.diag(linear.mass) + 1j * w * linear.damping
        found = np.linalg.solve(matrix, load.forces[np.newaxis, :, np.newaxis].astype(complex))
        motion[:, first : first + AT_ONCE] = rows @ found[..., 0].T
    base = [load.moves_base and not one.measures.startswith("relative") for one in responses]
    motion -= np.outer(base, 1.0 / omega**2)
    rates = np.array([_RATES[one.measures.removeprefix("relative ")] for one in responses])
    return np.asarray(motion * (1j * omega) ** rates[:, np.newaxis])


def _responses(
    model: Model, linear: Coordinates, measured: ResponseFunctions, places: Mapping[str, str]
) -> tuple[dict[int, Sensor], list[str]]:
    """Return the sensor of each response, by its number, and a note on others.

    Raises
    ------
    DiagnosisError
        If none is one of the model's.
    """
    found: dict[int, Sensor] = {}
    left = []
    for row, (name, unit) in enumerate(
        zip(measured.responses, measured.response_units, strict=True)
    ):
        wanted = places.get(name, name)
        quantity = _QUANTITIES.get(unit)
        sensor = model.sensors.get(wanted)
        if sensor is None and quantity and (wanted == BASE or wanted in linear.places):
            sensor = Sensor(wanted, quantity)  # type: ignore[arg-type]
        if sensor is None or sensor.measures.removeprefix("relative ") != quantity:
            left.append(name)
        else:
            found[row] = sensor
    if not found:
        raise DiagnosisError(_nothing(model, linear, measured.responses, "response"))
    told = f"Not in the model, or of another quantity there: {', '.join(left[:20])}."
    return found, [told] * bool(left)


def _loads(
    model: Model, linear: Coordinates, measured: ResponseFunctions, places: Mapping[str, str]
) -> tuple[dict[int, Load], list[str]]:
    """Return the forces of each input, by its number, and what is left out.

    Raises
    ------
    DiagnosisError
        If none is one of the model's.
    """
    found: dict[int, Load] = {}
    left = []
    for column, (name, unit) in enumerate(
        zip(measured.inputs, measured.input_units, strict=True)
    ):
        wanted = places.get(name, name)
        sensor = model.sensors.get(wanted)
        at = wanted if sensor is None else sensor.at
        if unit == "m/s^2" and model.excitation.moves_base and at == BASE:
            found[column] = Load(linear.load, moves_base=True)
        elif unit == "N" and at in linear.places:
            found[column] = Load(linear.places[at], moves_base=False)
        else:
            left.append(name)
    if not found:
        raise DiagnosisError(_nothing(model, linear, measured.inputs, "input"))
    return found, [f"Inputs that the model has not: {', '.join(left[:20])}."] * bool(left)


def _nothing(model: Model, linear: Coordinates, names: Sequence[str], what: str) -> str:
    """Return the names that do not fit, those that would, and how to bring them together."""
    known = [*model.sensors, *linear.places]
    return (
        f"{model.title}: no {what} of the file is one of the model: the file has "
        f"{', '.join(names[:8])}; the model has {', '.join(dict.fromkeys([*known, BASE]))}. "
        f"Say which is which: --at '{names[0]}={known[0] if known else BASE}'."
    )


def _left_out(model: Model) -> list[str]:
    """Return a note on the joints of a model that are not linear."""
    linear = {Law.LINEAR, Law.ATTACHED}
    bent = [e for e in model.elements if not {row.law for row in e.effect.rows()} <= linear]
    named = ", ".join(f"{e.effect.kind} between {' and '.join(e.between)}" for e in bent)
    return [f"Left out of the model, not linear: {named}."] * bool(bent)


def _modes(
    model: Model, measured: ResponseFunctions, responses: Mapping[int, Sensor], wish: Modal
) -> ComparedModes:
    """Return the modes of the functions beside those of the model."""
    found = analyse_functions(measured, wish).tests[0]
    moving = {
        measured.responses[row]: sensor.at
        for row, sensor in responses.items()
        if sensor.at != BASE
    }
    return beside_model(model, found, moving, measured.name)
