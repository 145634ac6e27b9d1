"""The response of a model to an input that is in memory."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ArgumentError
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.runs.result import shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.simulation import SimulatedResponse as Simulated
from shakerproc.simulation import simulate as simulated
from shakerproc.workflows.arguments import positive_of, switch_of, told
from shakerproc.workflows.given_models import model_of
from shakerproc.workflows.shown import Shown, frame, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Simulation(Shown):
    """The response of a model, and how far it can be trusted.

    Attributes
    ----------
    model : Model
        What was shaken.
    found : shakerproc.simulation.Simulation
        Motion of every mass, outputs of every sensor, error and growth, in SI units.
    """

    model: Model
    found: Simulated

    def to_pandas(self) -> "DataFrame":
        """Return time, input and the output of every sensor, with their units in the names."""
        columns: dict[str, FloatArray] = {"time_s": self.found.time}
        for name, (unit, samples) in self._signals().items():
            shown, factor = shown_unit(unit)
            columns[f"{name}{spelled(shown)}"] = samples * factor
        return frame(columns)

    def plot(self) -> "Figure":
        """Return input and outputs against time."""
        from shakerproc.report.runs.recording import signals

        shown = []
        for name, (unit, samples) in self._signals().items():
            said, factor = shown_unit(unit)
            shown.append((name, said, samples * factor))
        return signals(self.model.title, self.found.time, shown)

    def _signals(self) -> dict[str, tuple[str, FloatArray]]:
        """Return the SI unit and the samples of the input and of every sensor."""
        signals = {"input": (self.model.drive_unit, self.found.excitation)}
        for name, sensor in self.model.sensors.items():
            signals[name] = (self.model.sensor_unit(sensor), self.found.outputs[name])
        return signals

    def _repr_html_(self) -> str:
        found = self.found
        sentence = (
            f"{found.time.size} samples at {found.sample_rate:.6g} Hz by {found.solver}, "
            f"{found.switchings} switchings, estimated error {numeral(found.error, 2)} of the "
            "largest displacement"
        )
        chaotic = "chaotic motion: any model agrees with it in statistics only"
        rows = [
            (name, unit, float(np.sqrt(np.mean(samples**2))), float(np.max(np.abs(samples))))
            for name, (unit, samples) in self._signals().items()
        ]
        table = frame_of_rows(("signal", "unit", "rms", "largest"), rows)
        remarks = [*found.notes, chaotic if found.chaotic else ""]
        return html(self.model.title, [sentence, *remarks], table)


def simulate(
    model: Any,
    excitation: FloatArray | Sequence[float] | Callable[[FloatArray], FloatArray],
    sample_rate: float,
    *,
    duration: float | None = None,
    growth: bool = True,
) -> Simulation:
    """Return the response of a model to an input.

    Parameters
    ----------
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    excitation : (n,) array, or function of time
        The input in SI units: acceleration of the base [m/s^2], force [N] or imposed
        displacement [m], as the model says; a function takes times [s].
    sample_rate : float
        Samples per second, of the input and of the response [Hz].
    duration : float, optional
        How long a function is followed [s].
    growth : bool
        Whether to run twice, to tell how a disturbance grows.

    Raises
    ------
    ArgumentError
        If an argument is of another kind, not finite, or does not fit the others.
    SimulationError
        If the motion runs away, or cannot be followed.
    """
    shaken = model_of(model).model
    given = excitation if callable(excitation) else _samples(excitation)
    rate = positive_of("sample_rate", sample_rate)
    if callable(excitation) != (duration is not None):
        raise ArgumentError("duration", "goes with a function of time, and only with one")
    length = None if duration is None else positive_of("duration", duration)
    again = switch_of("growth", growth)
    try:
        found = simulated(shaken, given, rate, duration=length, growth=again)
    except ValueError as error:
        raise ArgumentError("excitation", str(error)) from error
    return Simulation(shaken, found)


def _samples(given: Any) -> FloatArray:
    wanted = "expected an array of samples, or a function of time"
    try:
        samples = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentError("excitation", f"{wanted}, got {told(given)}") from error
    if samples.ndim != 1 or samples.size == 0:
        raise ArgumentError("excitation", f"{wanted}, got one of shape {samples.shape}")
    if not np.all(np.isfinite(samples)):
        first = int(np.flatnonzero(~np.isfinite(samples))[0])
        raise ArgumentError("excitation", f"sample {first} is {samples[first]}; fill the gap")
    return samples
